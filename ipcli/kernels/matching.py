"""Nearest descriptors among features that lie where they may: in an epipolar band, or near an expected place."""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract"})
def _distance(a, b):
    """Squared distance of two rows of whole numbers up to 255 in float32: exact in any order, as it stays below 2^24.

    A whole row in one go is several times as quick as giving up early.
    """
    total = np.float32(0.0)
    for k in range(a.shape[0]):
        d = a[k] - b[k]
        total += d * d
    return total


@njit(cache=True, nogil=True)
def in_band(left, right, left_descriptors, right_descriptors, order, band, least, most, ratio, worst):
    """For each left feature the index of its match in the right picture, -1 without; (n,) and squared distances.

    `left`, `right` (n, 2): rectified pixels. `order` sorts the right ones by row. Rows may differ by `band`, the
    disparity u_left - u_right lies in [least, most]. The best squared distance must be below `ratio` times that of the
    second best, where there is a second, and not above `worst`.
    """
    match, distance = np.full(len(left), -1), np.full(len(left), worst + 1)
    rows = right[order, 1]
    own, other = left_descriptors.astype(np.float32), right_descriptors.astype(np.float32)
    for i in range(len(left)):
        if np.isnan(left[i, 0]):
            continue
        best, second = worst + 1, 2 * worst + 2
        k = np.searchsorted(rows, left[i, 1] - band)
        while k < len(order) and rows[k] <= left[i, 1] + band:
            j = order[k]
            k += 1
            disparity = left[i, 0] - right[j, 0]
            if not least <= disparity <= most:
                continue
            d = int(_distance(own[i], other[j]))
            if d < best:
                second = best if match[i] >= 0 else second
                best, match[i] = d, j
            elif d < second:
                second = d
        if match[i] >= 0 and best > ratio * second:
            match[i] = -1
        distance[i] = best
    return match, distance


@njit(cache=True, nogil=True)
def near(expected, features, expected_descriptors, descriptors, order, radius, ratio, worst):
    """For each expected pixel (m, 2) the index of the feature within `radius` (m,) pixels that matches, -1 without.

    `order` sorts the features by row; otherwise as `in_band`.
    """
    match, distance = np.full(len(expected), -1), np.full(len(expected), worst + 1)
    rows = features[order, 1]
    own, other = expected_descriptors.astype(np.float32), descriptors.astype(np.float32)
    for i in range(len(expected)):
        if np.isnan(expected[i, 0]):
            continue
        best, second, reach = worst + 1, 2 * worst + 2, radius[i]
        k = np.searchsorted(rows, expected[i, 1] - reach)
        while k < len(order) and rows[k] <= expected[i, 1] + reach:
            j = order[k]
            k += 1
            du, dv = expected[i, 0] - features[j, 0], expected[i, 1] - features[j, 1]
            if du * du + dv * dv > reach * reach:
                continue
            d = int(_distance(own[i], other[j]))
            if d < best:
                second = best if match[i] >= 0 else second
                best, match[i] = d, j
            elif d < second:
                second = d
        if match[i] >= 0 and best > ratio * second:
            match[i] = -1
        distance[i] = best
    return match, distance
