"""Slice sampling of a scalar (Neal 2003), stepping out and shrinking."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

MOST_STEPS = 100  # of the width, outwards


def draw(log_density: Callable[[float], float], t: float, rng: np.random.Generator, width: float = 1.0) -> float:
    """A step from t that leaves the density, known up to a factor, as it is."""
    level = log_density(t) - rng.exponential()
    low = t - width * rng.random()
    high = low + width
    left = int(rng.random() * MOST_STEPS)
    right = MOST_STEPS - 1 - left
    while left > 0 and log_density(low) > level:
        low, left = low - width, left - 1
    while right > 0 and log_density(high) > level:
        high, right = high + width, right - 1
    while True:
        new = low + (high - low) * rng.random()
        if log_density(new) >= level or math.isclose(low, high, rel_tol=1e-15, abs_tol=1e-300):
            return new
        low, high = (new, high) if new < t else (low, new)
