"""What the experiments of chapter 7 model: photographs with known shapes, and five objects of our own making."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ipcli.models.brdf import surfaces
from ipcli.models.brdf.grid import normals
from ipcli.models.brdf.scenes import cropped
from ipcli.models.brdf.surfaces import ImplicitSurface

MIT = ("apple", "potato", "teabag1", "teabag2", "paper1")
DILIGENT = ("ball", "bear", "cat", "goblet", "pot1", "reading")
MIXES = ("ennis", "grace", "pisa", "uffizi", "wells")


@dataclass(frozen=True, eq=False)
class Case:
    """A linear picture cropped to its mask, with what is true of it."""

    name: str
    group: str
    colour: np.ndarray  # (h, w, 3)
    mask: np.ndarray  # (h, w)
    normals: np.ndarray  # (h, w, 3), NaN unknown
    height: np.ndarray | None  # (h, w) pixels, NaN unknown
    kind: str = "All cases"  # what is summed up by itself


def _cut(mask: np.ndarray) -> tuple[slice, slice]:
    rows, columns = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
    return slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)


def _png(path: Path) -> np.ndarray:
    from ipcli.io.files.images import read_stored

    stored = read_stored(path)
    return (stored[..., ::-1] if stored.ndim == 3 else np.repeat(stored[..., None], 3, axis=-1)) / np.iinfo(
        stored.dtype
    ).max


def mit(data: Path, names: tuple[str, ...] = MIT) -> Iterator[Case]:
    """MIT-Berkeley intrinsic images: shading and the mean of the specular layer, grey and without albedo, as in the
    thesis.
    """
    from scipy.io import loadmat

    for name in names:
        folder = data / "brdf/mit_berkeley/MIT-Berkeley-Laboratory" / name
        mask = _png(folder / "mask.png")[..., 0] > 0
        box = _cut(mask)
        grey = _png(folder / "shading.png").mean(axis=-1) + _png(folder / "specular.png").mean(axis=-1)
        height = np.where(mask, loadmat(folder / "Z.mat")["depth"], np.nan)[box]
        known = np.isfinite(height)
        yield Case(
            name,
            name,
            np.repeat(grey[box][..., None], 3, axis=-1),
            mask[box],
            normals(np.nan_to_num(height), known),
            height,
        )


def diligent(data: Path, names: tuple[str, ...] = DILIGENT) -> Iterator[Case]:
    """DiLiGenT: real photographs under five mixes of lights, with scanned normals."""
    from scipy.io import loadmat

    for name in names:
        folder = data / "brdf/diligent" / name
        mask = _png(folder / "mask.png")[..., 0] > 0
        box = _cut(mask)
        true = loadmat(folder / "Normal_gt.mat")["Normal_gt"].astype(float)
        true[np.linalg.norm(true, axis=-1) < 0.5] = np.nan
        for mix in MIXES:
            yield Case(f"{name} {mix}", name, _png(folder / f"mix_{mix}.png")[box], mask[box], true[box], None)


def own(side: int) -> dict[str, ImplicitSurface]:
    """The `solids` of our own as a picture of this side sees them, each cropped to its mask."""
    return {name: cropped(surfaces.march(solid, side, name)) for name, solid in solids().items()}


def solids() -> dict[str, surfaces.Implicit]:
    """Boot, moka pot, dish, teapot and vase as implicit solids: none is of the families that libraries learn from."""
    tilt = about_x(0.35)
    made = {
        "boot": _boot(),
        "moka pot": _moka(),
        "dish": surfaces.turned(_dish(), about_x(0.25)),
        "teapot": _teapot(),
        "vase": _vase(),
    }
    return {name: surfaces.turned(solid, tilt) for name, solid in made.items()}


def about_x(angle: float) -> np.ndarray:
    """The rotation (3, 3) by an angle about the x axis."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1, 0, 0], [0, c, s], [0, -s, c]])


def _boot() -> surfaces.Implicit:
    leg = np.stack([np.full(10, -0.25), np.linspace(0.75, -0.35, 10), np.zeros(10)], axis=-1)
    foot = np.stack([np.linspace(-0.25, 0.5, 8), np.linspace(-0.4, -0.5, 8), np.zeros(8)], axis=-1)
    return surfaces.tube(
        np.concatenate([leg, foot]), np.concatenate([np.linspace(0.27, 0.22, 10), np.linspace(0.24, 0.19, 8)])
    )


def _moka() -> surfaces.Implicit:
    def profile(t: np.ndarray) -> np.ndarray:
        return 0.25 + 0.22 * np.abs(t) + 0.03 * np.tanh(20 * t)

    body = surfaces.revolved(profile, 0.75)

    def faceted(p: np.ndarray) -> np.ndarray:
        angle = np.arctan2(p[..., 2], p[..., 0])
        return body(p) + 0.02 * np.cos(8 * angle)

    handle = surfaces.torus(0.28, 0.05)
    return lambda p: np.minimum(faceted(p), np.maximum(handle(p - np.array([0.4, 0.3, 0])), 0.42 - p[..., 0]))


def _dish() -> surfaces.Implicit:
    return lambda p: np.maximum(
        np.abs(p[..., 2] + 0.2 - 0.35 * (p[..., 0] ** 2 + p[..., 1] ** 2)) - 0.03, np.hypot(p[..., 0], p[..., 1]) - 0.85
    )


def _teapot() -> surfaces.Implicit:
    body = surfaces.ellipsoid(np.array([0.5, 0.42, 0.5]), 2.3)
    t = np.linspace(0, 1, 8)[:, None]
    spout = surfaces.tube(np.array([0.4, -0.1, 0]) + t * np.array([0.45, 0.35, 0]), np.linspace(0.12, 0.06, 8))
    handle, knob = surfaces.torus(0.26, 0.05), surfaces.ellipsoid(np.full(3, 0.1))
    return lambda p: np.minimum(
        np.minimum(body(p), spout(p)),
        np.minimum(np.maximum(handle(p + np.array([0.55, 0, 0])), p[..., 0] + 0.42), knob(p - np.array([0, 0.48, 0]))),
    )


def _vase() -> surfaces.Implicit:
    return surfaces.revolved(lambda t: 0.3 + 0.14 * np.sin(2.6 * t - 0.9) + 0.04 * np.cos(7 * t), 0.85)
