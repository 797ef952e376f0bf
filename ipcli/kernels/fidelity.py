"""Data terms of the fusion of K observations a pixel.

The observations are kept sorted in a stack (h, K, w) float32: the K planes of a row lie side by side, so that a row is
one stretch of memory and every loop over its columns is a vector loop. Missing observations stand last, as +inf.
`weights` has the same layout and is 0 where an observation is missing; None stands for 1 everywhere else. `total` (h,
w) is the sum of the weights of a pixel and `scale` (h, w) its confidence times lambda.
"""

import numpy as np
from numba import njit

TWO = np.float32(2)
ZERO = np.float32(0)


@njit(cache=True, error_model="numpy")
def _relax(x, x_bar, rho):
    """x_bar holds the new point: x moves rho of the way to it, and x_bar is extrapolated to 2 new - old."""
    for j in range(x.shape[0]):
        step = x_bar[j] - x[j]
        x_bar[j] += step
        x[j] += rho * step


@njit(cache=True, error_model="numpy", nogil=True)
def prox_l2(x, x_bar, y, mean, total, scale, tau, rho):
    """Proximal map of tau scale sum_k w_k (x - d_k)^2 / 2 at y, from the weighted mean of the d_k."""
    h, w = x.shape
    for i in range(h):
        for j in range(w):
            pull = tau * scale[i, j] * total[i, j]
            x_bar[i, j] = y[i, j] + pull / (pull + np.float32(1)) * (mean[i, j] - y[i, j])
        _relax(x[i], x_bar[i], rho)


@njit(cache=True, error_model="numpy")
def _huber_root(d, weights, n, scale, width, stiffness, centre, tilt, low, high):
    """The x in [low, high] where stiffness (x - centre) + tilt + scale sum_k w_k clip((x - d_k) / width, -1, 1) = 0.

    The left side rises with x: Newton's step while it stays inside the bracket, which it halves otherwise.
    """
    x = min(max(d[(n - 1) // 2] if n > 0 else centre, low), high)
    for _ in range(60):
        value, rate = stiffness * (x - centre) + tilt, stiffness
        for m in range(n):
            r = (x - np.float64(d[m])) / width
            weight = scale if weights is None else scale * weights[m]
            value += weight * min(max(r, -1.0), 1.0)
            if abs(r) < 1.0:
                rate += weight / width
        if value > 0:
            high = x
        else:
            low = x
        enough = 1e-9 * (abs(x) + width)
        new = x - value / rate if rate > 0 else (np.inf if value != 0 else x)
        # A step to an end of the bracket leads to where Newton has been before: it would go to and fro for ever.
        if abs(new - x) > enough and not low < new < high:
            new = 0.5 * (low + high)
        if abs(new - x) <= enough:
            return new
        x = new
    return x


@njit(cache=True, error_model="numpy", nogil=True)
def prox_huber(x, x_bar, y, stack, weights, total, count, scale, width, tau, rho):
    """Proximal map of tau scale sum_k w_k huber(x - d_k) at y; huber is r^2 / (2 width) within the width, |r| - width /
    2 outside.
    """
    h, k, w = stack.shape
    for i in range(h):
        for j in range(w):
            centre, s = np.float64(y[i, j]), np.float64(scale[i, j])
            reach = tau * s * total[i, j]
            d, wm = stack[i, :, j], None if weights is None else weights[i, :, j]
            root = _huber_root(
                d, wm, int(count[i, j]), s, width, 1.0 / tau, centre, 0.0, centre - reach, centre + reach
            )
            x_bar[i, j] = root
        _relax(x[i], x_bar[i], rho)


@njit(cache=True, error_model="numpy", nogil=True)
def deviation(x, stack, weights, width):
    """sum_k w_k huber(x - d_k), for width 0 sum_k w_k |x - d_k|: (h, w) float32."""
    h, k, w = stack.shape
    total = np.zeros((h, w), np.float32)
    curvature = np.float32(1) / (TWO * max(width, np.float32(1e-30)))
    for i in range(h):
        for m in range(k):
            for j in range(w):
                d = stack[i, m, j]
                r = abs(x[i, j] - d) if d < np.inf else ZERO
                r = r - width / TWO if r > width else r * r * curvature
                total[i, j] += r if weights is None else r * weights[i, m, j]
    return total


@njit(cache=True, error_model="numpy", nogil=True)
def lowest_l1_rows(tilt, stack, weights, total, scale, low, high):
    """min over x in [low, high] of scale sum_k w_k |x - d_k| + tilt x, summed over each row: (h,) float64.

    The minimum lies on an observation or at an end; the values there follow each other by slope times distance.
    """
    h, k, w = stack.shape
    rows = np.zeros(h)
    for i in range(h):
        value, slope = np.zeros(w), np.empty(w)
        at, best = np.full(w, low), np.empty(w)
        for j in range(w):
            value[j] = tilt[i, j] * low
            slope[j] = tilt[i, j] - scale[i, j] * total[i, j]
        for m in range(k):
            for j in range(w):
                d = stack[i, m, j]
                weight = np.float32(1) if weights is None else weights[i, m, j]
                value[j] += scale[i, j] * weight * (d - low) if d < np.inf else 0.0
        for j in range(w):
            best[j] = value[j]
        for m in range(k):
            for j in range(w):
                d = stack[i, m, j]
                there = d if d < np.inf else at[j]
                weight = np.float32(1) if weights is None else weights[i, m, j]
                value[j] += slope[j] * (there - at[j])
                at[j] = there
                slope[j] += TWO * scale[i, j] * weight if d < np.inf else 0.0
                best[j] = min(best[j], value[j])
        for j in range(w):
            rows[i] += min(best[j], value[j] + slope[j] * (high - at[j]))
    return rows


@njit(cache=True, error_model="numpy", nogil=True)
def lowest_huber_rows(tilt, stack, weights, count, scale, width, low, high):
    """min over x in [low, high] of scale sum_k w_k huber(x - d_k) + tilt x, summed over each row: (h,) float64."""
    h, k, w = stack.shape
    rows = np.zeros(h)
    for i in range(h):
        for j in range(w):
            n, s, g = int(count[i, j]), np.float64(scale[i, j]), np.float64(tilt[i, j])
            d, wm = stack[i, :, j], None if weights is None else weights[i, :, j]
            x = _huber_root(d, wm, n, s, width, 0.0, 0.0, g, low, high)
            value = g * x
            for m in range(n):
                r = abs(x - d[m])
                r = r - width / 2 if r > width else r * r / (2 * width)
                value += s * r if wm is None else s * wm[m] * r
            rows[i] += value
    return rows


@njit(cache=True, error_model="numpy", nogil=True)
def sort_stack(stack):
    """Sort a stack (h, K, w) at every pixel, ascending, in place; NaN and infinity, no observation, come last
    as +inf.
    """
    h, k, w = stack.shape
    for i in range(h):
        for m in range(k):
            row = stack[i, m]
            for j in range(w):
                row[j] = row[j] if abs(row[j]) < np.inf else np.inf
        for a in range(1, k):
            for b in range(a, 0, -1):
                low, high = stack[i, b - 1], stack[i, b]
                for j in range(w):
                    # Plus 0, since to store what was just read would become a masked store, which is slow.
                    p, q = low[j] + ZERO, high[j] + ZERO
                    low[j] = p if p < q else q
                    high[j] = q if p < q else p


@njit(cache=True, error_model="numpy", nogil=True)
def sort_weighted_stack(stack, weights):
    """As `sort_stack`, with the weights (h, K, w) carried along; where one is not above 0 there is no observation, and
    it becomes 0.
    """
    h, k, w = stack.shape
    for i in range(h):
        for m in range(k):
            for j in range(w):
                if not (abs(stack[i, m, j]) < np.inf and weights[i, m, j] > 0):
                    stack[i, m, j], weights[i, m, j] = np.inf, ZERO
        for a in range(1, k):
            for b in range(a, 0, -1):
                low, high, low_weight, high_weight = stack[i, b - 1], stack[i, b], weights[i, b - 1], weights[i, b]
                for j in range(w):
                    if high[j] < low[j]:
                        low[j], high[j] = high[j], low[j]
                        low_weight[j], high_weight[j] = high_weight[j], low_weight[j]


@njit(cache=True, error_model="numpy", nogil=True)
def count_observations(stack):
    """How many of the K observations of a stack (h, K, w) there are: (h, w) float32."""
    h, k, w = stack.shape
    count = np.zeros((h, w), np.float32)
    for i in range(h):
        for m in range(k):
            for j in range(w):
                count[i, j] += np.float32(stack[i, m, j] < np.inf)
    return count
