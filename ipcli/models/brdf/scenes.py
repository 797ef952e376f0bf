"""Generated scenes: a random surface, pictured through a reflectance map with the faults of a camera."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ipcli.models.brdf.reflectance import shade
from ipcli.models.brdf.surfaces import ImplicitSurface, random_sheet, random_solid

SMALLEST = 0.06  # share of the picture that an object fills at least


@dataclass(frozen=True, eq=False)
class PicturedScene:
    """A surface and a linear picture of it."""

    surface: ImplicitSurface
    picture: np.ndarray  # (s, s, 3), 0 outside the mask
    chart: int  # which of the charts it was seen through


def surface(rng: np.random.Generator, side: int, sheets: float = 0.5) -> ImplicitSurface:
    """A random surface in one piece that is not too small, a sheet with the probability given; cropped to its mask."""
    from scipy.ndimage import label

    while True:
        made = random_sheet(rng, side) if rng.uniform() < sheets else random_solid(rng, side)
        parts = label(made.mask)[1]
        if parts == 1 and made.mask.mean() >= SMALLEST:
            return cropped(made)


def cropped(made: ImplicitSurface) -> ImplicitSurface:
    """The surface on the box of its mask."""
    rows, columns = (np.flatnonzero(made.mask.any(axis=axis)) for axis in (1, 0))
    box = np.s_[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    return ImplicitSurface(made.mask[box], made.height[box], made.normals[box], made.is_sheet, made.name)


def scene(
    made: ImplicitSurface, charts: Sequence[np.ndarray] | np.ndarray, rng: np.random.Generator, noise: float = 0.01
) -> PicturedScene:
    """A picture of the surface through one of the colour charts (s, s, 3): noise, clipped highlights, 8 bits."""
    index = int(rng.integers(len(charts)))
    picture = photograph(made, charts[index], rng, noise)
    return PicturedScene(made, picture, index)


def photograph(made: ImplicitSurface, chart: np.ndarray, rng: np.random.Generator, noise: float = 0.01) -> np.ndarray:
    """A linear picture (s, s, 3) of a surface through a colour chart, exposed so that 1 in 200 pixels is clipped."""
    return exposed(shade(chart, made.normals[made.mask]), made.mask, rng, noise)


def exposed(seen: np.ndarray, mask: np.ndarray, rng: np.random.Generator, noise: float = 0.01) -> np.ndarray:
    """Radiance (n, 3) at the pixels of a mask (s, s) as a camera takes it: exposure as `photograph`, noise, 8 bits."""
    picture = np.zeros((*mask.shape, 3))
    seen = seen / max(float(np.percentile(seen, 99.5)), 1e-9)
    seen = seen + noise * rng.normal(size=seen.shape)
    picture[mask] = np.rint(np.clip(seen, 0, 1) * 255) / 255
    return picture
