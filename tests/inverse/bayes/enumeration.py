"""All partitions of a few points and their exact posterior."""

import numpy as np

from ipcli.inverse.bayes.chain import log_partition
from ipcli.inverse.bayes.normal_wishart import Points


def partitions(n):
    """Labels (n,) of every partition of n points, clusters numbered in the order in which they appear."""
    found = [[0]]
    for _ in range(n - 1):
        found = [[*labels, k] for labels in found for k in range(max(labels) + 2)]
    return np.array(found, np.int32)


def canonical(labels):
    """The labels numbered in the order in which they appear, as a tuple."""
    names = {}
    return tuple(names.setdefault(label, len(names)) for label in labels.tolist())


def posterior(x, base, alpha):
    """Every partition of the points x (n, d), and its posterior probability given base measure and alpha."""
    every, log_p = partitions(len(x)), []
    for labels in every:
        points = Points.of(x, labels, labels.max() + 1)
        log_p.append(log_partition(points.count, alpha) + base.log_marginal(points).sum())
    p = np.exp(np.array(log_p) - max(log_p))
    return every, p / p.sum()
