"""Least absolute deviations within a box: min_x |p + J x|_1 for |x_i| <= bound, J (n, k) with few columns.

Two ways to the same optimum, which is that of a linear programme: the saddle point of (6.8), whose dual variable lies
in the product of pointwise intervals [-1, 1], and iteratively reweighted least squares. The box is the trust region
without which (6.8) has no minimum in x for a fixed dual variable.
"""

from __future__ import annotations

import numpy as np

from ipcli.inverse.regularize.pdhg import pdhg

LEAST_WEIGHTED = 1e-9  # of the mean deviation: where the weights of `reweighted` end


def deviation(p: np.ndarray, jacobian: np.ndarray, x: np.ndarray) -> float:
    """The objective |p + J x|_1."""
    return float(np.abs(p + jacobian @ x).sum())


def primal_dual(p: np.ndarray, jacobian: np.ndarray, bound: float, iterations: int = 300) -> np.ndarray:
    """The minimiser (k,) by the primal-dual method of Chambolle and Pock.

    In the coordinates in which J has orthonormal columns the operator has norm 1, so the box is dealt with by a second
    dual variable: min |p + Q z|_1 + box(R^-1 z). Columns of J that depend on others are left out at 0.
    """
    basis, values, columns = np.linalg.svd(jacobian, full_matrices=False)
    kept = values > 1e-9 * max(float(values.max(initial=0.0)), 1e-300)
    if not kept.any():
        return np.zeros(jacobian.shape[1])
    to_x = columns[kept].T / values[kept]  # x = to_x z
    q, n = basis[:, kept], len(p)
    weight = 1.0 / np.linalg.norm(to_x, 2)

    def dual_step(y: np.ndarray, sigma: float) -> np.ndarray:
        inside = np.clip(y[:n] + sigma * p, -1.0, 1.0)
        free = y[n:]
        return np.concatenate([inside, free - sigma * np.clip(free / sigma, -weight * bound, weight * bound)])

    size = max(float(np.abs(p).mean()), 1e-12) * np.sqrt(n)  # of z over that of y
    z, _ = pdhg(
        lambda z: np.concatenate([q @ z, weight * (to_x @ z)]),
        lambda y: q.T @ y[:n] + weight * (to_x.T @ y[n:]),
        lambda z, tau: z,
        dual_step,
        np.zeros(int(kept.sum())),
        np.zeros(n + len(to_x)),
        tau=size / np.sqrt(n) / np.sqrt(2),
        sigma=np.sqrt(n) / size / np.sqrt(2),
        iterations=iterations,
    )
    return np.clip(to_x @ z, -bound, bound)


def reweighted(p: np.ndarray, jacobian: np.ndarray, bound: float, iterations: int = 40) -> np.ndarray:
    """The minimiser (k,) by least squares, each deviation weighted by the inverse of its last size."""
    from scipy.optimize import lsq_linear

    x = np.zeros(jacobian.shape[1])
    scale = max(float(np.abs(p).mean()), 1e-300)
    for k in range(iterations):
        least = scale * max(LEAST_WEIGHTED, 0.1 * 0.4**k)
        root = 1.0 / np.sqrt(np.maximum(np.abs(p + jacobian @ x), least))
        factor = np.asarray(np.linalg.qr(np.column_stack([root[:, None] * jacobian, root * p]), mode="r"))
        new = np.linalg.lstsq(factor[:, :-1], -factor[:, -1], rcond=None)[0]
        if np.abs(new).max() > bound:
            new = lsq_linear(factor[:, :-1], -factor[:, -1], (-bound, bound)).x
        if np.abs(new - x).max() < 1e-6 * bound and least == scale * LEAST_WEIGHTED:
            return new
        x = new
    return x
