"""The surface before a single camera, from the points of a map that it looks at: linear between neighbours."""

from __future__ import annotations

import numpy as np

from ipcli.geometry import lens
from ipcli.models.gaze.surface import Surface

LONGEST = 0.12  # of the picture's width: triangles of points farther apart say nothing
STEP = 1.25  # ratio of depths within a triangle above which it spans two surfaces
LEAST = 4  # points


def sparse_surface(
    inside: np.ndarray, intrinsics: np.ndarray, shape: tuple[int, int], rows: tuple[int, int]
) -> Surface:
    """Inverse depth over rows of an undistorted picture of `shape` (h, w) that sees points (n, 3) of the rig's frame.

    Points are joined to triangles in the picture. The error of an inverse depth is how far points lie from the mean of
    their neighbours, a robust deviation: what is between the points is not known better than that.
    """
    from scipy.spatial import Delaunay, QhullError

    top, bottom = rows
    empty = Surface(np.full((bottom - top, shape[1]), np.nan), top, intrinsics, np.eye(3), np.nan)
    front = inside[inside[:, 2] > 0.05]
    pixels = lens.pixels_of(front[:, :2] / front[:, 2:], intrinsics)
    seen = ((pixels > -0.1 * shape[1]) & (pixels < 1.1 * shape[1])).all(axis=1)
    pixels, inverse = pixels[seen], 1 / front[seen, 2]
    if len(pixels) < LEAST:
        return empty
    try:
        mesh = Delaunay(pixels)
    except QhullError:  # all on one line
        return empty
    corners = mesh.simplices
    sides = pixels[corners] - pixels[np.roll(corners, 1, axis=1)]
    good = np.linalg.norm(sides, axis=2).max(axis=1) < LONGEST * shape[1]
    good &= inverse[corners].max(axis=1) < STEP * inverse[corners].min(axis=1)
    v, u = np.mgrid[top:bottom, 0 : shape[1]]
    at = np.column_stack([u.ravel(), v.ravel()]).astype(float)
    triangle = mesh.find_simplex(at)
    known = (triangle >= 0) & good[triangle]
    frame = mesh.transform[triangle[known]]
    two = np.einsum("nij,nj->ni", frame[:, :2], at[known] - frame[:, 2])
    shares = np.column_stack([two, 1 - two.sum(axis=1)])
    found = np.full(len(at), np.nan)
    found[known] = (shares * inverse[corners[triangle[known]]]).sum(axis=1)
    return Surface(found.reshape(v.shape), top, intrinsics, np.eye(3), _roughness(corners[good], inverse))


def _roughness(triangles: np.ndarray, inverse: np.ndarray) -> float:
    """Robust deviation of inverse depths from the mean of the other two corners of their triangles; NaN without any."""
    if not len(triangles):
        return float("nan")
    values = inverse[triangles]
    off = values - (values.sum(axis=1, keepdims=True) - values) / 2
    return float(1.4826 * np.median(np.abs(off)) / np.sqrt(1.5))
