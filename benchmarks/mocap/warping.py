"""Dynamic time warping, compiled: the cheapest path between two curves, and the nearest of many."""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True)
def warping_path(cost: np.ndarray) -> np.ndarray:
    """The cheapest monotone path (p, 2) from corner to corner of costs (n, m), steps of one in either or both."""
    n, m = cost.shape
    total = np.full((n + 1, m + 1), np.inf)
    total[0, 0] = 0.0
    for i in range(n):
        for j in range(m):
            total[i + 1, j + 1] = cost[i, j] + min(total[i, j], total[i, j + 1], total[i + 1, j])
    path = np.empty((n + m, 2), np.int64)
    i, j, count = n - 1, m - 1, 0
    while True:
        path[count] = i, j
        count += 1
        if i == 0 and j == 0:
            return path[:count][::-1]
        both, above, beside = total[i, j], total[i, j + 1], total[i + 1, j]
        if both <= above and both <= beside:
            i, j = i - 1, j - 1
        elif above <= beside:
            i -= 1
        else:
            j -= 1


@njit(cache=True)
def mean_along(path: np.ndarray, curve: np.ndarray, length: int) -> np.ndarray:
    """The mean (length, d) of what of a curve (n, d) a path matches to each time of another of that length."""
    found, count = np.zeros((length, curve.shape[1]), curve.dtype), np.zeros(length, np.int64)
    for step in range(len(path)):
        i, j = path[step]
        count[j] += 1
        for axis in range(curve.shape[1]):
            found[j, axis] += curve[i, axis]
    for j in range(length):
        found[j] /= count[j]
    return found


@njit(cache=True, fastmath={"reassoc", "contract"})
def warped_distance(a: np.ndarray, b: np.ndarray, window: float, bound: float) -> float:
    """The least sum of squared distances along a monotone path between curves (n, d) and (m, d); infinite once it is
    more than the bound.

    A path keeps within `window` times the longer of the two of the straight one, and a step more.
    """
    n, m = len(a), len(b)
    slope = (m - 1) / max(n - 1, 1)
    reach = window * max(n, m) + max(slope, 1.0)
    last, now = np.full(m + 1, np.inf), np.full(m + 1, np.inf)
    last[0] = 0.0
    for i in range(n):
        now[:] = np.inf
        first, end = max(0, int(np.ceil(i * slope - reach))), min(m, int(np.floor(i * slope + reach)) + 1)
        least = np.inf
        for j in range(first, end):
            square = 0.0
            for axis in range(a.shape[1]):
                square += (a[i, axis] - b[j, axis]) ** 2
            now[j + 1] = square + min(last[j], last[j + 1], now[j])
            least = min(least, now[j + 1])
        if least > bound:
            return np.inf
        last, now = now, last
    return last[m]


@njit(cache=True)
def nearest(
    asked: np.ndarray, starts: np.ndarray, known: np.ndarray, known_starts: np.ndarray, window: float, normalised: bool
) -> np.ndarray:
    """Which of the known curves is nearest to each that is asked about, (q,) int, by `warped_distance`, if `normalised`
    over the length of the longer; curves lie one after the other, (n, d) from starts (q + 1,).
    """
    found = np.zeros(len(starts) - 1, np.int64)
    for q in range(len(starts) - 1):
        a, best = asked[starts[q] : starts[q + 1]], np.inf
        for k in range(len(known_starts) - 1):
            b = known[known_starts[k] : known_starts[k + 1]]
            unit = max(len(a), len(b)) if normalised else 1.0
            distance = warped_distance(a, b, window, best * unit) / unit
            if distance < best:
                best, found[q] = distance, k
    return found
