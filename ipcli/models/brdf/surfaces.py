"""Procedural surfaces seen along -z: solids as implicit functions that rays are marched into, and folded sheets.

Everything lives in the square [-1, 1]^2, x right, y up, z to the viewer. A solid is a function of points (..., 3) that
is negative inside; unions are minima. Heights come out in pixels of the picture.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ipcli.models.brdf.grid import normals as normals_of_height

Implicit = Callable[[np.ndarray], np.ndarray]
MARCH = 72  # planes a ray is sampled at before it is refined
BISECTIONS = 12
GRADIENT = 1e-4


@dataclass(frozen=True, eq=False)
class ImplicitSurface:
    """The visible part of a surface."""

    mask: np.ndarray  # (s, s) bool
    height: np.ndarray  # (s, s) pixels, NaN outside
    normals: np.ndarray  # (s, s, 3), NaN outside
    is_sheet: bool
    name: str


def march(inside: Implicit, side: int, name: str = "solid") -> ImplicitSurface:
    """Cast a ray a pixel along -z into an implicit solid: first crossing, bisected; normals from the gradient there."""
    axis = (np.arange(side) + 0.5) / side * 2 - 1
    x, y = np.meshgrid(axis, -axis)
    levels = np.linspace(1, -1, MARCH)
    front = np.full(x.shape, np.nan)
    before = np.ones(x.shape)
    for z in levels:
        value = inside(np.stack([x, y, np.full_like(x, z)], axis=-1))
        hit = (value < 0) & (before >= 0) & np.isnan(front)
        front[hit] = z
        before = value
    mask = np.isfinite(front)
    xy = np.stack([x[mask], y[mask]], axis=-1)
    low = front[mask]
    high = low + (levels[0] - levels[1])
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        within = inside(np.concatenate([xy, middle[:, None]], axis=-1)) < 0
        low, high = np.where(within, middle, low), np.where(within, high, middle)
    points = np.concatenate([xy, low[:, None]], axis=-1)
    gradient = np.stack([inside(points + d) - inside(points - d) for d in GRADIENT * np.eye(3)], axis=-1)
    gradient[:, 2] = np.maximum(gradient[:, 2], 1e-9)
    height, normal = np.full(mask.shape, np.nan), np.full((*mask.shape, 3), np.nan)
    height[mask] = low * side / 2
    normal[mask] = gradient / np.maximum(np.linalg.norm(gradient, axis=1, keepdims=True), 1e-12)
    return ImplicitSurface(mask, height, normal, False, name)


def ellipsoid(radii: np.ndarray, exponent: float = 2.0) -> Implicit:
    """|x/a|^e + |y/b|^e + |z/c|^e < 1: from a ball to a rounded box."""
    return lambda p: (np.abs(p / radii) ** exponent).sum(axis=-1) ** (1 / exponent) - 1


def revolved(profile: Callable[[np.ndarray], np.ndarray], length: float) -> Implicit:
    """A surface of revolution about y with radius profile(t), t in [-1, 1] over |y| < length."""
    return lambda p: np.maximum(
        np.hypot(p[..., 0], p[..., 2]) - profile(np.clip(p[..., 1] / length, -1, 1)), np.abs(p[..., 1]) - length
    )


def torus(radius: float, tube: float) -> Implicit:
    """A ring about z."""
    return lambda p: np.hypot(np.hypot(p[..., 0], p[..., 1]) - radius, p[..., 2]) - tube


def tube(path: np.ndarray, radii: np.ndarray) -> Implicit:
    """Balls (k,) strung along a path (k, 3), smoothly joined: a swept circle."""

    def inside(p: np.ndarray) -> np.ndarray:
        distance = np.linalg.norm(p[..., None, :] - path, axis=-1) - radii
        return -np.log(np.exp(-24 * np.clip(distance, -1, 1)).sum(axis=-1)) / 24

    return inside


def gear(teeth: int, depth: float, thickness: float) -> Implicit:
    """A toothed wheel about z with rounded flanks and a hole."""

    def inside(p: np.ndarray) -> np.ndarray:
        r, phi = np.hypot(p[..., 0], p[..., 1]), np.arctan2(p[..., 1], p[..., 0])
        rim = 0.8 - depth * (1 - np.tanh(3 * np.cos(teeth * phi))) / 2
        return _soft_max(_soft_max(r - rim, np.abs(p[..., 2]) - thickness), 0.22 - r)

    return inside


def bowl(radius: float, wall: float, opening: float) -> Implicit:
    """A round shell open to the viewer: what is left of a ball when a smaller one and all before z = opening are taken
    out.
    """

    def inside(p: np.ndarray) -> np.ndarray:
        r = np.linalg.norm(p, axis=-1)
        return np.maximum(np.maximum(r - radius, radius - wall - r), p[..., 2] - opening)

    return inside


def bumpy(solid: Implicit, waves: np.ndarray, phases: np.ndarray, size: float) -> Implicit:
    """A solid whose skin is moved by waves (k, 3) of an amplitude."""
    return lambda p: solid(p) - size * np.sin(p @ waves.T + phases).sum(axis=-1) / np.sqrt(len(waves))


def turned(solid: Implicit, rotation: np.ndarray) -> Implicit:
    """The solid turned by a rotation (3, 3)."""
    return lambda p: solid(p @ rotation)


def _soft_max(a: np.ndarray, b: np.ndarray, width: float = 0.08) -> np.ndarray:
    gap = np.maximum(width - np.abs(a - b), 0) / width
    return np.maximum(a, b) + gap * gap * width / 4


def rotation(rng: np.random.Generator, most: float = np.pi) -> np.ndarray:
    """A rotation (3, 3) by an angle up to `most` about a random axis (Rodrigues)."""
    axis = rng.normal(size=3)
    x, y, z = axis / np.linalg.norm(axis)
    angle = rng.uniform(0, most)
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * (k @ k)


def random_solid(rng: np.random.Generator, side: int) -> ImplicitSurface:
    """One of the families: rounded boxes, potatoes, vases, cans, cups with a handle, rings, tubes, gear wheels,
    bowls.
    """
    name = str(
        rng.choice(["box", "potato", "potato", "vase", "vase", "can", "can", "cup", "ring", "tube", "gear", "bowl"])
    )
    makers = {
        "box": _box,
        "potato": _potato,
        "vase": _vase,
        "can": _can,
        "cup": _cup,
        "ring": _ring,
        "tube": _tube,
        "gear": _gear,
        "bowl": _bowl,
    }
    return march(makers[name](rng), side, name)


def _box(rng: np.random.Generator) -> Implicit:
    return turned(ellipsoid(rng.uniform(0.35, 0.6, 3), rng.uniform(2, 6)), rotation(rng))


def _potato(rng: np.random.Generator) -> Implicit:
    solid = turned(ellipsoid(rng.uniform(0.45, 0.8, 3)), rotation(rng))
    return bumpy(solid, rng.normal(0, 3.0, (4, 3)), rng.uniform(0, 6.28, 4), rng.uniform(0, 0.12))


def _vase(rng: np.random.Generator) -> Implicit:
    base, a, b = rng.uniform(0.2, 0.5), rng.uniform(-0.15, 0.15, 3), rng.uniform(0, 6.28, 3)

    def profile(t: np.ndarray) -> np.ndarray:
        waves = sum(a[k] * np.sin((k + 1) * 1.6 * t + b[k]) for k in range(3))
        return np.maximum(base + waves, 0.05) * np.sqrt(np.clip(1 - t**8, 0, 1))

    tilt = rotation(rng, 0.6)
    return turned(revolved(profile, rng.uniform(0.6, 0.85)), tilt)


def _can(rng: np.random.Generator) -> Implicit:
    base, taper, length = rng.uniform(0.25, 0.6), rng.uniform(-0.25, 0.25), rng.uniform(0.4, 0.85)
    neck, at = rng.choice([0.0, rng.uniform(0.1, 0.6)]), rng.uniform(0.0, 0.6)
    solid = revolved(lambda t: base * (1 + taper * t) * (1 - neck / (1 + np.exp(-14 * (t - at)))), length)
    spin = rng.choice([0.0, rng.uniform(0, 2 * np.pi)])
    c, s = np.cos(spin), np.sin(spin)
    return turned(solid, np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]]) @ rotation(rng, 0.5))


def _cup(rng: np.random.Generator) -> Implicit:
    base, taper, length = rng.uniform(0.35, 0.5), rng.uniform(0.0, 0.2), rng.uniform(0.4, 0.6)
    body = revolved(lambda t: base * (1 + taper * t), length)
    centre, handle = np.array([base + 0.05, 0.0, 0.0]), torus(rng.uniform(0.16, 0.26), rng.uniform(0.04, 0.07))
    hollow = rng.uniform(0.02, 0.06)
    well = revolved(lambda t: base * (1 + taper * t) - hollow, length + 0.2)

    def inside(p: np.ndarray) -> np.ndarray:
        shell = np.maximum(body(p), -well(p - np.array([0.0, 0.25, 0.0])))
        return np.minimum(shell, np.maximum(handle(p - centre), base * 0.9 - np.hypot(p[..., 0], p[..., 2])))

    about_y = rng.uniform(-0.9, 0.9) if rng.uniform() < 0.7 else rng.uniform(-np.pi, np.pi)
    c, s = np.cos(about_y), np.sin(about_y)
    return turned(inside, np.array([[c, 0, s], [0, 1.0, 0], [-s, 0, c]]) @ rotation(rng, 0.4))


def _ring(rng: np.random.Generator) -> Implicit:
    return turned(torus(rng.uniform(0.4, 0.6), rng.uniform(0.12, 0.3)), rotation(rng, 1.0))


def _tube(rng: np.random.Generator) -> Implicit:
    t = np.linspace(-1, 1, 14)
    bend = rng.normal(0, 0.35, (3, 3))
    path = np.stack([sum(bend[k, c] * np.cos((k + 1) * t * 1.5 + k) for k in range(3)) for c in range(3)], axis=-1)
    path[:, int(rng.integers(2))] += 0.6 * t
    path -= path.mean(axis=0)
    path *= 0.65 / np.abs(path).max()
    return tube(path, np.full(14, rng.uniform(0.14, 0.26)) * (1 + 0.3 * np.sin(3 * t + rng.uniform(0, 6))))


def _gear(rng: np.random.Generator) -> Implicit:
    wheel = gear(int(rng.integers(5, 14)), rng.uniform(0.08, 0.2), rng.uniform(0.08, 0.25))
    return turned(wheel, rotation(rng, 0.8))


def _bowl(rng: np.random.Generator) -> Implicit:
    radius = rng.uniform(0.6, 0.85)
    return turned(bowl(radius, rng.uniform(0.05, 0.12), radius * rng.uniform(-0.1, 0.5)), rotation(rng, 0.5))


def random_sheet(rng: np.random.Generator, side: int) -> ImplicitSurface:
    """A cut piece of paper, cloth, foil or a filled bag: a polygon with straight or torn edges, bent, waved or
    stuffed.
    """
    mask = _outline(rng, side)
    axis = (np.arange(side) + 0.5) / side * 2 - 1
    x, y = np.meshgrid(axis, -axis)
    angle = rng.uniform(0, np.pi)
    along = x * np.cos(angle) + y * np.sin(angle)
    z = rng.uniform(0, 0.25) * np.sin(rng.uniform(0.8, 4) * along + rng.uniform(0, 6.28))
    for _ in range(int(rng.integers(0, 5))):  # waves and wrinkles
        k = rng.normal(0, rng.choice([2.0, 5.0]), 2)
        z = z + rng.uniform(0, 0.12) / max(1.0, float(np.linalg.norm(k))) * 2 * np.sin(
            k[0] * x + k[1] * y + rng.uniform(0, 6.28)
        )
    z = z + rng.uniform(-0.4, 0.4) * x + rng.uniform(-0.4, 0.4) * y
    if rng.uniform() < 0.4:
        z = z + rng.uniform(0.05, 0.35) * _pillow(mask)
    if rng.uniform() < 0.25:  # a fold
        z = z - rng.uniform(0.1, 0.6) * np.abs(along - rng.uniform(-0.3, 0.3))
    height = np.where(mask, z * side / 2, np.nan)
    return ImplicitSurface(mask, height, normals_of_height(height, mask), True, "sheet")


def _pillow(mask: np.ndarray) -> np.ndarray:
    from scipy.ndimage import distance_transform_edt, gaussian_filter

    inward = distance_transform_edt(mask)
    return gaussian_filter(np.minimum(inward / max(inward.max(), 1), 0.6) / 0.6, len(mask) / 24)


def _outline(rng: np.random.Generator, side: int) -> np.ndarray:
    """Mask of a rectangle, a polygon or a leaf, its edges straight or a little torn."""
    import cv2

    kind = rng.choice(["rectangle", "rectangle", "polygon", "leaf"])
    if kind == "rectangle":
        a, b = rng.uniform(0.4, 0.8), rng.uniform(0.35, 0.8)
        corners = np.array([[-a, -b], [a, -b], [a, b], [-a, b]]) * (1 + rng.uniform(-0.08, 0.08, (4, 1)))
    elif kind == "polygon":
        count = int(rng.integers(3, 8))
        angle = np.linspace(0, 2 * np.pi, count, endpoint=False) + rng.uniform(-0.5, 0.5, count) / count * 3
        corners = np.stack([np.cos(angle), np.sin(angle)], axis=-1) * rng.uniform(0.5, 0.85, (count, 1))
    else:
        angle = np.linspace(0, 2 * np.pi, 60, endpoint=False)
        lobes = 0.6 + rng.uniform(0.05, 0.2) * np.cos(int(rng.integers(2, 7)) * angle + rng.uniform(0, 6)) * rng.choice(
            [1, 2]
        )
        corners = np.stack([np.cos(angle), rng.uniform(0.5, 1) * np.sin(angle)], axis=-1) * lobes[:, None]
    spin = rng.uniform(0, 2 * np.pi) if rng.uniform() < 0.6 else rng.uniform(-0.1, 0.1)
    corners = corners @ np.array([[np.cos(spin), -np.sin(spin)], [np.sin(spin), np.cos(spin)]])
    dense = np.concatenate(
        [np.linspace(a, b, 24, endpoint=False) for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)]
    )
    t = np.linspace(0, 2 * np.pi, len(dense), endpoint=False)
    waves = np.stack([rng.normal(0, 0.01) * np.cos(k * t + rng.uniform(0, 6.28)) for k in range(3, 12)])
    torn = waves.sum(axis=0) * rng.uniform(0, 1.5)
    dense = np.clip(dense * (1 + torn[:, None]), -0.95, 0.95)
    pixels = np.rint((dense * [1, -1] + 1) / 2 * side * 16).astype(np.int32)
    return cv2.fillPoly(np.zeros((side, side), np.uint8), [pixels], 1, shift=4).astype(bool)
