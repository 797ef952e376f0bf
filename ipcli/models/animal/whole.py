"""The whole animal: all parts as one closed surface that knows which part each face belongs to (thesis 6.4, end)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ipcli.errors import NoSolution
from ipcli.geometry import level_sets, meshes
from ipcli.geometry.orthographic import Orthographic
from ipcli.geometry.voxels import Sight, VoxelGrid, hull
from ipcli.measurements.part_images import PartImage, PartTree, pixels_of
from ipcli.models.animal import rims, union
from ipcli.models.animal.aspects import lift_all
from ipcli.models.animal.parameters import Modelling, Volume
from ipcli.models.animal.parts import Shot, all_lean, carve, is_one_line, rounded, untold_depth

MAJORITY = 3  # times that a face takes the part of most of its neighbours
BESIDE_RIMS = 3.0  # voxels from where a ray comes nearest to a drawn surface: what it lacks is added nearer
SLACK = 1.0  # voxels by which the flow may leave the union of the parts
STRETCH = 3.0  # most by which a hull that is longer than the animal makes the grid finer
COARSE = 48  # points along each side of the grid that finds where the animal is


@dataclass(frozen=True, eq=False)
class PartedSurface:
    """A closed mesh: vertices (n, 3) float32, faces (m, 3) int32, the part of each face (m,) int16, and closed meshes
    of the single parts by index.
    """

    vertices: np.ndarray
    faces: np.ndarray
    face_part: np.ndarray
    parts: dict[int, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)


def model(
    images: Sequence[PartImage], cameras: Sequence[Orthographic], tree: PartTree, params: Modelling
) -> PartedSurface:
    """One surface from images of one pose with their cameras. NoSolution if the silhouettes have nothing in common."""
    lifted = {key: aspect.picture for key, aspect in lift_all(images, tree, params.inflation).items()}
    fields, shots, grid = parts_of(images, cameras, tree, lifted, params.volume)
    return surface(fields, shots, grid, params.volume)


def parts_of(
    images: Sequence[PartImage],
    cameras: Sequence[Orthographic],
    tree: PartTree,
    heights: Mapping[tuple[str, int], np.ndarray],
    params: Volume,
) -> tuple[list[np.ndarray], list[Shot], VoxelGrid]:
    """The field of each part, from images of one pose and the half thickness (h, w) of each part in each of them."""
    grid = grid_of(images, cameras, params.voxels)
    shots = shots_of(images, cameras, grid)
    carved = carve(shots, tree)
    if params.merge == "union":
        return union.united(carved, shots, grid, heights, params.field), shots, grid
    return rounded(carved, shots, heights), shots, grid


def shots_of(images: Sequence[PartImage], cameras: Sequence[Orthographic], grid: VoxelGrid) -> list[Shot]:
    """The images with their cameras, ready to look into a grid."""
    return [Shot(image, camera, Sight.of(grid, camera)) for image, camera in zip(images, cameras, strict=True)]


def grid_of(images: Sequence[PartImage], cameras: Sequence[Orthographic], voxels: int) -> VoxelGrid:
    """The grid around the visual hull, with so many voxels along its longest side.

    Where oblique views leave the hull longer than any silhouette, the longest silhouette counts in its place.
    Views along one line, which nothing bounds, are given the depth of `parts.untold_depth`.
    """
    middle = np.mean([c.lift(_middle(i.silhouette), 0.0) for i, c in zip(images, cameras, strict=True)], axis=0)
    reach = max(max(image.silhouette.shape) / camera.scale for image, camera in zip(images, cameras, strict=True))
    rough = VoxelGrid(middle - reach, 2 * reach / COARSE, (COARSE + 1,) * 3)
    field = hull([Sight.of(rough, c) for c in cameras], [i.silhouette for i in images])
    inside = np.argwhere(field < 1.0)
    if not len(inside):
        raise NoSolution(
            "the silhouettes have nothing in common: check the `view` of each image, and mark what shows another pose "
            'with pose = "other"'
        )
    depth = untold_depth(images, cameras)
    if depth is not None:
        along = cameras[0].depth(rough.origin + rough.spacing * inside)
        inside = inside[np.abs(along) <= depth / 2 + rough.spacing]
    low = rough.origin + rough.spacing * (inside.min(axis=0) - 1)
    high = rough.origin + rough.spacing * (inside.max(axis=0) + 1)
    axis = int(np.argmax(np.abs(cameras[0].direction)))
    if depth is not None and is_one_line([cameras[0].direction, np.eye(3)[axis]]):
        low[axis], high[axis] = -depth / 2, depth / 2
    longest = float((high - low).max())
    shown = max(extent_of(image, camera) for image, camera in zip(images, cameras, strict=True))
    longest = max(min(longest, shown + 4 * rough.spacing), longest / STRETCH)  # the box has two to spare on each side
    return VoxelGrid.around(low, high, longest / voxels)


def extent_of(image: PartImage, camera: Orthographic) -> float:
    """The longer side of an image's silhouette, in units of the world."""
    return float(np.ptp(pixels_of(image.silhouette), axis=0).max()) / camera.scale


def _middle(mask: np.ndarray) -> np.ndarray:
    rows, columns = np.nonzero(mask)
    return np.array([columns.min() + columns.max(), rows.min() + rows.max()]) / 2


def surface(
    fields: Sequence[np.ndarray],
    shots: Sequence[Shot],
    grid: VoxelGrid,
    params: Volume,
    is_drawn: bool = False,
) -> PartedSurface:
    """Merge the fields of all parts, round the whole, and mesh it and each part. NoSolution if nothing is left.

    `is_drawn` says that the fields are those of a surface that was drawn to the outlines. Where all views lean to each
    other, what it lacks of them is added there and nowhere else, for a hull that leans bounds no depth.
    """
    reach = BESIDE_RIMS if is_drawn and all_lean([shot.camera.direction for shot in shots]) else np.inf
    phi = merged(fields, shots, params, reach)
    if not (phi < 0).any():
        raise NoSolution("the masks leave no body: they are too small or too thin, or their views do not fit together")
    solid = level_sets.largest(level_sets.fill(phi < 0))
    phi = np.where(solid, np.minimum(phi, -level_sets.LEAST), np.where(phi < 0, level_sets.LEAST, phi))
    vertices, faces = level_sets.mesh(phi, grid.spacing, grid.origin)
    vertices = vertices.astype(np.float32)
    guessed = labels_at(fields, grid, vertices[faces].mean(axis=1))
    labels = voted_labels(vertices.astype(np.float64), faces, guessed, shots, len(fields))
    return PartedSurface(vertices, faces.astype(np.int32), labels, closed_parts(fields, phi, grid))


def merged(fields: Sequence[np.ndarray], shots: Sequence[Shot], params: Volume, reach: float = np.inf) -> np.ndarray:
    """The field of the whole, rounded as `params.merge` says; `reach` as `rims.keep_rims` takes it."""
    least = np.minimum.reduce(list(fields)).astype(np.float32)
    if params.merge == "union":
        return union.smoothed(least, params.rounding).astype(np.float32)
    if params.merge == "clip":
        return level_sets.flow(least, params.rounding * level_sets.STABLE).astype(np.float32)
    sights = [shot.sight for shot in shots]
    outlines = [shot.sight.silhouette_distance(shot.image.silhouette) for shot in shots]
    whole = np.maximum.reduce(outlines)
    wanted = [rims.wanted_depth(sight, rim) for sight, rim in zip(sights, outlines, strict=True)]
    covered = rims.keep_rims(least, whole, sights, wanted, reach)
    bound = np.maximum(whole, np.minimum(least, covered) - SLACK)
    return rims.round_off(least, bound, sights, outlines, params.rounding, reach)


def labels_at(fields: Sequence[np.ndarray], grid: VoxelGrid, points: np.ndarray) -> np.ndarray:
    """For world points (n, 3) the part (n,) int16 whose field is least."""
    from scipy.ndimage import map_coordinates

    at = ((points - grid.origin) / grid.spacing).T
    values = [map_coordinates(np.asarray(f, np.float32), at, order=1, mode="nearest") for f in fields]
    return np.argmin(values, axis=0).astype(np.int16)


def voted_labels(
    vertices: np.ndarray, faces: np.ndarray, guessed: np.ndarray, shots: Sequence[Shot], parts: int
) -> np.ndarray:
    """The part (m,) int16 of each face: the one that most pixels of the images show there, and `guessed` where no image
    looks; then that of the majority of a face and its three neighbours, so that borders do not fray.
    """
    from scipy.sparse import coo_array

    from ipcli.geometry.part_masks import first_faces

    votes = np.zeros((len(faces), parts))
    for shot in shots:
        labels = shot.image.labels
        met, _ = first_faces(vertices, faces, shot.camera, labels.shape)
        told = (met >= 0) & (labels > 0)
        np.add.at(votes, (met[told], labels[told] - 1), 1.0)
    part = np.where(votes.any(axis=1), np.argmax(votes, axis=1), guessed)
    _, edge = np.unique(meshes.edges(faces), axis=0, return_inverse=True)
    touching = coo_array((np.ones(len(edge)), (np.repeat(np.arange(len(faces)), 3), edge.reshape(-1)))).tocsr()
    for _ in range(MAJORITY):
        shares = touching @ (touching.T @ np.eye(parts)[part])
        part = np.argmax(shares + 0.5 * np.eye(parts)[part], axis=1)
    return part.astype(np.int16)


def closed_parts(
    fields: Sequence[np.ndarray], whole: np.ndarray, grid: VoxelGrid
) -> dict[int, tuple[np.ndarray, np.ndarray]]:
    """A closed mesh of each part inside the whole; parts that came out empty are left out."""
    meshes = {}
    for part, own in enumerate(fields):
        phi = np.maximum(own, whole)
        if not (phi < 0).any():
            continue
        solid = level_sets.largest(phi < 0)
        vertices, faces = level_sets.mesh(
            np.where(solid, phi, np.maximum(phi, level_sets.LEAST)), grid.spacing, grid.origin
        )
        meshes[part] = (vertices.astype(np.float32), faces.astype(np.int32))
    return meshes


def seen_by(surface: PartedSurface, images: Sequence[PartImage], cameras: Sequence[Orthographic]) -> np.ndarray:
    """How many images saw each vertex (n,) uint16: those in which nothing of the surface lies before it."""
    from ipcli.geometry.part_masks import render

    count = np.zeros(len(surface.vertices), np.uint16)
    vertices = surface.vertices.astype(np.float64)
    slack = 0.01 * float(np.linalg.norm(np.ptp(vertices, axis=0)))
    for image, camera in zip(images, cameras, strict=True):
        shape = image.labels.shape
        _, depth = render(vertices, surface.faces, surface.face_part + 1, camera, shape)
        count += camera.depth(vertices) <= depth[camera.pixel(vertices, shape)] + slack
    return count


def scaled(
    surface: PartedSurface, cameras: Sequence[Orthographic], size: float
) -> tuple[PartedSurface, list[Orthographic]]:
    """The surface with its longest side `size` long and the middle of its box at the origin, and cameras that see it as
    they did.
    """
    low, high = surface.vertices.min(axis=0).astype(np.float64), surface.vertices.max(axis=0).astype(np.float64)
    middle, factor = (low + high) / 2, size / float((high - low).max())
    moved = replace(
        surface,
        vertices=((surface.vertices - middle) * factor).astype(np.float32),
        parts={k: (((v - middle) * factor).astype(np.float32), f) for k, (v, f) in surface.parts.items()},
    )
    return moved, [Orthographic(c.rotation, c.scale / factor, c.project(middle)) for c in cameras]


def overlap(seen: np.ndarray, rendered: np.ndarray, parts: int) -> tuple[float, np.ndarray]:
    """How far two label images (h, w) agree: pixels of one same part over pixels of any, and that of each part
    (parts,), NaN where neither shows it.
    """
    either = (seen > 0) | (rendered > 0)
    same = (seen == rendered) & either
    each = np.full(parts, np.nan)
    for part in range(parts):
        union = (seen == part + 1) | (rendered == part + 1)
        if union.any():
            each[part] = (same & (seen == part + 1)).sum() / union.sum()
    return float(same.sum() / max(int(either.sum()), 1)), each
