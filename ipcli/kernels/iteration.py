"""The primal-dual iteration of second-order TGV; first-order TV is the same with the slope field held at zero.

Planes are (h, w) float32. x is the image; v (2, h, w) its slope field, along columns and along rows; p (2, h, w) the
dual of grad x - v; q (3, h, w) the dual (q11, q22, q12) of the symmetrised gradient E v. `_bar` marks the extrapolation
2 new - old, rho the over-relaxation. Forward differences in grad, backward ones in E, the mixed entry halved and
counted twice in the norm. A difference that would leave the image does not exist: p1 is zero in the last column, p2 in
the last row, q11 in the first column, q22 in the first row, q12 in both. Affine images therefore cost nothing, up to
the border.

The two half steps take any proximal map between them. With absolute deviations, `sweep_l1` does several whole
iterations in one pass over the rows, so that most of them find their rows in the cache. Observations are laid out as in
`fidelity`.

Threads call these kernels on blocks of rows (`ipcli.threads`); none of them starts threads of its own.
"""

import numpy as np
from numba import njit

HALF = np.float32(0.5)
ONE = np.float32(1)
TWO = np.float32(2)
ZERO = np.float32(0)


@njit(cache=True, error_model="numpy")
def _ascend_p(p1, p2, x, x_below, v1, v2, sigma, alpha, rho, has_below):
    """One row: p <- project(p + sigma (grad x_bar - v_bar)) on discs of radii alpha (w,). The last column has no p1."""
    last = p1.shape[0] - 1
    for j in range(last):
        a = p1[j] + sigma * (x[j + 1] - x[j] - v1[j])
        b = p2[j] + sigma * (x_below[j] - x[j] - v2[j]) * has_below
        size, radius = np.sqrt(a * a + b * b), alpha[j]
        shrink = radius / (size if size > radius else radius)
        p1[j] += rho * (a * shrink - p1[j])
        p2[j] += rho * (b * shrink - p2[j])
    b = p2[last] + sigma * (x_below[last] - x[last] - v2[last]) * has_below
    p2[last] += rho * (min(max(b, -alpha[last]), alpha[last]) - p2[last])


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


@njit(cache=True, error_model="numpy")
def _ascend_row(i, p, q, x, x_below, v1, v2, v1_above, v2_above, sigma, alpha1, alpha0, rho):
    """Row i of p and q one step up. In the first row the row above is the row itself, in the last one that below."""
    has_below = ONE if i + 1 < p.shape[1] else ZERO
    half = HALF if i > 0 else ZERO
    _ascend_p(p[0, i], p[1, i], x, x_below, v1, v2, sigma, alpha1[i], rho, has_below)
    _ascend_q(q[0, i, 1:], q[1, i, 1:], q[2, i, 1:], v1, v2, v1_above, v2_above, sigma, alpha0, rho, half)
    b = q[1, i, 0] + sigma * (v2[0] - v2_above[0])
    q[1, i, 0] += rho * (min(max(b, -alpha0), alpha0) - q[1, i, 0])


@njit(cache=True, error_model="numpy", nogil=True)
def dual_ascent(p, q, x_bar, v_bar, sigma, alpha1, alpha0, rho):
    """p and q one step up, in place; alpha1 (h, w), alpha0 a number."""
    h = p.shape[1]
    for i in range(h):
        above, below = max(i - 1, 0), min(i + 1, h - 1)
        v1, v2, v1_above, v2_above = v_bar[0, i], v_bar[1, i], v_bar[0, above], v_bar[1, above]
        _ascend_row(i, p, q, x_bar[i], x_bar[below], v1, v2, v1_above, v2_above, sigma, alpha1, alpha0, rho)


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


@njit(cache=True, error_model="numpy")
def _descend_row(i, y, v1_bar, v2_bar, x, v, p, q, nothing, tau, tau_v, rho):
    """Row i of y = x + tau div p and of v one step down; `nothing` (w,) zeros stand for rows and columns outside."""
    h = x.shape[0]
    p2_above = p[1, i - 1] if i > 0 else nothing
    q22_below = q[1, i + 1] if i + 1 < h else nothing
    q12_below = q[2, i + 1] if i + 1 < h else nothing
    _descend_x(y[1:], x[i, 1:], p[0, i, 1:], p[0, i, :-1], p[1, i, 1:], p2_above[1:], tau)
    y[0] = x[i, 0] + tau * (p[0, i, 0] + p[1, i, 0] - p2_above[0])
    q11, q22, q12 = q[0, i], q[1, i], q[2, i]
    _descend_v(v[0, i, :-1], v1_bar[:-1], p[0, i], q11[:-1], q11[1:], q12, q12_below, tau_v, rho)
    _descend_v(v[1, i, :-1], v2_bar[:-1], p[1, i], q12[:-1], q12[1:], q22, q22_below, tau_v, rho)
    # Beyond the last column there is no q.
    _descend_v(v[0, i, -1:], v1_bar[-1:], p[0, i, -1:], q11[-1:], nothing, q12[-1:], q12_below[-1:], tau_v, rho)
    _descend_v(v[1, i, -1:], v2_bar[-1:], p[1, i, -1:], q12[-1:], nothing, q22[-1:], q22_below[-1:], tau_v, rho)


@njit(cache=True, error_model="numpy", nogil=True)
def primal_descent(y, v, v_bar, x, p, q, tau, tau_v, rho):
    """y = x + tau div p, for the data term's proximal map to finish, and v one whole step down, in place."""
    nothing = np.zeros(x.shape[1], np.float32)
    for i in range(x.shape[0]):
        _descend_row(i, y[i], v_bar[0, i], v_bar[1, i], x, v, p, q, nothing, tau, tau_v, rho)


@njit(cache=True, error_model="numpy")
def _start(new, top, drop, y, scale, total, tau):
    """Where a row of `prox_l1` starts, y + t s_0, and by how much each correction lowers it for weights of 1."""
    for j in range(new.shape[0]):
        step = tau * scale[j]
        level = y[j] + step * total[j]
        new[j] = level
        top[j] = level
        drop[j] = step + step


@njit(cache=True, error_model="numpy")
def _lower(new, top, drop, m, a, b, c, d):
    """Corrections m to m + 3 of `prox_l1` in one pass over a row, by the observations a to d, for weights of 1."""
    for j in range(new.shape[0]):
        by_a, by_b = top[j] - m * drop[j], top[j] - (m + ONE) * drop[j]
        by_c, by_d = top[j] - (m + TWO) * drop[j], top[j] - (m + ONE + TWO) * drop[j]
        by_a = a[j] if a[j] > by_a else by_a
        by_b = b[j] if b[j] > by_b else by_b
        by_c = c[j] if c[j] > by_c else by_c
        by_d = d[j] if d[j] > by_d else by_d
        # The new value stands first: stored in one branch only, it would become a masked store, which is slow.
        lowest = new[j]
        lowest = lowest if lowest < by_a else by_a
        lowest = lowest if lowest < by_b else by_b
        lowest = lowest if lowest < by_c else by_c
        new[j] = lowest if lowest < by_d else by_d


@njit(cache=True, error_model="numpy")
def _lower_weighted(new, top, drop, passed, a, b, weight_a, weight_b):
    """Two corrections in one pass over a row, by the observations a and b; `passed` is the weight of those before."""
    for j in range(new.shape[0]):
        weight = passed[j] + weight_a[j]
        by_a = top[j] - drop[j] * weight
        weight += weight_b[j]
        by_b = top[j] - drop[j] * weight
        passed[j] = weight
        by_a = a[j] if a[j] > by_a else by_a
        by_b = b[j] if b[j] > by_b else by_b
        lowest = new[j]
        lowest = lowest if lowest < by_a else by_a
        new[j] = lowest if lowest < by_b else by_b


@njit(cache=True, error_model="numpy")
def _prox_l1_row(i, x, x_bar, y, room, stack, weights, total, scale, tau, rho):
    """Row i of `prox_l1`, given that row of y and of x_bar; room (5, w), whose last two rows are inf and 0."""
    k, new, top, drop, passed, none, zero = stack.shape[1], x_bar, room[0], room[1], room[2], room[3], room[4]
    _start(new, top, drop, y, scale[i], total[i], tau)
    if weights is None:
        for m in range(0, k, 4):
            b = stack[i, m + 1] if m + 1 < k else none
            c = stack[i, m + 2] if m + 2 < k else none
            d = stack[i, m + 3] if m + 3 < k else none
            _lower(new, top, drop, np.float32(m + 1), stack[i, m], b, c, d)
    else:
        passed[:] = ZERO
        for m in range(0, k, 2):
            b, weight_b = (stack[i, m + 1], weights[i, m + 1]) if m + 1 < k else (none, zero)
            _lower_weighted(new, top, drop, passed, stack[i, m], b, weights[i, m], weight_b)
    _relax(x[i], new, rho)


@njit(cache=True, error_model="numpy")
def _room(w):
    """Room for `_prox_l1_row`."""
    room = np.zeros((5, w), np.float32)
    room[3] = np.inf
    return room


@njit(cache=True, error_model="numpy")
def _relax(x, x_bar, rho):
    """x_bar holds the new point: x moves rho of the way to it, and x_bar is extrapolated to 2 new - old."""
    for j in range(x.shape[0]):
        step = x_bar[j] - x[j]
        x_bar[j] += step
        x[j] += rho * step


@njit(cache=True, error_model="numpy", nogil=True)
def prox_l1(x, x_bar, y, stack, weights, total, scale, tau, rho):
    """Proximal map of tau scale sum_k w_k |x - d_k| at y, exact.

    With slopes s_m = total - 2 (w_(1) + ... + w_(m)), start from y + t s_0 and take x = min(x, max(d_(m), y + t s_m))
    for m = 1..K (the median formula of Li and Osher, 2009, in the order of the sorted data). Missing data change
    nothing.
    """
    room = _room(x.shape[1])
    for i in range(x.shape[0]):
        _prox_l1_row(i, x, x_bar[i], y[i], room, stack, weights, total, scale, tau, rho)


@njit(cache=True, error_model="numpy", nogil=True)
def sweep_l1(x, v, p, q, stack, weights, total, scale, steps, alpha1, alpha0, rhos):
    """One iteration for each of the relaxations rhos (n,), all in one pass over the rows, in place.

    What a row becomes in an iteration depends on its neighbours after the one before. So iteration m can follow two
    rows behind iteration m - 1, and overwrite what that one no longer needs. steps = (tau, tau_v, sigma).
    """
    h, w = x.shape
    n = rhos.shape[0]
    tau, tau_v, sigma = steps
    nothing, y, room = np.zeros(w, np.float32), np.empty(w, np.float32), _room(w)
    x_bar, v_bar = np.empty((n, 2, w), np.float32), np.empty((n, 2, 3, w), np.float32)  # of the rows still needed
    for front in range(h + 2 * n - 1):
        for m in range(n):
            i, rho, xs, vs = front - 2 * m, rhos[m], x_bar[m], v_bar[m]
            if 0 <= i < h:
                _descend_row(i, y, vs[0, i % 3], vs[1, i % 3], x, v, p, q, nothing, tau, tau_v, rho)
                _prox_l1_row(i, x, xs[i % 2], y, room, stack, weights, total, scale, tau, rho)
            if 0 < i <= h:
                here, below, above = i - 1, min(i, h - 1), max(i - 2, 0)
                v1, v2, v1_above, v2_above = vs[0, here % 3], vs[1, here % 3], vs[0, above % 3], vs[1, above % 3]
                _ascend_row(
                    here, p, q, xs[here % 2], xs[below % 2], v1, v2, v1_above, v2_above, sigma, alpha1, alpha0, rho
                )
