"""How much each group has to say about each action (5.12): a group that shows more behaviours characterises the action.

The success matrix Q holds the concentrations alpha of the mixtures, W is the mode of a Dirichlet posterior after those
successes. The thesis prints the denominator n_A + sum_s (Q_is - 1), with which a row adds to 1 only if the kappas of an
action happen to add to n_A, the number of actions.
"""

from __future__ import annotations

import numpy as np


def corrected(successes: np.ndarray, prior: float | np.ndarray) -> np.ndarray:
    """W (a, g) = (Q + kappa - 1) / sum over the groups, rows add to 1; on the edge of the simplex a negative count is
    0.

    `successes` Q (a, g), `prior` kappa, one number or (a, g). A row without successes is uniform.
    """
    counts = np.maximum(successes + prior - 1, 0.0)
    total = counts.sum(axis=1, keepdims=True)
    return np.divide(counts, total, out=np.full(counts.shape, 1 / counts.shape[1]), where=total > 0)


def printed(successes: np.ndarray, prior: float | np.ndarray) -> np.ndarray:
    """W (a, g) as (5.12) stands: (Q + kappa - 1) / (n_A + sum over the groups of (Q - 1)). Rows add to what they add
    to.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        return (successes + prior - 1) / (len(successes) + (successes - 1).sum(axis=1, keepdims=True))
