"""Sums of regression trees."""

import numpy as np
from numba import njit, prange


@njit(cache=True, parallel=True, error_model="numpy", nogil=True)
def sum_trees(rows, feature, threshold, left, right, value):
    """Sum (n,) over trees of the leaf that each row (n, k) falls into.

    Nodes (t, m) of each tree: the feature it asks for, the threshold up to which a row goes left, and the nodes to both
    sides; left < 0 marks a leaf, whose value counts. The root is node 0.
    """
    sums = np.zeros(rows.shape[0])
    for i in prange(rows.shape[0]):
        total = 0.0
        for t in range(feature.shape[0]):
            node = 0
            while left[t, node] >= 0:
                node = left[t, node] if rows[i, feature[t, node]] <= threshold[t, node] else right[t, node]
            total += value[t, node]
        sums[i] = total
    return sums
