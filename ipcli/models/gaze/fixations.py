"""Fixations: runs of gaze that stay within the fovea (dispersion threshold, Salvucci 2000), and their PORs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Fixations:
    """Runs of samples with the mean of their points of regard."""

    spans: np.ndarray  # (f, 2) int: first sample, one after the last
    points: np.ndarray  # (f, 3) metres, NaN where no sample hit
    covariances: np.ndarray  # (f, 3, 3)
    of_sample: np.ndarray  # (n,) fixation of each sample, -1 none


def find(times: np.ndarray, directions: np.ndarray, spread: float, shortest: float) -> np.ndarray:
    """Spans (f, 2) of samples whose world directions (n, 3) all lie within `spread` degrees of their mean.

    Directions in the world, so that a head that turns with its eyes on one thing does not break a fixation. Unknown
    directions end a run; runs shorter than `shortest` seconds are saccades.
    """
    limit, spans, start = np.cos(np.radians(spread)), [], 0
    while start < len(times):
        stop, total = start, np.zeros(3)
        while stop < len(times) and np.isfinite(directions[stop]).all():
            grown = total + directions[stop]
            mean = grown / max(float(np.linalg.norm(grown)), 1e-12)
            if (directions[start : stop + 1] @ mean).min() < limit:
                break
            total, stop = grown, stop + 1
        if stop > start and times[stop - 1] - times[start] >= shortest:
            spans.append((start, stop))
            start = stop
        else:
            start += 1
    return np.array(spans, int).reshape(-1, 2)


def summarise(spans: np.ndarray, points: np.ndarray, covariances: np.ndarray, common: float) -> Fixations:
    """Median points of the runs. Errors of samples of one fixation are alike to the degree `common` in [0, 1]: that
    part of the covariance does not shrink with their number.
    """
    of_sample = np.full(len(points), -1)
    means, spread = np.full((len(spans), 3), np.nan), np.full((len(spans), 3, 3), np.nan)
    for index, (start, stop) in enumerate(spans):
        of_sample[start:stop] = index
        hit = start + np.flatnonzero(np.isfinite(points[start:stop]).all(axis=1))
        if len(hit):
            means[index] = np.median(points[hit], axis=0)
            spread[index] = covariances[hit].mean(axis=0) * (common + (1 - common) * np.pi / 2 / len(hit))
    return Fixations(spans, means, spread, of_sample)
