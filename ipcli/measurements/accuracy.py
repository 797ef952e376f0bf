"""Errors measured on maps, summed up: over scenes, over the thesis' three depth measures, over the pixels kept.

Models decide by these figures and pages show them.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, sqrt

import numpy as np

MOST_PIXELS = 4_000_000  # of a map whose errors are measured at every pixel
MAP_PIXELS = 2_000_000  # of a map that is drawn from every pixel


def mean_over_scenes(values: np.ndarray, columns: Sequence[str], *, arithmetic: bool = False) -> np.ndarray:
    """Means over the first axis of measures (s, ..., c): geometric for errors, as in the thesis' tables 4.2 and 4.3, so
    that no scene counts for more because its errors are larger; arithmetic for percentages, which may be 0, or, as in
    tables 4.4 and 4.5, for all. NaN if any is.
    """
    percentages = np.array([arithmetic or "%" in str(column) for column in columns])
    with np.errstate(divide="ignore", invalid="ignore"):
        geometric = np.exp(np.log(values).mean(axis=0))
    return np.where(percentages, values.mean(axis=0), geometric)


def depth_average(values: np.ndarray, columns: Sequence[str]) -> np.ndarray:
    """The thesis' Z-avg of measures (..., c): geometric mean of centred RMSE, Z-MAE and N-MAE."""
    names = [str(column) for column in columns]
    three = values[..., [names.index(name) for name in ("centred RMSE", "Z-MAE", "N-MAE rad")]]
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.exp(np.log(three).mean(axis=-1))


def thinning(pixels: int, most: int = MOST_PIXELS) -> int:
    """So many-th rows and columns of a map are enough to measure by: sorting all of a large one takes its memory
    several times over and tells nothing more.
    """
    return max(1, ceil(sqrt(pixels / most)))


def thinned_camera(intrinsics: np.ndarray, step: int) -> np.ndarray:
    """Intrinsics (3, 3) of the picture that every `step`-th row and column of another make up."""
    return np.diag([1 / step, 1 / step, 1.0]) @ intrinsics


def sparsification_curve(error: np.ndarray, key: np.ndarray, points: int = 60) -> tuple[np.ndarray, np.ndarray]:
    """Shares in % and the mean ``error`` (n,) of that share of pixels with the smallest ``key`` (n,), ties in order."""
    ordered = error[np.argsort(key, kind="stable")].cumsum(dtype=np.float64)
    counts = np.unique(np.linspace(min(len(error), max(1, len(error) // points)), len(error), points).astype(int))
    return 100 * counts / len(error), ordered[counts - 1] / counts
