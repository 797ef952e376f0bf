"""The sum of trees against a plain walk down each."""

import numpy as np

from ipcli.kernels.trees import sum_trees


def walked(rows, feature, threshold, left, right, value):
    sums = np.zeros(len(rows))
    for i, row in enumerate(rows):
        for t in range(len(feature)):
            node = 0
            while left[t, node] >= 0:
                node = (left if row[feature[t, node]] <= threshold[t, node] else right)[t, node]
            sums[i] += value[t, node]
    return sums


def test_the_kernel_walks_down_each_tree():
    rng = np.random.default_rng(0)
    feature = rng.integers(0, 4, (5, 7))
    threshold, value = rng.normal(size=(2, 5, 7))
    left = np.tile([1, 3, 5, -1, -1, -1, -1], (5, 1))
    right = np.tile([2, 4, 6, -1, -1, -1, -1], (5, 1))
    left[2, 1] = right[2, 1] = -1  # a tree that is not full
    rows = rng.normal(size=(40, 4)).astype(np.float32)
    rows[0, :] = threshold[0, 0]  # up to the threshold, and it, goes left
    found = sum_trees(rows, feature, threshold, left, right, value)
    assert np.allclose(found, walked(rows, feature, threshold, left, right, value), atol=1e-12)
