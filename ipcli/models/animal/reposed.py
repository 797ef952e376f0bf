"""Parts whose shape comes from images of another pose: a model of that pose, bent into the reference pose (thesis 6.3).

The other pose's model knows how thick each part is, which few views of the reference pose do not; the reference pose's
silhouettes know where each part ends. So the model is posed, drawn to the outlines, and cut by the visual hull.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ipcli.geometry import meshes
from ipcli.geometry.orthographic import of_view
from ipcli.geometry.voxels import VoxelGrid, hull
from ipcli.measurements.part_images import PartImage, PartTree
from ipcli.models.animal import whole
from ipcli.models.animal.articulation import jointed
from ipcli.models.animal.parameters import Modelling
from ipcli.models.animal.parts import Shot
from ipcli.models.animal.placing import OBLIQUE, placed
from ipcli.models.animal.posing import fit, likeness
from ipcli.models.animal.pulling import pulled
from ipcli.progress import Progress, silent

BESIDE = 0.5  # voxels: least value of a part's field where the body belongs to another part


def tells_shape(others: Sequence[PartImage]) -> bool:
    """Whether images of another pose have names of views along two lines, which it takes to model that pose."""
    lines = [of_view(image.view)[2] for image in others if image.view]
    return any(abs(lines[0] @ line) < OBLIQUE for line in lines[1:])


def reposed(
    others: Sequence[PartImage],
    shots: Sequence[Shot],
    grid: VoxelGrid,
    own: Sequence[np.ndarray],
    tree: PartTree,
    heights: Mapping[tuple[str, int], np.ndarray],
    params: Modelling,
    progress: Progress = silent,
) -> tuple[list[np.ndarray], float]:
    """The field (nx, ny, nz) of each part from images of another pose, and the overlap in [0, 1] of the labels of that
    pose's model with the images of the reference pose once it was bent.

    `own` are the fields that the reference pose gives by itself (see `parts`); a part that the other pose does not show
    keeps its own.
    """
    progress(0.0, "model of the other pose")
    cameras = placed(others, tree, params)
    fields, seen, around = whole.parts_of(others, cameras, tree, heights, params.volume)
    source = whole.surface(fields, seen, around, params.volume)
    rough = whole.surface(own, shots, grid, params.volume)
    progress(0.3, "bending it")
    body = jointed(source.vertices, source.faces, source.face_part, tree)
    images, views = [shot.image for shot in shots], [shot.camera for shot in shots]
    pose = fit(body, jointed(rough.vertices, rough.faces, rough.face_part, tree), images, views)
    progress(0.7, "drawing it to the outlines")
    vertices = pulled(pose.skinned(body), body.faces, body.part[body.segment], images, views)
    progress(0.9, "cutting it")
    bent = fields_of(vertices, body.faces, body.face_part, grid, len(tree))
    outlines = hull([shot.sight for shot in shots], [image.silhouette for image in images])
    shown = np.isin(np.arange(len(tree)), body.part)
    result = [np.maximum(bent[k], outlines) if shown[k] else own[k] for k in range(len(tree))]
    return result, likeness(vertices, body, images, views)


def fields_of(
    vertices: np.ndarray, faces: np.ndarray, face_part: np.ndarray, grid: VoxelGrid, parts: int
) -> list[np.ndarray]:
    """The field (nx, ny, nz) float32, in voxels, of each part of a labelled closed mesh, which may cut itself.

    Inside is what the surface winds around; each point belongs to the part of the nearest face.
    """
    from ipcli.geometry import open3d

    points = grid.points().reshape(-1, 3)
    inside = meshes.contains(vertices, faces, points)
    core = open3d.load().core
    scene = open3d.load().t.geometry.RaycastingScene()
    scene.add_triangles(core.Tensor(vertices.astype(np.float32)), core.Tensor(faces.astype(np.uint32)))
    found = scene.compute_closest_points(core.Tensor(points.astype(np.float32)))
    away = np.linalg.norm(found["points"].numpy() - points, axis=1) / grid.spacing
    field = np.where(inside, -away, away).reshape(grid.shape).astype(np.float32)
    part = face_part[found["primitive_ids"].numpy().astype(np.int64)].reshape(grid.shape)
    return [np.where(part == k, field, np.maximum(field, np.float32(BESIDE))) for k in range(parts)]
