"""Refinement of a height field by convex optimisation: normals, shading through a normal of its own, TGV^2 of the
height (7.8)-(7.10).

    min_z  w |T0' (-z_x, -z_y, 1)| + (1 / theta) |Tv' (-z_x, -z_y, 1)| + TGV^2(z),     T0 = null(n0), Tv = null(nu)

The thesis linearises n(z) = T grad z + n_l, which has no fixed point but flat surfaces. |T0' m| = |m| sin(angle(m,
n0)) is convex, linear in grad z, and needs no relinearisation. The shading acts on the normal nu by a search in the
table R(nu) near n(z), weighed by 1 / theta, which grows. `thesis_sweeps` is the printed scheme, kept to document what
it does.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipcli.inverse.regularize.operators import (
    gradient,
    gradient_adjoint,
    symmetrised_gradient,
    symmetrised_gradient_adjoint,
)
from ipcli.inverse.regularize.pdhg import pdhg
from ipcli.inverse.regularize.proximal import project_balls
from ipcli.models.brdf.energy import tangents
from ipcli.models.brdf.parameters import Refinement
from ipcli.models.brdf.reflectance import Map

MIXED = np.sqrt([1.0, 1.0, 2.0])[:, None, None]  # makes the plain product of (11, 22, 12) that of symmetric matrices


@dataclass(frozen=True, eq=False)
class Tilt:
    """w |B g + b| at every pixel, g = (z_x, z_y) with y up: how far a normal field is from that of the height."""

    matrix: np.ndarray  # (2, 2, h, w)
    offset: np.ndarray  # (2, h, w)

    @classmethod
    def of(cls, normals: np.ndarray, weight: np.ndarray) -> Tilt:
        """From unit normals (h, w, 3) and weights (h, w); 0 where there is none."""
        n = np.where(np.isfinite(normals), normals, [0, 0, 1.0]).reshape(-1, 3)
        t, s = (v.reshape(*weight.shape, 3) for v in tangents(n))
        rows = np.stack([t, s])
        matrix = -np.moveaxis(rows[..., :2], -1, 1) * weight
        return cls(matrix, rows[..., 2] * weight)

    def linear(self, g: np.ndarray) -> np.ndarray:
        """B g (2, h, w)."""
        return np.einsum("ijhw,jhw->ihw", self.matrix, g)

    def adjoint(self, q: np.ndarray) -> np.ndarray:
        """B' q (2, h, w)."""
        return np.einsum("ijhw,ihw->jhw", self.matrix, q)


def slopes(z: np.ndarray, inside: np.ndarray) -> np.ndarray:
    """Forward differences (2, h, w), x right and y UP, where both pixels are in the mask (2, h, w); else 0."""
    return gradient(z) * inside


def links(mask: np.ndarray) -> np.ndarray:
    """Signed mask (2, h, w) of the forward differences that stay in the mask; rows run down, so the second is
    negative.
    """
    inside = np.zeros((2, *mask.shape))
    inside[0, :, :-1] = mask[:, 1:] & mask[:, :-1]
    inside[1, :-1] = -(mask[1:] & mask[:-1]).astype(float)
    return inside


def integrate(tilts: list[Tilt], mask: np.ndarray, start: np.ndarray, params: Refinement) -> np.ndarray:
    """Height (h, w) that minimises the sum of the tilts and TGV^2, from a start; mean of the mask kept."""
    inside = links(mask)
    alpha1, alpha0 = params.tgv, 2 * params.tgv
    squared = sum(float((t.matrix**2).sum(axis=(0, 1)).max()) for t in tilts)
    norm = np.sqrt(8 * squared + 12)
    size, count = mask.size, len(tilts)

    def unpack(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return x[:size].reshape(mask.shape), x[size:].reshape(2, *mask.shape)

    def forward(x: np.ndarray) -> np.ndarray:
        z, v = unpack(x)
        g = slopes(z, inside)
        curved = symmetrised_gradient(v) * mask * MIXED
        return np.concatenate([*(t.linear(g) for t in tilts), (g - v) * np.abs(inside), curved]).ravel()

    def adjoint(y: np.ndarray) -> np.ndarray:
        parts = y.reshape(2 * count + 5, *mask.shape)
        p, q = parts[2 * count : 2 * count + 2] * np.abs(inside), parts[2 * count + 2 :] * mask
        back = p + sum(t.adjoint(parts[2 * k : 2 * k + 2]) for k, t in enumerate(tilts))
        of_v = symmetrised_gradient_adjoint(q / MIXED) - p
        return np.concatenate([gradient_adjoint(back * inside).ravel(), of_v.ravel()])

    def prox_conjugate(y: np.ndarray, sigma: float) -> np.ndarray:
        parts = y.reshape(2 * count + 5, *mask.shape).copy()
        for k, tilt in enumerate(tilts):
            parts[2 * k : 2 * k + 2] = project_balls(parts[2 * k : 2 * k + 2] + sigma * tilt.offset, 1.0, (1, 1))
        parts[2 * count : 2 * count + 2] = project_balls(parts[2 * count : 2 * count + 2], alpha1, (1, 1))
        parts[2 * count + 2 :] = project_balls(parts[2 * count + 2 :], alpha0, (1, 1, 1))
        return parts.ravel()

    first = np.concatenate([np.where(mask, start, 0).ravel(), slopes(np.where(mask, start, 0), inside).ravel()])
    step = params.step / norm
    x, _ = pdhg(
        forward,
        adjoint,
        lambda x, tau: x,
        prox_conjugate,
        first,
        np.zeros((2 * count + 5) * size),
        tau=step,
        sigma=0.99 / (norm * params.step),
        iterations=params.iterations,
        relaxation=1.8,
    )
    z = unpack(x)[0]
    return np.where(mask, z - z[mask].mean() + np.nan_to_num(start)[mask].mean(), np.nan)


def refine(
    height: np.ndarray, prior: np.ndarray, intensity: np.ndarray, mask: np.ndarray, reflectance: Map, params: Refinement
) -> np.ndarray:
    """Height (h, w) after some rounds: nu from the shading near n(z), then z from the prior's normals and from nu.

    `prior` (h, w, 3) are normals n0, `intensity` (h, w) the picture on the scale of the map.
    """
    z, theta = np.where(mask, height, 0.0), params.theta
    base = Tilt.of(prior, np.where(mask, params.normal, 0.0))
    for _ in range(params.rounds):
        n = forward_normals(z, mask)
        nu = search(n, intensity, mask, reflectance, theta, params)
        shaded = Tilt.of(nu, np.where(mask, params.photo / theta, 0.0))
        z = np.nan_to_num(integrate([base, shaded], mask, z, params))
        theta = max(theta * 0.7, 0.1)
    return np.where(mask, z, np.nan)


def forward_normals(z: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Unit normals (h, w, 3) of the forward differences, those the convex energy is made of."""
    g = slopes(np.where(mask, z, 0.0), links(mask))
    m = np.stack([-g[0], -g[1], np.ones_like(z)], axis=-1)
    return m / np.linalg.norm(m, axis=-1, keepdims=True)


def search(
    n: np.ndarray, intensity: np.ndarray, mask: np.ndarray, reflectance: Map, theta: float, params: Refinement
) -> np.ndarray:
    """Normals nu (h, w, 3) of least |I - R(nu)| + |nu - n|^2 / (2 theta) among those of a table within a cap about
    n.
    """
    offsets = np.linspace(-1, 1, params.candidates) * np.sin(np.radians(params.cap))
    dx, dy = (part.ravel() for part in np.meshgrid(offsets, offsets))
    own, seen = n[mask], intensity[mask]
    best, least = own.copy(), np.full(len(own), np.inf)
    t, s = tangents(own)
    for a, b in zip(dx, dy, strict=True):
        tried = own + a * t + b * s
        tried /= np.linalg.norm(tried, axis=1, keepdims=True)
        tried[:, 2] = np.maximum(tried[:, 2], 0.02)
        cost = np.abs(seen - reflectance.slopes(tried)[0]) + ((tried - own) ** 2).sum(axis=1) / (2 * theta)
        better = cost < least
        best[better], least[better] = tried[better], cost[better]
    nu = np.zeros_like(n)
    nu[..., 2] = 1
    nu[mask] = best / np.linalg.norm(best, axis=1, keepdims=True)
    return nu


def thesis_sweeps(
    height: np.ndarray, n0: np.ndarray, mask: np.ndarray, iterations: int, *, weight: float = 1.0
) -> np.ndarray:
    """The printed iteration of 7.6 without shading, from a height: n_l <- P(T D z + n_l) adds the slope every sweep.

    It has no fixed point but a flat surface, and flattens even the true one; kept for the test that shows it.
    """
    inside = links(mask)
    z = np.where(mask, height, 0.0)
    ahead, p = z.copy(), np.zeros((2, *mask.shape))
    q, n_l = np.zeros((3, *mask.shape)), np.moveaxis(forward_normals(z, mask), -1, 0)
    target = np.moveaxis(np.nan_to_num(n0), -1, 0)
    tau = sigma = 0.99 / np.sqrt(8 * (1 + weight**2))
    for _ in range(iterations):
        t, s = (np.moveaxis(v.reshape(*mask.shape, 3), -1, 0) for v in tangents(np.moveaxis(n_l, 0, -1).reshape(-1, 3)))
        g = slopes(ahead, inside)
        p = project_balls(p + tau * g, 1.0, (1, 1))
        q = project_balls(q + tau * weight * (t * g[0] + s * g[1] + n_l - target) * mask, 1.0, (1, 1, 1))
        back = p + weight * np.stack([(t * q).sum(axis=0), (s * q).sum(axis=0)])
        before = z
        z = z - sigma * gradient_adjoint(back * inside)
        ahead = 2 * z - before
        g = slopes(z, inside)
        n_l = t * g[0] + s * g[1] + n_l
        n_l = n_l / np.linalg.norm(n_l, axis=0)
    return np.where(mask, z, np.nan)
