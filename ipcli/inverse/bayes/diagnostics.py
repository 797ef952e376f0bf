"""Whether chains have come to agree, and how many independent draws they are worth (Gelman et al. 2013, 11.4
and 11.5).
"""

from __future__ import annotations

import numpy as np


def split_r_hat(chains: np.ndarray) -> float:
    """Potential scale reduction of a scalar along chains (m, n), each split in two; near 1 when they agree. NaN below 4
    draws.

    Chains that never move agree if they are at one place, and otherwise do not: 1 or infinity.
    """
    halves = _halves(chains)
    if halves.shape[1] < 2:
        return float("nan")
    n = halves.shape[1]
    within, between = halves.var(axis=1, ddof=1).mean(), n * halves.mean(axis=1).var(ddof=1)
    if within == 0:
        return 1.0 if between == 0 else float("inf")
    return float(np.sqrt(((n - 1) / n * within + between / n) / within))


def effective_draws(chains: np.ndarray) -> float:
    """Effective number of independent draws of a scalar along chains (m, n): m n / (1 + 2 sum of autocorrelations).

    The sum ends where a pair of neighbouring autocorrelations is not positive any more (Geyer 1992). At most m n; NaN
    below 4 draws.
    """
    halves = _halves(chains)
    m, n = halves.shape
    if n < 2:
        return float("nan")
    centred = halves - halves.mean(axis=1, keepdims=True)
    within = centred.var(axis=1, ddof=1).mean()
    pooled = (n - 1) / n * within + halves.mean(axis=1).var(ddof=1)
    if pooled == 0:
        return float(m * n)
    covariance = np.array([np.mean(np.sum(centred[:, : n - t] * centred[:, t:], axis=1)) / n for t in range(n)])
    correlation = 1 - (within - covariance * n / (n - 1)) / pooled
    total = 0.0
    for t in range(1, n - 1, 2):
        pair = correlation[t] + correlation[t + 1]
        if pair <= 0:
            break
        total += pair
    return float(m * n / (1 + 2 * total))


def _halves(chains: np.ndarray) -> np.ndarray:
    """(2 m, n // 2) of (m, n); of an odd number the first is left out."""
    chains = np.asarray(chains, float)
    half = chains.shape[1] // 2
    return np.concatenate([chains[:, chains.shape[1] - 2 * half :][:, :half], chains[:, chains.shape[1] - half :]])
