"""Thin plates through scattered points: nodes on a grid, bilinear between them, bending energy over it (3.10)."""

from __future__ import annotations

from functools import cache

import numpy as np

from ipcli.errors import ParameterError

HUBER = 1.345  # standard deviations beyond which a residual counts linearly: 95 % efficient for normal noise
NORMAL = 1.4826  # standard deviations of a normal law in a median absolute deviation
FLOOR = 1e-12  # keeps nodes that no point and no bending ties down, relative to the mean diagonal


def sampling(at: np.ndarray, shape: tuple[int, int]):
    """Sparse (n, rows * columns) matrix that samples a grid of this shape at points (n, 2), column and row in cells."""
    from scipy.sparse import csr_matrix

    limit = np.array([shape[1] - 1, shape[0] - 1])
    low = np.clip(np.floor(at).astype(np.int64), 0, np.maximum(limit - 1, 0))
    share = np.clip(at - low, 0.0, 1.0)
    x, y = share[:, 0], share[:, 1]
    first = low[:, 1] * shape[1] + low[:, 0]
    columns = np.stack([first, first + 1, first + shape[1], first + shape[1] + 1], axis=1)
    values = np.stack([(1 - x) * (1 - y), x * (1 - y), (1 - x) * y, x * y], axis=1)
    rows = np.repeat(np.arange(len(at)), 4)
    return csr_matrix((values.ravel(), (rows, columns.ravel())), (len(at), shape[0] * shape[1]))


@cache
def bending(shape: tuple[int, int]):
    """Sparse matrix of the bending energy sum S_XX^2 + 2 S_XY^2 + S_YY^2 of a grid, in cells."""
    from scipy.sparse import diags, eye, kron

    def second(n: int):
        return diags([1.0, -2.0, 1.0], [0, 1, 2], shape=(n - 2, n))

    def first(n: int):
        return diags([-1.0, 1.0], [0, 1], shape=(n - 1, n))

    rows, columns = shape
    xx = kron(eye(rows), second(columns))
    yy = kron(second(rows), eye(columns))
    xy = kron(first(rows), first(columns))
    return (xx.T @ xx + yy.T @ yy + 2 * xy.T @ xy).tocsc()


def fit(
    at: np.ndarray,
    values: np.ndarray,
    shape: tuple[int, int],
    stiffness: float,
    *,
    weights: np.ndarray | None = None,
    rounds: int = 0,
) -> np.ndarray:
    """Nodes (rows, columns) of the plate that is nearest to values (n,) at points (n, 2), column and row in cells.

    Minimises the weighted sum of squared residuals plus `stiffness` times the bending energy, in cells. With `rounds`
    that many more solves weigh residuals as Huber's loss does, so that a few gross errors do not bend the plate.
    ParameterError for fewer than three points or a grid below 3 x 3.
    """
    if len(at) < 3 or min(shape) < 3:
        raise ParameterError(f"a thin plate needs three points and 3 x 3 nodes, got {len(at)} points and {shape} nodes")
    sample = sampling(at, shape)
    given = np.ones(len(at)) if weights is None else weights
    nodes = _solve(sample, values, given, shape, stiffness)
    for _ in range(rounds):
        off = np.abs(values - sample @ nodes)
        scale = NORMAL * float(np.median(off)) or 1.0
        robust = given * np.minimum(1.0, HUBER * scale / np.maximum(off, 1e-300))
        nodes = _solve(sample, values, robust, shape, stiffness)
    return nodes.reshape(shape)


def _solve(sample, values: np.ndarray, weights: np.ndarray, shape: tuple[int, int], stiffness: float) -> np.ndarray:
    """The normal equations by a sparse factorisation that keeps their symmetry in its ordering."""
    from scipy.sparse import identity
    from scipy.sparse.linalg import splu

    weighted = sample.multiply(weights[:, None]).tocsr()
    matrix = (sample.T @ weighted).tocsc() + stiffness * bending(shape)
    matrix = matrix + FLOOR * float(matrix.diagonal().mean()) * identity(matrix.shape[0], format="csc")
    solver = splu(matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    return solver.solve(weighted.T @ values)
