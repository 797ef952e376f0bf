"""A sheet: its silhouette is a cut edge and tells nothing of the slope there, so the light comes from the library.

For each map V_j of a library the scale and the shape are solved on a small grid, and judged by

    J_j = E_j + kappa (log det H_j - mean)

the evidence of the map by Laplace's approximation: without the determinant the most grazing light wins and flattens the
relief. The best few are solved again on the full grid and averaged with weights exp(-(J_j - J_min) / (share E_min)).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ipcli.models.brdf.energy import ANCHOR, ShadedProblem, cell_normals, gauss_newton, linearise, log_determinant
from ipcli.models.brdf.parameters import Sheet, Weights
from ipcli.models.brdf.reflectance import Chart
from ipcli.models.brdf.solid import Pictured, weights_of


@dataclass(frozen=True, eq=False)
class Explained:
    """How maps explain a picture of a sheet."""

    energy: np.ndarray  # (j,) E on the small grid
    evidence: np.ndarray  # (j,) J, less its least
    weight: np.ndarray  # (j,) posterior of the maps, sums to 1
    best: tuple[int, ...]  # maps that were solved on the full grid
    share: np.ndarray  # (b,) their weights, sum to 1
    heights: np.ndarray  # (b, n) surfaces under each
    scales: np.ndarray  # (b,) brightness of each map
    height: np.ndarray  # (n,) their mean
    residual: float  # mean |I - R(n)| under the best


def sheet(
    picture: Pictured,
    small: Pictured,
    tables: Sequence[np.ndarray],
    params: Sheet,
    tell: Callable[[float], None] = lambda share: None,
) -> Explained:
    """The surface of a sheet seen through one of grey charts (j, s, s); `small` is the same picture on the grid of the
    sweep.
    """
    weights = replace(params.weights, bending=params.weights.bending * params.sweep_bending)
    coarse = _problem(small, params, weights)
    fine = _problem(picture, params, params.weights)
    energies, dets = np.empty(len(tables)), np.empty(len(tables))
    for j, table in enumerate(tables):
        energies[j], dets[j] = _judged(coarse, Chart(table), params)
        tell(0.8 * (j + 1) / len(tables))
    evidence = energies + params.kappa * (dets - dets.mean())
    evidence = evidence - evidence.min()
    weight = weights_of(evidence, params.temperature * energies.min())
    best = np.argsort(-weight, kind="stable")[: params.best]
    solved = [_solved(fine, Chart(tables[j]), params.steps) for j in best]
    tell(1.0)
    share = weight[best] / weight[best].sum()
    heights = np.stack([height - height.mean() for height, _ in solved])
    first = _residual(fine, solved[0][1], solved[0][0])
    mean = (share[:, None] * heights).sum(axis=0)
    scales = np.array([chart.scale for _, chart in solved])
    return Explained(energies, evidence, weight, tuple(map(int, best)), share, heights, scales, mean, first)


def _problem(picture: Pictured, params: Sheet, weights: Weights) -> ShadedProblem:
    prior = params.relief * picture.inflated
    return ShadedProblem(picture.grid, picture.intensity, prior, cell_normals(picture.grid, prior), weights)


def _judged(problem: ShadedProblem, chart: Chart, params: Sheet) -> tuple[float, float]:
    from scipy.sparse import identity

    height, chart = _solved(problem, chart, params.sweep_steps)
    here = linearise(problem, chart, 1.0, height)
    return here.energy, log_determinant(here.hessian + 1e3 * ANCHOR * identity(problem.grid.size, format="csr"))


def _solved(problem: ShadedProblem, chart: Chart, steps: int, pieces: int = 3) -> tuple[np.ndarray, Chart]:
    """Shape and scale in turn."""
    height = problem.prior
    for _ in range(pieces):
        chart = fit_scale(problem, chart, height)
        height = gauss_newton(problem, chart, 1.0, height, max(1, steps // pieces))
    return height, chart


def fit_scale(problem: ShadedProblem, chart: Chart, height: np.ndarray) -> Chart:
    """The map at the brightness that explains the picture best, robustly."""
    n = cell_normals(problem.grid, height)
    shade = chart.slopes(n)[0] / chart.scale
    scale, weight = chart.scale, np.ones(len(shade))
    for _ in range(6):
        scale = float((weight * shade * problem.intensity).sum() / max((weight * shade * shade).sum(), 1e-12))
        weight = 1 / np.maximum(np.abs(problem.intensity - scale * shade), problem.weights.photo_width)
    return Chart(chart.table, max(scale, 1e-6))


def _residual(problem: ShadedProblem, chart: Chart, height: np.ndarray) -> float:
    n = cell_normals(problem.grid, height)
    return float(np.abs(problem.intensity - chart.slopes(n)[0]).mean())


def representatives(tables: np.ndarray, count: int) -> np.ndarray:
    """Indices of `count` charts that cover all (j, s, s): each the farthest from those before, after division by the
    mean.
    """
    flat = tables[:, ::4, ::4].reshape(len(tables), -1)
    flat = flat / np.maximum(flat.mean(axis=1, keepdims=True), 1e-12)
    chosen = [int(np.linalg.norm(flat - flat.mean(axis=0), axis=1).argmin())]
    distance = np.linalg.norm(flat - flat[chosen[0]], axis=1)
    while len(chosen) < min(count, len(tables)):
        chosen.append(int(distance.argmax()))
        distance = np.minimum(distance, np.linalg.norm(flat - flat[chosen[-1]], axis=1))
    return np.array(sorted(chosen))
