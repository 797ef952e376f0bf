"""Implicit surfaces on a regular grid: signed distance, mean curvature flow, closed meshes (thesis 6.3.2, 6.9).

A field is negative inside. Lengths are in voxels throughout.
"""

from __future__ import annotations

import numpy as np

FLOOR = 1e-9  # of the squared gradient
STABLE = 1 / 6  # longest explicit step of the flow, in squared voxels
TANGENT = 1.5  # voxels from the surface within which its tangent plane stands for it
LEAST = 1e-3  # values nearer to 0 are moved off: marching cubes leaves gaps where a surface meets a grid point


def curvature_speed(phi: np.ndarray) -> np.ndarray:
    """kappa |grad phi| at every point of a field (nx, ny, nz), kappa = k1 + k2; the border counts as mirrored."""
    p = np.pad(phi, 1, mode="edge")
    mid = slice(1, -1)

    def at(x: int, y: int, z: int) -> np.ndarray:
        return p[tuple(slice(1 + d, p.shape[a] - 1 + d) for a, d in enumerate((x, y, z)))]

    centre = p[mid, mid, mid]
    px, py, pz = (at(1, 0, 0) - at(-1, 0, 0)) / 2, (at(0, 1, 0) - at(0, -1, 0)) / 2, (at(0, 0, 1) - at(0, 0, -1)) / 2
    pxx = at(1, 0, 0) + at(-1, 0, 0) - 2 * centre
    pyy = at(0, 1, 0) + at(0, -1, 0) - 2 * centre
    pzz = at(0, 0, 1) + at(0, 0, -1) - 2 * centre
    pxy = (at(1, 1, 0) + at(-1, -1, 0) - at(1, -1, 0) - at(-1, 1, 0)) / 4
    pxz = (at(1, 0, 1) + at(-1, 0, -1) - at(1, 0, -1) - at(-1, 0, 1)) / 4
    pyz = (at(0, 1, 1) + at(0, -1, -1) - at(0, 1, -1) - at(0, -1, 1)) / 4
    bent = (pyy + pzz) * px * px + (pxx + pzz) * py * py + (pxx + pyy) * pz * pz
    bent -= 2 * (px * py * pxy + px * pz * pxz + py * pz * pyz)
    return bent / (px * px + py * py + pz * pz + FLOOR)


def flow(phi: np.ndarray, time: float, every: int = 0) -> np.ndarray:
    """The field after mean curvature flow phi_t = kappa |grad phi| for a time in squared voxels (b t of 6.9, b > 0),
    made a distance again before it and `every` so many steps; 0: never.

    A sphere keeps R^2 = R0^2 - 4 t, a cylinder R^2 = R0^2 - 2 t.
    """
    steps = max(1, int(np.ceil(time / STABLE)))
    for step in range(steps if time > 0 else 0):
        if every and step % every == 0:
            phi = redistance(phi)
        phi = phi + (time / steps) * curvature_speed(phi)
    return phi


def redistance(phi: np.ndarray, reach: float = 6.0) -> np.ndarray:
    """The signed distance to the zero set of a field, cut off at `reach`: to the nearest of the points where the field
    crosses zero beside a grid point, found along its gradient; second order where the surface is smooth.
    """
    from scipy.ndimage import distance_transform_edt
    from scipy.spatial import cKDTree

    inside = phi < 0
    if inside.all() or not inside.any():
        return np.where(inside, -reach, reach)
    feet = _feet(phi, inside)
    normals = _normals(phi, feet)
    far = np.where(inside, distance_transform_edt(inside), distance_transform_edt(~inside))
    near = np.argwhere(far <= reach + 1)
    distance, foot = cKDTree(feet).query(near)
    # a foot may lie half a voxel beside the nearest point: close to the surface the tangent plane there tells more
    plane = np.abs(((near - feet[foot]) * normals[foot]).sum(axis=1))
    distance = np.where(distance < TANGENT, plane, distance)
    away = np.full(phi.shape, reach, np.float64)
    away[tuple(near.T)] = np.minimum(distance, reach)
    return np.where(inside, -away, away)


def _normals(phi: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Unit gradients (n, 3) of a field at points (n, 3) of its grid."""
    from scipy.ndimage import map_coordinates

    slopes = np.stack([map_coordinates(g, points.T, order=1, mode="nearest") for g in np.gradient(phi)], axis=1)
    return slopes / np.maximum(np.linalg.norm(slopes, axis=1, keepdims=True), FLOOR)


def _feet(phi: np.ndarray, inside: np.ndarray) -> np.ndarray:
    """Points (n, 3) of the zero set: where each grid edge crosses it."""
    feet = []
    for axis in range(3):
        low, high = (np.take(phi, np.arange(s, phi.shape[axis] - 1 + s), axis) for s in (0, 1))
        crossing = np.take(inside, np.arange(phi.shape[axis] - 1), axis) != np.take(
            inside, np.arange(1, phi.shape[axis]), axis
        )
        points = np.argwhere(crossing).astype(np.float64)
        a, b = low[crossing], high[crossing]
        points[:, axis] += a / (a - b)
        feet.append(points)
    return np.concatenate(feet)


def mesh(phi: np.ndarray, spacing: float = 1.0, origin: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
    """The zero set as a closed mesh: vertices (n, 3) float64 and faces (m, 3) int64, looking outwards.

    It is closed even where it leaves the grid. Grid point (0, 0, 0) lies at `origin`. ValueError if nothing is inside.
    """
    from skimage.measure import marching_cubes

    off = np.where(np.abs(phi) < LEAST, np.where(phi < 0, -LEAST, LEAST), phi)
    padded = np.pad(np.clip(off, -4, 4), 1, constant_values=4.0)
    if not (padded < 0).any():
        raise ValueError("nothing is inside the surface")
    vertices, faces, *_ = marching_cubes(padded, 0.0, allow_degenerate=False)
    placed = (vertices.astype(np.float64) - 1) * spacing
    return placed + (np.zeros(3) if origin is None else origin), faces.astype(np.int64)


def largest(inside: np.ndarray) -> np.ndarray:
    """The largest blob (face neighbours) of a set of voxels (nx, ny, nz) bool."""
    from scipy.ndimage import label

    blobs, count = label(inside)
    if count < 2:
        return inside
    return blobs == 1 + int(np.argmax(np.bincount(blobs.ravel())[1:]))


def fill(inside: np.ndarray) -> np.ndarray:
    """The voxels with all cavities filled that no path to the outside reaches."""
    from scipy.ndimage import binary_fill_holes

    return binary_fill_holes(inside)
