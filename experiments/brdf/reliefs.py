"""Bowls and domes of one outline each, and hollow things, under lights from above, the side and below: which way does
it bend?

One picture does not tell; `--relief light-above` takes the answer whose light comes from above, and is to be right
where the light does.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from experiments.brdf import scenes
from ipcli.models.brdf import scenes as generated
from ipcli.models.brdf import surfaces
from ipcli.models.brdf.grid import inflate, normals
from ipcli.models.brdf.library import Library
from ipcli.models.brdf.parameters import Inference
from ipcli.models.brdf.reconstruct import reconstruct
from ipcli.models.brdf.reflectance import chart_normals
from ipcli.models.brdf.surfaces import ImplicitSurface
from ipcli.report.brdf.brdf_object import TIED
from ipcli.rng import stream

CASTS, HOLLOW = "balloons and their casts", "dish, bowl and spoon"
LIGHTS = ("above", "side", "below")
SIDE = 96


@dataclass(frozen=True)
class Told:
    """What was found of one relief under one light."""

    kind: str
    name: str
    light: str
    right: float  # share of the area on the right side of the plane of the rim, by `light-above`
    convex: float  # the same when everything is taken to be convex
    ties: bool  # whether it is reported that the picture does not tell


def measured(shelf: Library, quick: bool) -> Iterator[Told]:
    """Every relief under every light."""
    shown = list(outlines())[: 1 if quick else None]
    casts = [relief(outline, is_dome) for outline in shown for is_dome in (True, False)]
    for kind, reliefs in ((CASTS, casts), (HOLLOW, [] if quick else hollow())):
        for made in reliefs:
            for light in LIGHTS:
                yield told(kind, made, light, shelf)


def told(kind: str, made: ImplicitSurface, light: str, shelf: Library) -> Told:
    """The sign of a relief under a light of the library that comes from there."""
    rng = stream(7, "relief", f"{made.name} {light}")
    chart = shelf.charts[int(rng.choice(from_where(shelf, light)))]
    picture = generated.photograph(made, chart, rng)
    params = replace(Inference(), rim="solid", use_patches="none")  # they do not say which way it bends
    above = reconstruct(picture, made.mask, shelf, replace(params, relief="light-above"))
    convex = reconstruct(picture, made.mask, shelf, params)
    right, always = (right_side(found.height, made) for found in (above, convex))
    return Told(kind, made.name, light, right, always, abs(above.tie) < TIED)


def right_side(height: np.ndarray, made: ImplicitSurface) -> float:
    """Share of where the true height lies a pixel or more off the plane of its rim and a height (h, w) on the same side
    of that of its own.
    """
    from scipy.ndimage import binary_erosion

    rim = made.mask & ~binary_erosion(made.mask)
    found, true = (_above_plane(z, rim) for z in (height, made.height))
    off = made.mask & ~rim & (np.abs(true) >= 1)
    return float((np.sign(found) == np.sign(true))[off].mean())


def _above_plane(height: np.ndarray, rim: np.ndarray) -> np.ndarray:
    """Heights (h, w) over the plane that fits those of the rim (h, w): what is hollow may be tilted."""
    rows, columns = np.indices(rim.shape)
    design = np.stack([np.ones(rim.shape), columns, rows], axis=-1)
    return height - design @ np.linalg.lstsq(design[rim], height[rim], rcond=None)[0]


def from_where(shelf: Library, light: str) -> np.ndarray:
    """Indices of the charts of a library whose brightness leans up, down or, most of all, to a side."""
    n = chart_normals(shelf.charts.shape[1])
    grey = shelf.charts.mean(axis=-1)
    lean_x, lean_y = ((grey * n[..., axis]).sum(axis=(1, 2)) for axis in (0, 1))
    steep = np.abs(lean_y) > np.abs(lean_x)
    return np.flatnonzero({"above": steep & (lean_y > 0), "below": steep & (lean_y < 0), "side": ~steep}[light])


def relief(outline: np.ndarray, is_dome: bool) -> ImplicitSurface:
    """A dome over an outline (s, s), or the bowl that is its cast."""
    height = np.where(outline, (0.6 if is_dome else -0.6) * inflate(outline), np.nan)
    name = f"{'dome' if is_dome else 'bowl'} of {int(outline.sum())} px"
    return ImplicitSurface(outline, height, normals(np.nan_to_num(height), outline), False, name)


def hollow() -> list[ImplicitSurface]:
    """A dish, a bowl and a spoon, tilted: none is the cast of a balloon, and the spoon has a handle that bulges."""
    bowl = surfaces.turned(surfaces.bowl(0.8, 0.07, -0.2), scenes.about_x(0.4))
    spoon = surfaces.turned(_spoon(), scenes.about_x(0.2))
    made = {"dish": scenes.solids()["dish"], "bowl": bowl, "spoon": spoon}
    return [generated.cropped(surfaces.march(solid, SIDE, name)) for name, solid in made.items()]


def _spoon() -> surfaces.Implicit:
    size, middle = np.array([0.45, 0.55, 0.4]), np.array([0.0, 0.35, 0.0])
    shell = surfaces.bowl(1.0, 0.12, -0.1)
    handle = surfaces.tube(np.stack([np.zeros(8), np.linspace(-0.2, -0.9, 8), np.zeros(8)], axis=-1), np.full(8, 0.08))
    return lambda p: np.minimum(shell((p - middle) / size) * size.min(), handle(p))


def outlines() -> Iterator[np.ndarray]:
    """Five outlines: a disc, two ellipses, a rounded square and a pear."""
    axis = (np.arange(SIDE) + 0.5) / SIDE * 2 - 1
    x, y = np.meshgrid(axis, -axis)
    yield np.hypot(x, y) < 0.9
    yield np.hypot(x / 0.9, y / 0.6) < 1
    yield np.hypot(x / 0.55, y / 0.85) < 1
    yield x**4 + y**4 < 0.8**4
    yield np.hypot(x / (0.75 - 0.3 * y), y / 0.9) < 1
