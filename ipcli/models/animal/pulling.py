"""Draw a surface to the outlines of labelled images: rims of each part go to the outline of that part, and the rest of
the surface follows as smoothly as it can.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ipcli.geometry.orthographic import Orthographic
from ipcli.geometry.voxels import signed_distance
from ipcli.measurements.part_images import PartImage

LENGTHS = (0.04, 0.01)  # of the size, over which the surface follows: in the first round and in the last
GRAZING = 0.35  # cosine between normal and view below which a vertex may be on the rim
REACH = 0.06  # of the size: outlines farther away do not pull


def pulled(
    vertices: np.ndarray,
    faces: np.ndarray,
    part: np.ndarray,
    images: Sequence[PartImage],
    cameras: Sequence[Orthographic],
    rounds: int = 6,
) -> np.ndarray:
    """Vertices (n, 3) of a mesh whose vertices belong to parts (n,), moved so that it ends where the images' parts end.

    Each round finds the rims anew and moves them; what is moved least bends (a bi-Laplacian on the displacement).
    """
    import igl

    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    targets = [
        OutlineTarget(camera, image.outlines(), signed_distance(image.silhouette))
        for image, camera in zip(images, cameras, strict=True)
    ]
    corners = np.ascontiguousarray(faces, np.int64)
    for length in np.geomspace(*LENGTHS, rounds):
        normals = igl.per_vertex_normals(np.ascontiguousarray(vertices), corners)
        wanted, told = np.zeros_like(vertices), np.zeros(len(vertices))
        for target in targets:
            target.ask(vertices, normals, part, size, wanted, told)
        if not told.any():
            return vertices
        wanted /= np.maximum(told, 1.0)[:, None]
        vertices = vertices + _smoothly(vertices, corners, wanted, told > 0, length * size)
    return vertices


@dataclass(frozen=True, eq=False)
class OutlineTarget:
    """Where an image wants the rims to be: outlines (m, 2) of its parts, and the distance (h, w) to its silhouette."""

    camera: Orthographic
    outlines: dict[int, np.ndarray]
    outside: np.ndarray

    def ask(
        self,
        vertices: np.ndarray,
        normals: np.ndarray,
        part: np.ndarray,
        size: float,
        wanted: np.ndarray,
        told: np.ndarray,
    ) -> None:
        """Add to `wanted` (n, 3) and `told` (n,) how the image wants the rim to move and how often."""
        from scipy.spatial import cKDTree

        camera = self.camera
        at = camera.project(vertices)
        grazing = np.abs(normals @ camera.direction) < GRAZING
        reach = REACH * size * camera.scale
        facing = normals @ camera.rotation[:2].T
        facing /= np.maximum(np.linalg.norm(facing, axis=1, keepdims=True), 1e-9)

        def across(which: np.ndarray, step: np.ndarray) -> np.ndarray:
            """Steps (m, 2) in pixels as displacements (m, 3) along normals: along the rim nothing is known."""
            told_by = (step * facing[which]).sum(axis=1, keepdims=True) * facing[which]
            return told_by / camera.scale @ camera.rotation[:2]

        for k, outline in self.outlines.items():
            rim = np.flatnonzero(grazing & (part == k))
            if not len(rim):
                continue
            away, nearest = cKDTree(at[rim]).query(outline, distance_upper_bound=reach)
            near = np.isfinite(away)
            asked = rim[nearest[near]]
            np.add.at(wanted, asked, across(asked, outline[near] - at[asked]))
            np.add.at(told, asked, 1.0)
        outside = np.flatnonzero(self.outside[camera.pixel(vertices, self.outside.shape)] > 1.0)
        if len(outside):
            every = np.concatenate(list(self.outlines.values()))
            away, nearest = cKDTree(every).query(at[outside], distance_upper_bound=reach)
            near = np.isfinite(away)
            asked = outside[near]
            wanted[asked] += across(asked, every[nearest[near]] - at[asked])
            told[asked] += 1.0


def _smoothly(
    vertices: np.ndarray, faces: np.ndarray, wanted: np.ndarray, told: np.ndarray, length: float
) -> np.ndarray:
    """The displacement (n, 3) that is as wanted where that is told, and bends least: (M T + l^4 L M^-1 L) d = M T w."""
    import igl
    from scipy.sparse import csc_array, diags_array
    from scipy.sparse.linalg import splu

    stiffness = -igl.cotmatrix(vertices, faces)
    mass = np.maximum(igl.massmatrix(vertices, faces, igl.MASSMATRIX_TYPE_VORONOI).diagonal(), 1e-12)
    bending = stiffness @ diags_array(1 / mass) @ stiffness
    hold = mass * told
    system = csc_array(diags_array(hold + 1e-6 * mass) + length**4 * bending)
    factor = splu(system, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    return factor.solve(hold[:, None] * wanted)
