"""Coordinates that the mixtures live in: those where the spread of an action is the unit, and only what tells actions
apart is kept.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipcli.models.mocap.parameters import BODY, MOTION, Features

LEAST_SPREAD = 1e-6  # of the widest direction: narrower ones are rounding


@dataclass(frozen=True, eq=False)
class Projection:
    """y = (x - shift) matrix."""

    shift: np.ndarray  # (D,)
    matrix: np.ndarray  # (D, d)

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """(n, d) of x (n, D); NaN where x has NaN."""
        return (x - self.shift) @ self.matrix


def fit(x: np.ndarray, actions: np.ndarray, group: str, settings: Features) -> Projection:
    """The projection for features x (n, D), finite, of actions (n,) int."""
    if settings.projection == "standard":
        return _standard(x)
    return _within(
        x, actions, settings.shrinkage, settings.body_dimensions if group in (BODY, MOTION) else settings.dimensions
    )


def _standard(x: np.ndarray) -> Projection:
    spread = x.std(axis=0)
    return Projection(x.mean(axis=0), np.diag(1 / np.where(spread > 0, spread, 1.0)))


def _within(x: np.ndarray, actions: np.ndarray, shrinkage: float, dimensions: int) -> Projection:
    """Whitens the covariance within an action, mean over the actions and shrunk towards a sphere, then turns to
    principal axes.
    """
    within = np.mean([np.atleast_2d(np.cov(x[actions == a].T, bias=True)) for a in np.unique(actions)], axis=0)
    sphere = np.trace(within) / len(within) or 1.0
    white = np.linalg.inv(
        np.linalg.cholesky((1 - shrinkage) * within + (shrinkage + LEAST_SPREAD) * sphere * np.eye(len(within)))
    ).T
    shift = x.mean(axis=0)
    _, spread, axes = np.linalg.svd((x - shift) @ white, full_matrices=False)
    kept = max(int((spread[:dimensions] > LEAST_SPREAD * spread[0]).sum()), 1)
    axes = axes[:kept] * np.where(axes[:kept, np.abs(axes[:kept]).argmax(axis=1)].diagonal() < 0, -1.0, 1.0)[:, None]
    return Projection(shift, white @ axes.T)
