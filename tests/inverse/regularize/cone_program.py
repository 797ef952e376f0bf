"""The exact minimum of the TGV or TV problem on a small image, as a second-order cone program solved by interior
points.

Independent of the package: the differences are written down again, pixel by pixel.
"""

from __future__ import annotations

import clarabel
import numpy as np
from scipy import sparse


class Program:
    """Rows A z + s = b with s in cones, over the unknowns z = (x, v1, v2, |g| bounds, |E| bounds, |x - d_k| bounds)."""

    def __init__(self, shape: tuple[int, int], k: int):
        self.shape, n = shape, shape[0] * shape[1]
        self.size = n * (5 + k)
        self.index = np.arange(self.size).reshape(5 + k, *shape)
        self.entries: list[tuple[int, int, float]] = []
        self.right: list[float] = []
        self.cones: list[object] = []

    def cone(self, kind, rows: list[dict[int, float]], constants=None) -> None:
        """Each row {unknown: factor} plus its constant is an entry of one point in a cone of this kind."""
        for row, constant in zip(rows, constants or [0.0] * len(rows), strict=True):
            self.entries += [(len(self.right), unknown, -factor) for unknown, factor in row.items()]
            self.right.append(constant)
        self.cones.append(kind(len(rows)))

    def solve(self, cost: np.ndarray):
        row, column, value = zip(*self.entries, strict=True)
        a = sparse.csc_matrix((value, (row, column)), shape=(len(self.right), self.size))
        settings = clarabel.DefaultSettings()
        settings.verbose = False
        p = sparse.csc_matrix((self.size, self.size))
        return clarabel.DefaultSolver(p, cost, a, np.array(self.right), self.cones, settings).solve()


def minimum(
    layers: np.ndarray, weights: np.ndarray, alpha1: float, alpha0: float, order: int = 2
) -> tuple[float, np.ndarray]:
    """Least energy and a minimiser (h, w) for layers and weights (K, h, w), NaN = no observation."""
    k, h, w = layers.shape
    program = Program((h, w), k)
    x, v1, v2, slope, curvature = program.index[:5]
    for i, j in np.ndindex(h, w):
        _first_order(program, i, j, order)
        if order == 2:
            _second_order(program, i, j)
        for m in np.flatnonzero(np.isfinite(layers[:, i, j])):
            bound, d = program.index[5 + m, i, j], float(layers[m, i, j])
            program.cone(clarabel.NonnegativeConeT, [{bound: 1, x[i, j]: -1}, {bound: 1, x[i, j]: 1}], [d, -d])
        missing = program.index[5:, i, j][~np.isfinite(layers[:, i, j])]
        unused = [*missing, *([] if order == 2 else [v1[i, j], v2[i, j], curvature[i, j]])]
        for unknown in unused:
            program.cone(clarabel.ZeroConeT, [{unknown: 1}])
    cost = np.zeros(program.size)
    cost[slope], cost[curvature] = alpha1, alpha0
    cost[program.index[5:]] = np.where(np.isfinite(layers), weights, 0)
    solution = program.solve(cost)
    assert str(solution.status) == "Solved", solution.status
    return float(solution.obj_val), np.array(solution.x)[x]


def _first_order(program: Program, i: int, j: int, order: int) -> None:
    x, v1, v2, slope, _ = program.index[:5]
    h, w = program.shape
    rows = [{slope[i, j]: 1.0}]
    if j + 1 < w:
        rows.append({x[i, j + 1]: 1.0, x[i, j]: -1.0} | ({v1[i, j]: -1.0} if order == 2 else {}))
    if i + 1 < h:
        rows.append({x[i + 1, j]: 1.0, x[i, j]: -1.0} | ({v2[i, j]: -1.0} if order == 2 else {}))
    program.cone(clarabel.SecondOrderConeT, rows)


def _second_order(program: Program, i: int, j: int) -> None:
    _, v1, v2, _, curvature = program.index[:5]
    rows = [{curvature[i, j]: 1.0}]
    if j:
        rows.append({v1[i, j]: 1.0, v1[i, j - 1]: -1.0})
    if i:
        rows.append({v2[i, j]: 1.0, v2[i - 1, j]: -1.0})
    if i and j:
        half = np.sqrt(2) / 2  # the mixed entry is halved and counts twice
        rows.append({v1[i, j]: half, v1[i - 1, j]: -half, v2[i, j]: half, v2[i, j - 1]: -half})
    program.cone(clarabel.SecondOrderConeT, rows)
