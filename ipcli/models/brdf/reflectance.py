"""Reflectance maps: what a uniform convex object under distant light looks like as a function of its normal, R(n).

Three forms with one face, `slopes(normals) -> R, dR/dn`: `Harmonics` (9 numbers, fitted to the picture itself), `Chart`
(a smooth table over (n_x, n_y), rendered from a BRDF and a light), and the scale of a map. World frame as in `light`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from ipcli.models.brdf.light import Light, sphere
from ipcli.models.brdf.materials import Brdf

SIDE = 65  # entries of a chart along n_x and n_y
RIM = 0.999  # radius in (n_x, n_y) up to which charts are sampled; beyond, the nearest entry there
BANDS = 9  # harmonics of order 2
COSINES = np.linspace(0.02, 1, 16)  # of the angles to the normal between which the directional albedo is interpolated


class Map(Protocol):
    """A grey reflectance map."""

    def slopes(self, normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """R (n,) and its gradient (n, 3) by the normal, for unit normals (n, 3) towards the viewer."""
        ...


@dataclass(frozen=True, eq=False)
class Harmonics:
    """R = sum_i c_i Y_i(n), spherical harmonics up to order 2 as plain polynomials: any light on a matte object."""

    coefficients: np.ndarray  # (9,)

    def slopes(self, normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See `Map`."""
        x, y, z = normals.T
        c, o = self.coefficients, np.zeros(len(normals))
        gradient = np.stack(
            [
                c[1] + c[4] * y + c[5] * z + 2 * c[7] * x + o,
                c[2] + c[4] * x + c[6] * z - 2 * c[7] * y + o,
                c[3] + c[5] * x + c[6] * y + 6 * c[8] * z + o,
            ],
            axis=-1,
        )
        return harmonic_basis(normals) @ c, gradient


def harmonic_basis(normals: np.ndarray) -> np.ndarray:
    """1, x, y, z, xy, xz, yz, x^2 - y^2, 3 z^2 - 1 of unit normals (n, 3), as (n, 9)."""
    x, y, z = normals.T
    return np.stack([np.ones_like(x), x, y, z, x * y, x * z, y * z, x * x - y * y, 3 * z * z - 1], axis=-1)


@dataclass(frozen=True, eq=False)
class Chart:
    """A table over (n_x, n_y), entry [i, j] at n_x = -1 + 2 i / (s - 1), n_y likewise; cubic between the entries."""

    table: np.ndarray  # (s, s)
    scale: float = 1.0
    spline: Any = field(init=False, repr=False)

    def __post_init__(self) -> None:
        from scipy.interpolate import RectBivariateSpline

        axis = np.linspace(-1, 1, len(self.table))
        object.__setattr__(self, "spline", RectBivariateSpline(axis, axis, self.table))

    def slopes(self, normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See `Map`."""
        x, y = np.clip(normals[:, 0], -RIM, RIM), np.clip(normals[:, 1], -RIM, RIM)
        value = self.spline.ev(x, y)
        gradient = np.stack([self.spline.ev(x, y, dx=1), self.spline.ev(x, y, dy=1), np.zeros_like(x)], axis=-1)
        return self.scale * value, self.scale * gradient

    def scaled(self, factor: float) -> Chart:
        """The same map brighter by a factor."""
        return Chart(self.table, self.scale * factor)


def chart_normals(side: int = SIDE) -> np.ndarray:
    """Normals (side, side, 3) of the entries of a chart; those beyond the rim are drawn in to it."""
    axis = np.linspace(-1, 1, side)
    x, y = np.meshgrid(axis, axis, indexing="ij")
    radius = np.hypot(x, y)
    shrink = np.minimum(1, RIM / np.maximum(radius, 1e-12))
    x, y = x * shrink, y * shrink
    return np.stack([x, y, np.sqrt(1 - x * x - y * y)], axis=-1)


def frames(normals: np.ndarray) -> np.ndarray:
    """Rotations (n, 3, 3) whose rows are tangent, bitangent and normal of each unit normal (n, 3) with n_z > -1."""
    x, y, z = normals.T
    a = 1 / (1 + z)
    b = -x * y * a
    t = np.stack([1 - x * x * a, b, -x], axis=-1)
    s = np.stack([b, 1 - y * y * a, -y], axis=-1)
    return np.stack([t, s, normals], axis=1)


def transfer(brdf: Brdf, normals: np.ndarray, directions: np.ndarray, albedo: np.ndarray | None = None) -> np.ndarray:
    """T (n, d, 3) = f cos(theta) d omega, so that the outgoing radiance to the viewer at +z is sum_d T L (n, 3).

    `albedo` is what `albedo_by_angle` gives, for callers that ask more than once.

    `directions` (d, 3) share the sphere equally. Lobes narrower than their spacing are blurred by it, not lost: the
    row is rescaled to the directional albedo of a finer quadrature around the mirror direction.
    """
    albedo = albedo_by_angle(brdf) if albedo is None else albedo
    turned = frames(normals)
    view = turned[:, :, 2]
    light = np.einsum("nij,dj->ndi", turned, directions)
    value = brdf(light, np.broadcast_to(view[:, None], light.shape))
    rows = value * np.clip(light[..., 2:], 0, None) * (4 * np.pi / len(directions))
    return rows * _energy_kept(albedo, view, rows)


def albedo_by_angle(brdf: Brdf) -> np.ndarray:
    """Directional albedo (16, 3) at the cosines COSINES of the angle between view and normal."""
    return directional_albedo(brdf, np.stack([np.sqrt(1 - COSINES**2), np.zeros_like(COSINES), COSINES], axis=-1))


def _energy_kept(albedo: np.ndarray, view: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Ratio (n, 1, 3) of the true directional albedo, by quadrature over half vectors, to the sum of the rows."""
    true = np.stack([np.interp(view[:, 2], COSINES, channel) for channel in albedo.T], axis=-1)
    return (true / np.maximum(rows.sum(axis=1), 1e-9))[:, None].clip(0.2, 5)


def directional_albedo(brdf: Brdf, view: np.ndarray, count: int = 48) -> np.ndarray:
    """Share of the light reflected (n, 3) when the view directions (n, 3) are the incoming ones; surface normal +z.

    Half the quadrature goes over half vectors, dense about the mirror, and half over a cosine hemisphere, joined by the
    balance heuristic (Veach and Guibas, SIGGRAPH 1995).
    """
    u, v = ((np.indices((count, count)) + 0.5) / count).reshape(2, -1)
    a2 = 0.02**2
    cos_h = np.sqrt((1 - u) / (1 + (a2 - 1) * u))
    half = _polar(cos_h, 2 * np.pi * v)
    lobes = view[:, None] * -1 + 2 * (view @ half.T)[..., None] * half
    cosine = np.broadcast_to(_polar(np.sqrt(1 - u), 2 * np.pi * v), lobes.shape)
    light = np.concatenate([lobes, cosine], axis=1)
    seen = np.broadcast_to(view[:, None], light.shape)
    middle = light + seen
    middle = middle / np.maximum(np.linalg.norm(middle, axis=-1, keepdims=True), 1e-9)
    density = a2 / (np.pi * (middle[..., 2] ** 2 * (a2 - 1) + 1) ** 2)
    by_half = density * middle[..., 2] / np.maximum(4 * np.abs((middle * seen).sum(axis=-1)), 1e-9)
    by_cosine = np.clip(light[..., 2], 0, None) / np.pi
    weight = np.clip(light[..., 2], 0, None) / np.maximum((by_half + by_cosine) * len(u), 1e-12)
    return (brdf(light, seen) * weight[..., None]).sum(axis=1)


def _polar(cosine: np.ndarray, azimuth: np.ndarray) -> np.ndarray:
    sine = np.sqrt(np.clip(1 - cosine**2, 0, None))
    return np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), cosine], axis=-1)


def charts(brdf: Brdf, lights: list[Light], side: int = SIDE, coarse: int = 33) -> np.ndarray:
    """Colour charts (k, side, side, 3) of a material under lights; the transfer matrix is made once, on `coarse`
    normals.
    """
    normals = chart_normals(coarse)
    directions = sphere(len(lights[0].radiance))
    stack = np.stack([light.radiance for light in lights], axis=-1)  # (d, 3, k)
    made = np.empty((coarse, coarse, 3, len(lights)))
    albedo = albedo_by_angle(brdf)
    for i in range(coarse):
        made[i] = np.einsum("ndc,dck->nck", transfer(brdf, normals[i], directions, albedo), stack)
    return np.moveaxis(_finer(made, side), -1, 0)


def _finer(tables: np.ndarray, side: int) -> np.ndarray:
    """Charts (s, s, ...) on another number of entries, linearly."""
    from scipy.ndimage import map_coordinates

    if len(tables) == side:
        return tables
    at = np.meshgrid(*[np.linspace(0, len(tables) - 1, side)] * 2, indexing="ij")
    flat = tables.reshape(*tables.shape[:2], -1)
    made = np.stack([map_coordinates(flat[..., c], at, order=1) for c in range(flat.shape[-1])], axis=-1)
    return made.reshape(side, side, *tables.shape[2:])


def grey(colour: np.ndarray) -> np.ndarray:
    """Mean of the channels (...,) of (..., 3)."""
    return colour.mean(axis=-1)


def shade(table: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Look normals (..., 3) up in a chart (s, s) or (s, s, 3), linearly: a picture of a uniform object."""
    from scipy.ndimage import map_coordinates

    at = (np.clip(normals[..., :2], -1, 1) + 1) / 2 * (len(table) - 1)
    at = np.moveaxis(at, -1, 0).reshape(2, -1)
    planes = table[..., None] if table.ndim == 2 else table
    looked = np.stack([map_coordinates(planes[..., c], at, order=1) for c in range(planes.shape[-1])], axis=-1)
    return looked.reshape(*normals.shape[:-1], *table.shape[2:])
