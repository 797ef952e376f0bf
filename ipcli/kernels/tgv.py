"""Value and dual residual of second-order TGV; planes and differences as in `iteration`."""

import numpy as np
from numba import njit

HALF = np.float32(0.5)
ZERO = np.float32(0)


@njit(cache=True, error_model="numpy", nogil=True)
def value_rows(x, v, alpha1, alpha0):
    """alpha1 |grad x - v| + alpha0 |E v|, summed over each row: (h,) float64."""
    h, w = x.shape
    rows = np.zeros(h)
    for i in range(h):
        above, below = max(i - 1, 0), min(i + 1, h - 1)
        half = HALF if i > 0 else ZERO
        has_below = np.float32(i + 1 < h)
        slope, curvature = 0.0, 0.0
        for j in range(w):
            left, right = max(j - 1, 0), min(j + 1, w - 1)
            a = (x[i, right] - x[i, j] - v[0, i, j]) * np.float32(j + 1 < w)
            b = (x[below, j] - x[i, j] - v[1, i, j]) * has_below
            e11 = v[0, i, j] - v[0, i, left]
            e22 = v[1, i, j] - v[1, above, j]
            e12 = (v[0, i, j] - v[0, above, j] + v[1, i, j] - v[1, i, left]) * half * np.float32(j > 0)
            slope += alpha1[i, j] * np.sqrt(a * a + b * b)
            curvature += np.sqrt(e11 * e11 + e22 * e22 + (e12 * e12 + e12 * e12))
        rows[i] = slope + alpha0 * curvature
    return rows


@njit(cache=True, error_model="numpy", nogil=True)
def dual_residual_rows(minus_div_p, p, q, steepest):
    """Write -div p (h, w) and return steepest (h, w) times |p - E^T q|, both components, summed over each row: (h,)
    float64.
    """
    h, w = minus_div_p.shape
    nothing = np.zeros(w, np.float32)
    rows = np.zeros(h)
    for i in range(h):
        p2_above = p[1, i - 1] if i > 0 else nothing
        q22_below = q[1, i + 1] if i + 1 < h else nothing
        q12_below = q[2, i + 1] if i + 1 < h else nothing
        total = 0.0
        for j in range(w):
            q11_right = q[0, i, j + 1] if j + 1 < w else ZERO
            q12_right = q[2, i, j + 1] if j + 1 < w else ZERO
            p1_left = p[0, i, j - 1] if j > 0 else ZERO
            minus_div_p[i, j] = p1_left - p[0, i, j] + p2_above[j] - p[1, i, j]
            along_u = abs(p[0, i, j] + q11_right - q[0, i, j] + q12_below[j] - q[2, i, j])
            along_v = abs(p[1, i, j] + q12_right - q[2, i, j] + q22_below[j] - q[1, i, j])
            total += np.float64(steepest[i, j]) * (along_u + along_v)
        rows[i] = total
    return rows
