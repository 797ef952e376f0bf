"""A poor depth sensor, simulated: noise and outliers on a depth map."""

from __future__ import annotations

import numpy as np

from ipcli.errors import ParameterError

DISTRIBUTIONS = ("laplace", "gauss")


def parse_noise(text: str) -> tuple[str, float]:
    """("laplace", 0.03) of ``laplace:0.03``: distribution, and scale b or standard deviation; else ParameterError."""
    name, _, scale = text.partition(":")
    try:
        value = float(scale)
    except ValueError:
        value = np.nan
    if name not in DISTRIBUTIONS or not 0 <= value < np.inf:
        raise ParameterError(f"noise '{text}': expected laplace:SCALE or gauss:SCALE, such as laplace:0.03")
    return name, value


def observe(
    quantity: np.ndarray, rng: np.random.Generator, noise: tuple[str, float], outliers: float = 0.0
) -> np.ndarray:
    """What the sensor gives for a true depth or disparity (h, w): float32, NaN where the truth is NaN.

    A value that comes out as 0 or less is NaN too. Noise is independent from pixel to pixel; ``outliers`` is the share
    of pixels that get a value drawn evenly from the range of the map instead. The draws do not depend on which pixels
    are NaN.
    """
    distribution, scale = noise
    draw = rng.laplace if distribution == "laplace" else rng.normal
    observed = quantity + draw(scale=scale, size=quantity.shape)
    share, wild = rng.random(quantity.shape), rng.random(quantity.shape)
    if np.isfinite(quantity).any():
        low, high = np.nanmin(quantity), np.nanmax(quantity)
        replaced = (share < outliers) & np.isfinite(quantity)
        observed[replaced] = low + wild[replaced] * (high - low)
    return np.where(observed > 0, observed, np.nan).astype(np.float32)
