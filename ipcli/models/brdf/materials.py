"""Isotropic BRDFs: rough conductor, coated plastic, small networks, ABC fits and MERL tables (thesis 7.3).

Directions are unit vectors (..., 3) in the frame of the surface, whose normal is +z. A BRDF is a function
(light, view) -> (..., 3), linear RGB, 1/sr, that is zero below the surface.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

TINY = 1e-9
MERL_SHAPE = (90, 90, 180)  # theta_half (by its root), theta_difference, phi_difference
MERL_SCALE = np.array([1.0, 1.15, 1.66]) / 1500.0  # of the stored numbers, after the authors' reader


class Brdf(Protocol):
    """Reflectance of a material."""

    def __call__(self, light: np.ndarray, view: np.ndarray) -> np.ndarray:
        """Reflected radiance over irradiance (..., 3), 1/sr, for unit vectors (..., 3)."""
        ...


@dataclass(frozen=True)
class Matte:
    """Lambert's law: the same radiance to all sides."""

    albedo: tuple[float, ...]  # RGB

    def __call__(self, light: np.ndarray, view: np.ndarray) -> np.ndarray:
        """See `Brdf`."""
        above = (light[..., 2] > 0) & (view[..., 2] > 0)
        return np.where(above, 1 / np.pi, 0.0)[..., None] * np.array(self.albedo)


@dataclass(frozen=True)
class Conductor:
    """Rough metal: GGX normals, Smith shadowing, exact Fresnel reflection of a conductor (Walter et al., EGSR 2007)."""

    eta: tuple[float, ...]  # refraction, RGB
    kappa: tuple[float, ...]  # extinction, RGB
    roughness: float

    def __call__(self, light: np.ndarray, view: np.ndarray) -> np.ndarray:
        """See `Brdf`."""
        lobe, cosine = _ggx(light, view, self.roughness)
        return lobe[..., None] * conductor_fresnel(cosine, np.array(self.eta), np.array(self.kappa))


@dataclass(frozen=True)
class Plastic:
    """Coloured diffuse ground under a clear rough coat of refraction `eta`; symmetric in light and view."""

    diffuse: tuple[float, ...]  # albedo, RGB
    eta: float
    roughness: float

    def __call__(self, light: np.ndarray, view: np.ndarray) -> np.ndarray:
        """See `Brdf`."""
        lobe, cosine = _ggx(light, view, self.roughness)
        through = (1 - dielectric_fresnel(light[..., 2], self.eta)) * (1 - dielectric_fresnel(view[..., 2], self.eta))
        above = (light[..., 2] > 0) & (view[..., 2] > 0)
        ground = np.where(above, through, 0.0)[..., None] * np.array(self.diffuse) / np.pi
        return ground + (lobe * dielectric_fresnel(cosine, self.eta))[..., None]


@dataclass(frozen=True, eq=False)
class Network:
    """A network of two hidden layers fitted to a measured table (Sztrajman et al., CGF 2021): max(exp(MLP) - 1, 0)."""

    weights: Mapping[str, np.ndarray]  # k1 (6, 21), b1, k2 (21, 21), b2, k3 (21, 3), b3

    def __call__(self, light: np.ndarray, view: np.ndarray) -> np.ndarray:
        """See `Brdf`."""
        half, difference = half_difference(light, view)
        x = np.concatenate([half[..., [0]], np.zeros_like(half[..., :1]), half[..., [2]], difference], axis=-1).astype(
            np.float32
        )
        w = self.weights
        x = np.maximum(x @ w["k1"] + w["b1"], 0)
        x = np.maximum(x @ w["k2"] + w["b2"], 0)
        value = np.maximum(np.exp(np.minimum(x @ w["k3"] + w["b3"], 20)) - 1, 0)
        return np.where(((light[..., 2] > 0) & (view[..., 2] > 0))[..., None], value, 0).astype(np.float64)


@dataclass(frozen=True)
class Abc:
    """The ABC model of smooth surfaces (Loew et al., TOG 2012): diffuse + A / (1 + B (1 - cos theta_half))^C, Fresnel,
    shadowing.
    """

    diffuse: tuple[float, ...]  # RGB
    scale: tuple[float, ...]  # A, RGB
    width: float  # B
    falloff: float  # C
    eta: float

    def __call__(self, light: np.ndarray, view: np.ndarray) -> np.ndarray:
        """See `Brdf`."""
        half = _unit(light + view)
        toward = np.clip((half * view).sum(axis=-1), 0, 1)
        lobe = (1 + self.width * (1 - np.clip(half[..., 2], 0, 1))) ** -self.falloff
        fresnel = dielectric_fresnel(toward, self.eta)
        shadow = np.minimum(1, 2 * half[..., 2] * np.minimum(light[..., 2], view[..., 2]) / np.maximum(toward, TINY))
        cosines = np.maximum(light[..., 2] * view[..., 2], 1e-3)
        glossy = (lobe * fresnel * np.maximum(shadow, 0) / (np.pi * cosines))[..., None] * np.array(self.scale)
        above = (light[..., 2] > 0) & (view[..., 2] > 0)
        return np.where(above[..., None], np.array(self.diffuse) / np.pi + glossy, 0.0)


@dataclass(frozen=True, eq=False)
class Table:
    """A measured table (90, 90, 180, 3) over half and difference angles, as MERL stores them (Matusik et al., TOG
    2003).
    """

    values: np.ndarray

    def __call__(self, light: np.ndarray, view: np.ndarray) -> np.ndarray:
        """See `Brdf`; the nearest entry."""
        half, difference = half_difference(light, view)
        theta_h, theta_d = (np.arccos(np.clip(v[..., 2], 0, 1)) for v in (half, difference))
        phi = np.arctan2(difference[..., 1], difference[..., 0]) % np.pi  # reciprocity folds the other half
        n = MERL_SHAPE
        i = np.minimum((np.sqrt(theta_h / (np.pi / 2)) * n[0]).astype(int), n[0] - 1)
        j = np.minimum((theta_d / (np.pi / 2) * n[1]).astype(int), n[1] - 1)
        k = np.minimum((phi / np.pi * n[2]).astype(int), n[2] - 1)
        above = (light[..., 2] > 0) & (view[..., 2] > 0)
        return np.where(above[..., None], np.maximum(self.values[i, j, k], 0), 0.0)


def half_difference(light: np.ndarray, view: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Half vector turned to azimuth 0 and difference vector (..., 3) of Rusinkiewicz' coordinates (EGWR 1998)."""
    half = _unit(light + view)
    sine = np.maximum(np.hypot(half[..., 0], half[..., 1]), TINY)
    cos_phi = np.where(sine > 1e-7, half[..., 0] / sine, 1.0)
    sin_phi = np.where(sine > 1e-7, half[..., 1] / sine, 0.0)
    x, y = cos_phi * light[..., 0] + sin_phi * light[..., 1], cos_phi * light[..., 1] - sin_phi * light[..., 0]
    cosine = half[..., 2]
    difference = np.stack([cosine * x - sine * light[..., 2], y, sine * x + cosine * light[..., 2]], axis=-1)
    return np.stack([sine, np.zeros_like(sine), cosine], axis=-1), difference


def conductor_fresnel(cosine: np.ndarray, eta: np.ndarray, kappa: np.ndarray) -> np.ndarray:
    """Unpolarised reflectance (..., c) of conductors eta + i kappa (c,) at cosines (...) to the normal."""
    c = np.clip(cosine, 0, 1)[..., None]
    index = eta + 1j * kappa
    root = np.sqrt(index**2 - (1 - c**2) + 0j)
    s = (c - root) / (c + root)
    p = (index**2 * c - root) / (index**2 * c + root)
    return (np.abs(s) ** 2 + np.abs(p) ** 2) / 2


def dielectric_fresnel(cosine: np.ndarray, eta: float) -> np.ndarray:
    """Unpolarised reflectance (...) of a dielectric, from outside."""
    return conductor_fresnel(np.asarray(cosine), np.array([eta]), np.zeros(1))[..., 0]


def _ggx(light: np.ndarray, view: np.ndarray, roughness: float) -> tuple[np.ndarray, np.ndarray]:
    """D G / (4 cos cos) of the GGX distribution, and the cosine between light and half vector."""
    a2 = roughness**2
    half = _unit(light + view)
    li, vi = light[..., 2], view[..., 2]
    density = a2 / (np.pi * (half[..., 2] ** 2 * (a2 - 1) + 1) ** 2)
    # Smith's height-correlated G / (4 cos cos) needs no division by the cosines
    visible = 0.5 / np.maximum(li * np.sqrt(a2 + (1 - a2) * vi**2) + vi * np.sqrt(a2 + (1 - a2) * li**2), TINY)
    return np.where((li > 0) & (vi > 0), density * visible, 0.0), np.clip((half * light).sum(axis=-1), 0, 1)


def _unit(v: np.ndarray) -> np.ndarray:
    return v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), TINY)
