"""Half steps, value and dual residual of second-order TGV; first-order TV is the same with the slope field held at zero.

Planes are (h, w) float32. x is the image; v (2, h, w) its slope field, along columns and along rows; p (2, h, w) the dual of
grad x - v; q (3, h, w) the dual (q11, q22, q12) of the symmetrised gradient E v. `_bar` marks the extrapolation 2 new - old,
rho the over-relaxation. Forward differences in grad, backward ones in E, the mixed entry halved and counted twice in the
norm. A difference that would leave the image does not exist: p1 is zero in the last column, p2 in the last row, q11 in the
first column, q22 in the first row, q12 in both. Affine images therefore cost nothing, up to the border.

Threads call these kernels on blocks of rows (`ipcli.kernels.threads`); none of them starts threads of its own.
"""

from numba import njit
import numpy as np

HALF = np.float32(0.5)
ZERO = np.float32(0)


@njit(cache=True, error_model="numpy")
def _ascend_p(p1, p2, x, x_below, v1, v2, sigma, alpha, rho, has_below):
    """One row: p <- project(p + sigma (grad x_bar - v_bar)) on discs of radius alpha. The last column has no p1."""
    last = p1.shape[0] - 1
    for j in range(last):
        a = p1[j] + sigma * (x[j + 1] - x[j] - v1[j])
        b = p2[j] + sigma * (x_below[j] - x[j] - v2[j]) * has_below
        size = np.sqrt(a * a + b * b)
        shrink = alpha / (size if size > alpha else alpha)
        p1[j] += rho * (a * shrink - p1[j])
        p2[j] += rho * (b * shrink - p2[j])
    b = p2[last] + sigma * (x_below[last] - x[last] - v2[last]) * has_below
    p2[last] += rho * (min(max(b, -alpha), alpha) - p2[last])


@njit(cache=True, error_model="numpy")
def _ascend_q(q11, q22, q12, v1, v2, v1_above, v2_above, sigma, alpha, rho, half):
    """One row, from its second column on: q <- project(q + sigma E v_bar) on Frobenius balls of radius alpha."""
    for j in range(q11.shape[0]):
        a = q11[j] + sigma * (v1[j + 1] - v1[j])
        b = q22[j] + sigma * (v2[j + 1] - v2_above[j + 1])
        c = q12[j] + sigma * (v1[j + 1] - v1_above[j + 1] + v2[j + 1] - v2[j]) * half
        size = np.sqrt(a * a + b * b + (c * c + c * c))
        shrink = alpha / (size if size > alpha else alpha)
        q11[j] += rho * (a * shrink - q11[j])
        q22[j] += rho * (b * shrink - q22[j])
        q12[j] += rho * (c * shrink - q12[j])


@njit(cache=True, error_model="numpy", nogil=True)
def dual_ascent(p, q, x_bar, v_bar, sigma, alpha1, alpha0, rho):
    """p and q one step up, in place."""
    h = p.shape[1]
    for i in range(h):
        # The row above the first is itself: the vertical differences of the first row vanish and q22, q12 stay zero there.
        above, below = max(i - 1, 0), min(i + 1, h - 1)
        v1, v2, v1_above, v2_above = v_bar[0, i], v_bar[1, i], v_bar[0, above], v_bar[1, above]
        has_below = np.float32(i + 1 < h)
        half = HALF if i > 0 else ZERO
        _ascend_p(p[0, i], p[1, i], x_bar[i], x_bar[below], v1, v2, sigma, alpha1, rho, has_below)
        _ascend_q(q[0, i, 1:], q[1, i, 1:], q[2, i, 1:], v1, v2, v1_above, v2_above, sigma, alpha0, rho, half)
        b = q[1, i, 0] + sigma * (v2[0] - v2_above[0])
        q[1, i, 0] += rho * (min(max(b, -alpha0), alpha0) - q[1, i, 0])


@njit(cache=True, error_model="numpy")
def _descend_v(v, v_bar, p, q, q_right, r, r_below, tau, rho):
    """One row of one component of v <- v + tau (p - E^T q)."""
    for j in range(v.shape[0]):
        step = tau * (p[j] + q_right[j] - q[j] + r_below[j] - r[j])
        v_bar[j] = v[j] + (step + step)
        v[j] += rho * step


@njit(cache=True, error_model="numpy")
def _descend_x(y, x, p1, p1_left, p2, p2_above, tau):
    """One row of y = x + tau div p."""
    for j in range(y.shape[0]):
        y[j] = x[j] + tau * (p1[j] - p1_left[j] + p2[j] - p2_above[j])


@njit(cache=True, error_model="numpy", nogil=True)
def primal_descent(y, v, v_bar, x, p, q, tau, tau_v, rho):
    """y = x + tau div p, for the data term's proximal map to finish, and v one whole step down, in place."""
    h, w = x.shape
    nothing = np.zeros(w, np.float32)
    for i in range(h):
        p2_above = p[1, i - 1] if i > 0 else nothing
        q22_below = q[1, i + 1] if i + 1 < h else nothing
        q12_below = q[2, i + 1] if i + 1 < h else nothing
        _descend_x(y[i, 1:], x[i, 1:], p[0, i, 1:], p[0, i, :-1], p[1, i, 1:], p2_above[1:], tau)
        y[i, 0] = x[i, 0] + tau * (p[0, i, 0] + p[1, i, 0] - p2_above[0])
        q11, q22, q12 = q[0, i], q[1, i], q[2, i]
        _descend_v(v[0, i, :-1], v_bar[0, i, :-1], p[0, i], q11[:-1], q11[1:], q12, q12_below, tau_v, rho)
        _descend_v(v[1, i, :-1], v_bar[1, i, :-1], p[1, i], q12[:-1], q12[1:], q22, q22_below, tau_v, rho)
        # Beyond the last column there is no q.
        _descend_v(v[0, i, -1:], v_bar[0, i, -1:], p[0, i, -1:], q11[-1:], nothing, q12[-1:], q12_below[-1:], tau_v, rho)
        _descend_v(v[1, i, -1:], v_bar[1, i, -1:], p[1, i, -1:], q12[-1:], nothing, q22[-1:], q22_below[-1:], tau_v, rho)


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
            slope += np.sqrt(a * a + b * b)
            curvature += np.sqrt(e11 * e11 + e22 * e22 + (e12 * e12 + e12 * e12))
        rows[i] = alpha1 * slope + alpha0 * curvature
    return rows


@njit(cache=True, error_model="numpy", nogil=True)
def dual_residual_rows(minus_div_p, p, q, steepest):
    """Write -div p (h, w) and return steepest (h, w) times |p - E^T q|, both components, summed over each row: (h,) float64."""
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
