"""Solids that are painted: the objects of our own in the dielectric materials of a library, under paints of four kinds.

Texture is what shading is mistaken for: grey marbling and dark print have no colour of their own to tell them by.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from experiments.brdf import scenes
from experiments.brdf.scenes import Case
from ipcli.models.brdf import scenes as generated
from ipcli.models.brdf.library import Library
from ipcli.rng import stream

PAINTS = ("two colours", "stripes", "marble", "print")
DARKEST = 0.35  # albedo of the dark parts, of the light ones


def cases(shelf: Library, paintable: np.ndarray, quick: bool) -> Iterator[Case]:
    """Every object under every paint, in a material of those marked (b,) and under a light that its name draws."""
    charts = np.flatnonzero(paintable[shelf.material])
    for name, made in scenes.own(128 if quick else 192).items():
        for paint in PAINTS[: 1 if quick else None]:
            rng = stream(7, "painted", f"{name} {paint}")
            chart = shelf.charts[int(rng.choice(charts))]
            bare = generated.photograph(made, chart, rng, noise=0.0)
            picture = painted(bare, made.mask, paint, rng)
            yield Case(f"{name} {paint}", paint, picture, made.mask, made.normals, made.height)


def painted(bare: np.ndarray, mask: np.ndarray, paint: str, rng: np.random.Generator) -> np.ndarray:
    """A linear picture (h, w, 3) as it would be were what is in the mask under one of PAINTS, with noise, in 8 bits."""
    picture = bare * albedo(paint, mask.shape, rng)
    picture = np.where(mask[..., None], picture + 0.01 * rng.normal(size=picture.shape), 0)
    return np.rint(np.clip(picture / np.percentile(picture[mask], 99.5), 0, 1) * 255) / 255


def albedo(paint: str, shape: tuple[int, int], rng: np.random.Generator) -> np.ndarray:
    """Albedo (h, w, 3) in (0, 1] of one of PAINTS."""
    rows, columns = np.mgrid[: shape[0], : shape[1]] / max(shape)
    if paint == "stripes":
        turn = rng.uniform(0, np.pi)
        dark = np.sin(2 * np.pi * (6 * (np.cos(turn) * columns + np.sin(turn) * rows) + rng.uniform())) > 0.3
    elif paint == "print":
        dark = np.zeros(shape, bool)
        for _ in range(40):  # words: dark bars in lines
            row, column = int(rng.integers(shape[0]) // 12 * 12), int(rng.integers(shape[1]))
            dark[row : row + 5, column : column + int(rng.integers(6, 24))] = True
    else:
        dark = _clouds(shape, rng) > 0
    light, ink = np.ones(3), np.full(3, DARKEST)
    if paint in ("two colours", "stripes"):
        light, ink = (np.array(rgb) for rgb in ((0.9, 0.75, 0.45), (0.35, 0.45, 0.7)))
    if paint == "marble":  # no edges: the clouds themselves
        clouds = _clouds(shape, rng)
        share = np.clip(0.5 + clouds / (4 * clouds.std()), 0, 1)
        return np.repeat((DARKEST + (1 - DARKEST) * share)[..., None], 3, axis=-1)
    return np.where(dark[..., None], ink, light)


def _clouds(shape: tuple[int, int], rng: np.random.Generator) -> np.ndarray:
    from scipy.ndimage import gaussian_filter

    noise = rng.normal(size=shape)
    return sum(size * gaussian_filter(noise, size * max(shape) / 64) for size in (1, 2, 4))
