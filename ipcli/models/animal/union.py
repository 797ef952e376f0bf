"""The parts as the thesis merges them: the union of all aspects of a part, each a closed surface of its own (6.3.2).

The cameras say how the aspects of a part are turned to each other; along its view an aspect lies in the plane that goes
through the middle of where the labels of all images allow the part (an affine map, as the thesis has them: a leg that
leans away from the viewer leans). Beside `parts`, no silhouette cuts it: what one aspect bulges out too far stays.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ipcli.geometry import level_sets
from ipcli.geometry.distances import to_surface
from ipcli.geometry.meshes import contains
from ipcli.geometry.triangulation import reflect, triangulate_mask
from ipcli.geometry.voxels import Sight, VoxelGrid
from ipcli.models.animal.parts import OUTSIDE, Shot, spans

REACH = 4.0  # voxels around an aspect in which its field is known
FLAT = 1e-9  # length of a normal that tells no side
EVERY = 5  # steps of flow between two redistancings


def united(
    carved: Sequence[np.ndarray],
    shots: Sequence[Shot],
    grid: VoxelGrid,
    heights: Mapping[tuple[str, int], np.ndarray],
    field: str,
) -> list[np.ndarray]:
    """The field (nx, ny, nz) in voxels of each part: phi = min(phi_1, ..., phi_n) over its aspects.

    `carved` tells where each part may be, `heights` the half thickness (h, w) in pixels by name of image and part, and
    `field` what a phi is: see `implicit`.
    """
    results = []
    for part, allowed in enumerate(carved):
        own = [
            implicit(*surface, grid, field)
            for shot in shots
            if (shot.image.name, part) in heights
            and (surface := placed_surface(heights[shot.image.name, part], shot, allowed)) is not None
        ]
        results.append(np.minimum.reduce(own) if own else np.full(grid.shape, OUTSIDE))
    return results


def placed_surface(heights: np.ndarray, shot: Shot, allowed: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """The closed surface of an aspect in the world: vertices (n, 3) and faces (m, 3); None for one that is too thin for
    a triangle, or whose part has no place.
    """
    if not (allowed < 0).any():
        return None
    sight = shot.sight
    try:
        points, triangles = triangulate_mask(heights > 0, max(sight.pixels, 1.0))
    except ValueError:
        return None
    vertices, faces = reflect(points, triangles, _sampled(heights, points))
    depth = _depths(allowed, sight, vertices[:, :2]) * sight.pixels + vertices[:, 2]
    return shot.camera.lift(vertices[:, :2], depth / shot.camera.scale), faces


def _sampled(picture: np.ndarray, points: np.ndarray) -> np.ndarray:
    from scipy.ndimage import map_coordinates

    return map_coordinates(picture.astype(np.float64), points.T[::-1], order=1, mode="nearest")


def _depths(allowed: np.ndarray, sight: Sight, pixels: np.ndarray) -> np.ndarray:
    """The depth (n,) in voxels, at pixels (n, 2), of the plane through the middle of a part's place."""
    middle, half = spans(allowed, sight)
    known = half > 0
    corner = np.array([sight.columns.min(), sight.rows.min()])
    cells = np.argwhere(known)[:, ::-1] * sight.pixels + corner
    plane = np.linalg.lstsq(np.column_stack([cells, np.ones(len(cells))]), middle[known])[0]
    return pixels @ plane[:2] + plane[2]


def implicit(vertices: np.ndarray, faces: np.ndarray, grid: VoxelGrid, field: str) -> np.ndarray:
    """The field (nx, ny, nz) float32 in voxels of a closed surface, OUTSIDE farther than REACH around its box.

    "sdf" is the signed distance; "ipf" is <x - p, n> with p the nearest point of the surface and n its outward normal
    (the angle-weighted pseudonormal at edges and corners; the sign is that of what the surface winds around). That is
    our reading of the thesis' inner product field, whose source its text does not give. Both vanish on the surface.
    """
    at = (vertices - grid.origin) / grid.spacing
    low = np.maximum(np.floor(at.min(axis=0) - REACH).astype(int), 0)
    high = np.minimum(np.ceil(at.max(axis=0) + REACH).astype(int) + 1, grid.shape)
    box = tuple(slice(a, b) for a, b in zip(low, high, strict=True))
    points = np.stack(np.meshgrid(*map(np.arange, low, high), indexing="ij"), axis=-1).reshape(-1, 3).astype(np.float64)
    phi = np.full(grid.shape, OUTSIDE)
    away = (to_surface if field == "sdf" else _to_tangent_planes)(points, (at, faces))
    phi[box] = np.where(contains(at, faces, points), -away, away).reshape(phi[box].shape)
    return phi


def _to_tangent_planes(points: np.ndarray, surface: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """|<x - p, n>| (n,); the distance where n is 0, as beside a triangle that lies on its own mirror image."""
    import igl

    kind = igl.SignedDistanceType.SIGNED_DISTANCE_TYPE_PSEUDONORMAL
    signed, _, nearest, normal = igl.signed_distance(points, surface[0], surface[1].astype(np.int64), sign_type=kind)
    length = np.nan_to_num(np.linalg.norm(normal, axis=1))
    told = length > FLAT
    across = np.abs(((points - nearest) * normal).sum(axis=1))
    return np.where(told, across / np.where(told, length, 1.0), np.abs(signed))


def smoothed(phi: np.ndarray, steps: int) -> np.ndarray:
    """The field after mean curvature flow (6.9) with b > 0, made a distance again every few steps."""
    return level_sets.flow(phi, steps * level_sets.STABLE, EVERY)
