"""Sufficient statistics of labelled points."""

import numpy as np
from numba import njit


@njit(cache=True, error_model="numpy", nogil=True)
def statistics(x, z, k):
    """Count (k,), mean (k, d) and scatter (k, d, d) of the points x (n, d) of each label; all 0 for a label without
    points.
    """
    n, d = x.shape
    count, mean, scatter = np.zeros(k), np.zeros((k, d)), np.zeros((k, d, d))
    for p in range(n):
        count[z[p]] += 1
        for i in range(d):
            mean[z[p], i] += x[p, i]
    for c in range(k):
        for i in range(d):
            mean[c, i] /= max(count[c], 1.0)
    off = np.empty(d)
    for p in range(n):
        c = z[p]
        for i in range(d):
            off[i] = x[p, i] - mean[c, i]
            for j in range(i + 1):
                scatter[c, i, j] += off[i] * off[j]
    for c in range(k):
        for i in range(d):
            for j in range(i):
                scatter[c, j, i] = scatter[c, i, j]
    return count, mean, scatter
