"""Correcting a gaze's pixels by places that the wearer is known to have looked at, by robust least squares.

The thesis calibrates its eye camera after a reference that its text does not give; this takes what the device says,
whatever its own calibration, and moves it by a polynomial of the pixel.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipcli.errors import NoSolution
from ipcli.measurements.recording import FixationTargets, Gaze

TERMS = {"shift": 1, "affine": 3, "quadratic": 6}  # unknowns an axis
ENOUGH = 2  # targets an unknown
HUBER = 1.345  # sigmas beyond which a target counts less: it may have been looked past
ROUNDS = 30
MEDIAN = 1.1774  # of the length of a standard normal in the plane


@dataclass(frozen=True, eq=False)
class GazeCalibration:
    """How far the gaze is off at each pixel: a polynomial in widths of the picture from the middle."""

    kind: str  # of TERMS
    weights: np.ndarray  # (terms, 2) pixels
    middle: np.ndarray  # (2,) pixels
    unit: float  # pixels
    targets: int  # it rests on
    before: float  # pixels an axis: the error without it
    error: float  # pixels an axis: that of targets it was not fitted to (leave one out)

    def applied(self, pixels: np.ndarray) -> np.ndarray:
        """Corrected pixels (n, 2)."""
        return pixels + _terms(self.kind, (pixels - self.middle) / self.unit) @ self.weights


def calibrated(gaze: Gaze, targets: FixationTargets, width: float) -> GazeCalibration:
    """The kind of TERMS that foretells left-out targets best, of those that have `ENOUGH` targets.

    A target's gaze is the median of its valid samples. `width`: of the picture, pixels. NoSolution for too few targets.
    """
    seen = np.stack([_median(gaze, span) for span in targets.spans]) if len(targets.spans) else np.empty((0, 2))
    known = ~np.isnan(seen[:, 0])
    seen, true = seen[known], targets.pixels[known]
    if len(seen) < ENOUGH:
        raise NoSolution(
            f"calibration of the gaze: {len(seen)} of {len(known)} targets have valid gaze in their time, "
            f"{ENOUGH} are needed"
        )
    middle = seen.mean(axis=0)
    at, off = (seen - middle) / width, true - seen
    errors = {kind: _left_out(kind, at, off) for kind, terms in TERMS.items() if len(at) >= ENOUGH * terms}
    kind = min(errors, key=lambda name: errors[name])
    return GazeCalibration(
        kind, _fitted(_terms(kind, at), off), middle, width, len(at), _sigma(off), errors[kind]
    )  # fmt: skip


def _median(gaze: Gaze, span: np.ndarray) -> np.ndarray:
    mine = gaze.valid & (gaze.times >= span[0]) & (gaze.times <= span[1]) & np.isfinite(gaze.pixels).all(axis=1)
    return np.median(gaze.pixels[mine], axis=0) if mine.any() else np.full(2, np.nan)


def _terms(kind: str, at: np.ndarray) -> np.ndarray:
    x, y = at[:, 0], at[:, 1]
    return np.stack([np.ones_like(x), x, y, x * y, x**2, y**2][: TERMS[kind]], axis=1)


def _fitted(terms: np.ndarray, off: np.ndarray) -> np.ndarray:
    """Weights (terms, 2) by least squares reweighted after Huber."""
    weight = np.ones(len(off))
    for _ in range(ROUNDS):
        root = np.sqrt(weight)[:, None]
        solved, *_ = np.linalg.lstsq(root * terms, root * off, rcond=1e-9)
        length = np.linalg.norm(off - terms @ solved, axis=1)
        limit = HUBER * max(float(np.median(length)) / MEDIAN, 1e-9)
        weight = np.minimum(1.0, limit / np.maximum(length, 1e-12))
    return solved


def _left_out(kind: str, at: np.ndarray, off: np.ndarray) -> float:
    """Robust deviation, an axis, of each target from what the others say of it."""
    terms = _terms(kind, at)
    others = ~np.eye(len(at), dtype=bool)
    return _sigma(np.stack([off[k] - terms[k] @ _fitted(terms[others[k]], off[others[k]]) for k in range(len(at))]))


def _sigma(off: np.ndarray) -> float:
    return float(np.median(np.linalg.norm(off, axis=1))) / MEDIAN
