"""One partition for many: the draw that is nearest to all of them."""

from __future__ import annotations

import numpy as np

CANDIDATES = 50  # draws that may be chosen and that stand for the rest, evenly spread


def variation_of_information(a: np.ndarray, b: np.ndarray) -> float:
    """H(a | b) + H(b | a) in nats, of two partitions given by labels (n,): 0 if they are the same, whatever the labels
    (Meila 2007).
    """
    n, width = len(a), int(b.max()) + 1
    both, of_a, of_b = (np.bincount(labels) for labels in (a.astype(np.int64) * width + b, a, b))
    return float(2 * _entropy(both, n) - _entropy(of_a, n) - _entropy(of_b, n))


def _entropy(counts: np.ndarray, n: int) -> float:
    share = counts[counts > 0] / n
    return float(-np.sum(share * np.log(share)))


def nearest(partitions: np.ndarray) -> int:
    """The row of the partitions (m, n) with the least mean variation of information to the others (Wade and Ghahramani
    2018).

    Of more than CANDIDATES rows, that many stand for all.
    """
    rows = np.unique(np.linspace(0, len(partitions) - 1, CANDIDATES).round().astype(int))
    distance = np.zeros((len(rows), len(rows)))
    for i, a in enumerate(rows):
        for j in range(i):
            distance[i, j] = distance[j, i] = variation_of_information(partitions[a], partitions[rows[j]])
    return int(rows[distance.sum(axis=1).argmin()])
