"""Normals of the surface that a depth map is."""

import numpy as np
from numba import njit


@njit(cache=True, error_model="numpy")
def _point(depth, i, j, inverse):
    """The point of pixel (i, j), NaN outside the image."""
    inside = 0 <= i < depth.shape[0] and 0 <= j < depth.shape[1]
    z = np.float64(depth[i, j]) if inside else np.nan
    return (
        z * (inverse[0, 0] * j + inverse[0, 1] * i + inverse[0, 2]),
        z * (inverse[1, 0] * j + inverse[1, 1] * i + inverse[1, 2]),
        z * (inverse[2, 0] * j + inverse[2, 1] * i + inverse[2, 2]),
    )


@njit(cache=True, error_model="numpy")
def _tangent(before, here, after):
    """Tangent of the points before, here and after along one direction of the grid.

    The mean of the one-sided differences; the shorter one alone where the other is more than twice as long (an edge) or
    missing (a gap). NaN where both are missing.
    """
    back = (here[0] - before[0], here[1] - before[1], here[2] - before[2])
    ahead = (after[0] - here[0], after[1] - here[1], after[2] - here[2])
    back_size = back[0] * back[0] + back[1] * back[1] + back[2] * back[2]
    ahead_size = ahead[0] * ahead[0] + ahead[1] * ahead[1] + ahead[2] * ahead[2]
    if back_size < 4 * ahead_size and ahead_size < 4 * back_size:
        return (back[0] + ahead[0], back[1] + ahead[1], back[2] + ahead[2])
    if np.isnan(back_size) or ahead_size < back_size:
        return ahead
    return back


@njit(cache=True, error_model="numpy", nogil=True)
def normals(out, depth, inverse, top, bottom):
    """Rows top to bottom of the unit normals (h, w, 3) that face the camera, of a depth map (h, w) and inverse
    intrinsics (3, 3).
    """
    for i in range(top, bottom):
        for j in range(depth.shape[1]):
            here = _point(depth, i, j, inverse)
            u = _tangent(_point(depth, i, j - 1, inverse), here, _point(depth, i, j + 1, inverse))
            v = _tangent(_point(depth, i - 1, j, inverse), here, _point(depth, i + 1, j, inverse))
            n = (v[1] * u[2] - v[2] * u[1], v[2] * u[0] - v[0] * u[2], v[0] * u[1] - v[1] * u[0])
            size = np.sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2])
            size = -size if n[0] * here[0] + n[1] * here[1] + n[2] * here[2] > 0 else size
            out[i, j, 0], out[i, j, 1], out[i, j, 2] = n[0] / size, n[1] / size, n[2] / size
