"""The energy of a height field given its reflectance map, and Gauss-Newton with iteratively reweighted squares on it.

    E(z) = omega sum rho_a(I - R(n)) + w_n sum rho_b(|T0' n|) + w_b sum rho_c(|D2 (z - z0)|)

on the 2 x 2 cells of a grid; rho is Huber's function of unit slope, T0 spans the plane across the prior normal n0, so
that |T0' n| is the sine of the angle between n and n0. The bending acts on the displacement from the prior shape. With
slopes p, q and W^2 = 1 + p^2 + q^2: dn_x/dp = -(1 + q^2) / W^3, dn_x/dq = dn_y/dp = p q / W^3, dn_y/dq = -(1 + p^2) /
W^3.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ipcli.models.brdf.grid import Grid, normals_of_slopes
from ipcli.models.brdf.parameters import Weights
from ipcli.models.brdf.reflectance import Map

STEPS = (1.0, 0.4, 0.1)
ANCHOR = 1e-6  # holds the constant, on which nothing else depends


@dataclass(frozen=True, eq=False)
class ShadedProblem:
    """What is known: the picture on the cells and the prior shape on the pixels of the grid."""

    grid: Grid
    intensity: np.ndarray  # (c,), over its 95th percentile
    prior: np.ndarray  # (n,) z0
    prior_normals: np.ndarray  # (c, 3) n0
    weights: Weights
    trust: np.ndarray | None = None  # (c,) weight of n0 on each cell, 1 if not given


@dataclass(frozen=True, eq=False)
class Linear:
    """The energy, its gradient (n,) and its reweighted Gauss-Newton matrix (n, n) at a point."""

    energy: float
    gradient: np.ndarray
    assemble: Callable[[], Any]

    @property
    def hessian(self) -> Any:
        """The matrix, assembled when it is asked for: most of the work, and descent by gradients needs none."""
        return self.assemble()


def huber(r: np.ndarray, width: float) -> np.ndarray:
    """r^2 / (2 width) up to |r| = width, then |r| - width / 2."""
    a = np.abs(r)
    return np.where(a <= width, a * a / (2 * width), a - width / 2)


def cell_normals(grid: Grid, height: np.ndarray) -> np.ndarray:
    """Normals (c, 3) on the cells of heights (n,)."""
    return normals_of_slopes(grid.slope_x @ height, grid.slope_y @ height)


def tangents(normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors (c, 3) each across unit normals (c, 3), orthogonal to each other: null(n)."""
    x, y, z = normals.T
    a = 1 / (1 + np.maximum(z, -0.999))
    return np.stack([1 - x * x * a, -x * y * a, -x], axis=-1), np.stack([-x * y * a, 1 - y * y * a, -y], axis=-1)


def energy(problem: ShadedProblem, reflectance: Map, omega: float, height: np.ndarray) -> float:
    """E at heights (n,)."""
    w = problem.weights
    n = cell_normals(problem.grid, height)
    photo = problem.intensity - reflectance.slopes(n)[0]
    t, s = tangents(problem.prior_normals)
    sine = np.hypot((t * n).sum(axis=1), (s * n).sum(axis=1))
    bend = np.sqrt(sum((b @ (height - problem.prior)) ** 2 for b in problem.grid.bend))
    trust = 1.0 if problem.trust is None else problem.trust
    return float(
        omega * huber(photo, w.photo_width).sum()
        + w.normal * (trust * huber(sine, w.normal_width)).sum()
        + w.bending * huber(bend, w.bending_width).sum()
    )


def linearise(problem: ShadedProblem, reflectance: Map, omega: float, height: np.ndarray) -> Linear:
    """E, its exact gradient and the Gauss-Newton matrix of the reweighted squares."""
    from scipy.sparse import diags

    grid, w = problem.grid, problem.weights
    p, q = grid.slope_x @ height, grid.slope_y @ height
    n, (dp, dq) = normals_of_slopes(p, q), normal_slopes(p, q)
    shade, slope = reflectance.slopes(n)
    photo = problem.intensity - shade
    rows = [
        (photo, -(slope * dp).sum(axis=1), -(slope * dq).sum(axis=1), omega / np.maximum(np.abs(photo), w.photo_width))
    ]
    t, s = tangents(problem.prior_normals)
    across = [(v * n).sum(axis=1) for v in (t, s)]
    trust = 1.0 if problem.trust is None else problem.trust
    lag = w.normal * trust / np.maximum(np.hypot(*across), w.normal_width)
    rows += [(r, (v * dp).sum(axis=1), (v * dq).sum(axis=1), lag) for v, r in zip((t, s), across, strict=True)]
    g_p, g_q = (sum(row[i] * row[3] * row[0] for row in rows) for i in (1, 2))
    pp, pq, qq = (sum(row[i] * row[j] * row[3] for row in rows) for i, j in ((1, 1), (1, 2), (2, 2)))
    x, y = grid.slope_x, grid.slope_y
    away = height - problem.prior
    bends = [b @ away for b in grid.bend]
    bend_lag = w.bending / np.maximum(np.sqrt(sum(b * b for b in bends)), w.bending_width)
    gradient = x.T @ g_p + y.T @ g_q + sum(b.T @ (bend_lag * r) for b, r in zip(grid.bend, bends, strict=True))

    def assemble() -> Any:
        cross = x.T @ diags(pq) @ y
        shading = x.T @ diags(pp) @ x + y.T @ diags(qq) @ y + cross + cross.T
        return shading + sum(b.T @ diags(bend_lag) @ b for b in grid.bend)

    return Linear(energy(problem, reflectance, omega, height), gradient, assemble)


def normal_slopes(p: np.ndarray, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """dn/dp and dn/dq (c, 3) of the unit normal of slopes p, q (c,)."""
    w3 = (1 + p * p + q * q) ** 1.5
    return np.stack([-(1 + q * q), p * q, -p], axis=-1) / w3[:, None], np.stack(
        [p * q, -(1 + p * p), -q], axis=-1
    ) / w3[:, None]


def gauss_newton(
    problem: ShadedProblem, reflectance: Map, omega: float, height: np.ndarray, steps: int, damping: float = 0.02
) -> np.ndarray:
    """Heights (n,) after some steps that each lower E; damped by `damping` |grad delta|^2, more when no step length
    helps.
    """
    from scipy.sparse import identity

    grid = problem.grid
    smooth = grid.slope_x.T @ grid.slope_x + grid.slope_y.T @ grid.slope_y
    anchor = ANCHOR * identity(grid.size, format="csr")
    mu = damping
    for _ in range(steps):
        here = linearise(problem, reflectance, omega, height)
        delta = factor(here.hessian + mu * smooth + anchor).solve(-here.gradient)
        for length in STEPS:
            if energy(problem, reflectance, omega, height + length * delta) < here.energy:
                height = height + length * delta
                mu = max(mu / 3, 1e-4) if length == 1 else mu
                break
        else:
            mu *= 10
            if mu > 1e4:
                break
    return height


def factor(matrix: Any) -> Any:
    """LU of a sparse symmetric positive definite matrix, in an order made for that."""
    from scipy.sparse.linalg import splu

    return splu(matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})


def log_determinant(matrix: Any) -> float:
    """log det of a sparse symmetric positive definite matrix, from the diagonal of its LU."""
    return float(np.log(np.abs(factor(matrix).U.diagonal())).sum())
