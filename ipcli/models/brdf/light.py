"""Distant light: probes as radiance over directions, procedural key and fill lights, and their turning about the view
axis.

World frame: x right, y up, z to the viewer. A probe is an equirectangular image (h, w, 3), row 0 at +y; the direction
of (theta, phi) is (sin phi sin theta, cos theta, -cos phi sin theta), as in Mitsuba. `Light` is what all else takes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

GOLDEN = np.pi * (3 - np.sqrt(5))
DIRECTIONS = 1536  # over the sphere
TEXELS = 20  # of a probe a direction at least


@dataclass(frozen=True, eq=False)
class Light:
    """Radiance of the environment on a fixed set of directions that share the sphere equally."""

    radiance: np.ndarray  # (d, 3)


def sphere(count: int = DIRECTIONS) -> np.ndarray:
    """Directions (count, 3) spread evenly by the golden angle."""
    k = np.arange(count) + 0.5
    y = 1 - 2 * k / count
    r = np.sqrt(1 - y * y)
    return np.stack([r * np.cos(GOLDEN * k), y, r * np.sin(GOLDEN * k)], axis=-1)


def probe(image: np.ndarray, heading: float = 0.0, count: int = DIRECTIONS) -> Light:
    """An equirectangular probe (h, w, 3) turned by `heading` radians about the vertical, averaged around each
    direction.

    The average runs over the texels nearest to the direction, weighed by their solid angle, so that small suns are
    kept.
    """
    finer = int(np.ceil(np.sqrt(TEXELS * count / (image.shape[0] * image.shape[1]))))
    image = image.repeat(finer, axis=0).repeat(
        finer, axis=1
    )  # else a direction between the texels of a small probe is dark
    nearest, weight = _cells(image.shape[:2], heading, count)
    flat = image.reshape(-1, 3)
    total = np.stack([np.bincount(nearest, weight * flat[:, c], minlength=count) for c in range(3)], axis=-1)
    share = np.bincount(nearest, weight, minlength=count)
    return Light(total / np.maximum(share, 1e-12)[:, None])


def _cells(shape: tuple[int, int], heading: float, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The direction nearest to each texel, and the solid angle of the texel."""
    from scipy.spatial import cKDTree

    h, w = shape
    theta, phi = np.meshgrid(
        (np.arange(h) + 0.5) * np.pi / h, (np.arange(w) + 0.5) * 2 * np.pi / w + heading, indexing="ij"
    )
    sine = np.sin(theta)
    towards = np.stack([np.sin(phi) * sine, np.cos(theta), -np.cos(phi) * sine], axis=-1).reshape(-1, 3)
    return np.asarray(cKDTree(sphere(count)).query(towards)[1]), sine.ravel() * (np.pi / h) * (2 * np.pi / w)


def key_and_fill(rng: np.random.Generator, count: int = DIRECTIONS) -> Light:
    """A key light from the front hemisphere, one to three weaker fills, and an even glow: the light of a studio or a
    room.

    Widths run from a lamp (8 degrees) to a window or a bright wall (40); colours stay near white.
    """
    directions = sphere(count)
    radiance = np.full((count, 3), rng.uniform(0.02, 0.25))
    radiance += rng.uniform(0, 0.4) * np.clip(directions[:, [1]], 0, 1)  # a sky or a ceiling
    for index in range(int(rng.integers(2, 5))):
        azimuth, elevation = rng.uniform(0, 2 * np.pi), rng.uniform(0.15, 1.35)
        towards = np.array(
            [np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)]
        )
        width = np.radians(rng.uniform(8, 40))
        lobe = np.exp((directions @ towards - 1) / (1 - np.cos(width)))
        strength = (1.0 if index == 0 else rng.uniform(0.1, 0.6)) * 12 / lobe.sum() * count / 4 / np.pi / 12
        radiance += strength * lobe[:, None] * (1 + rng.uniform(-0.08, 0.08, 3))
    return Light(radiance)
