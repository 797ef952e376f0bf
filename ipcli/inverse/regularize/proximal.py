"""Proximal maps prox_{t f}(y) = argmin_x f(x) + |x - y|^2 / (2 t), in plain NumPy, and the identity that proves them.

They serve models that are not worth a kernel, and are the twins that the kernels are tested against.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np


def project_balls(p: np.ndarray, radius: float, multiplicity: tuple[int, ...]) -> np.ndarray:
    """Project a field p (c, ...) point by point on balls; component i counts `multiplicity[i]` times in the squared
    norm.

    (1, 1) gives the discs of a gradient field, (1, 1, 2) the Frobenius balls of a field of symmetric matrices. The prox
    of the conjugate of radius * |.|.
    """
    size = np.sqrt(sum(m * c * c for m, c in zip(multiplicity, p, strict=True)))
    return p * (radius / np.maximum(radius, size))


def shrink_balls(p: np.ndarray, radius: float, multiplicity: tuple[int, ...]) -> np.ndarray:
    """Prox of radius * |.|, the point-wise norm of `project_balls`: shorten every vector by radius, to 0 at
    the least.
    """
    size = np.sqrt(sum(m * c * c for m, c in zip(multiplicity, p, strict=True)))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(size > radius, p * (1 - radius / size), 0)


def absolute_deviations(y: np.ndarray, data: np.ndarray, weights: np.ndarray, t: float) -> np.ndarray:
    """Prox of sum_k w_k |x - d_k|, exact, for y (...), data and weights (K, ...); observations of weight 0 do not
    count.

    The minimiser is the median of the K data and the K + 1 points y + t s_m, s_m = sum w - 2 (w_(1) + ... + w_(m)) (Li
    and Osher, Comm. Math. Sci. 7(3), 2009).
    """
    missing = weights == 0
    order = np.argsort(np.where(missing, np.inf, data), axis=0, kind="stable")
    sorted_data = np.take_along_axis(np.where(missing, np.inf, data), order, axis=0)
    slopes = weights.sum(axis=0) - 2 * np.cumsum(np.take_along_axis(weights, order, axis=0), axis=0)
    x = y + t * weights.sum(axis=0)
    for d, slope in zip(sorted_data, slopes, strict=True):
        x = np.minimum(x, np.maximum(d, y + t * slope))
    return x


def squared_deviations(y: np.ndarray, data: np.ndarray, weights: np.ndarray, t: float) -> np.ndarray:
    """Prox of sum_k w_k (x - d_k)^2 / 2 for y (...), data and weights (K, ...)."""
    return (y + t * (weights * data).sum(axis=0)) / (1 + t * weights.sum(axis=0))


def moreau_residual(prox: Callable, conjugate_prox: Callable, y: np.ndarray, t: float) -> float:
    """Largest entry of y - prox_{t f}(y) - t prox_{f*/t}(y / t), which is zero for every convex f and t > 0.

    Both callables take (point, step).
    """
    return float(np.abs(y - prox(y, t) - t * conjugate_prox(y / t, 1 / t)).max())
