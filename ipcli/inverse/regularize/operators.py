"""Difference operators of TGV on an image grid, their adjoints, and the test that proves a pair adjoint.

Discretisation of Bredies, Kunisch and Pock (SIAM J. Imaging Sci. 2010): forward differences in the gradient, backward
ones in the symmetrised gradient, whose mixed entry is halved and counts twice in the inner product. Differences that
would leave the image are zero, so that both operators vanish exactly on the functions they should, up to the border.
The thesis' own code takes forward differences in both and does not halve the mixed entry, so its energies are not
comparable with these.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

NORM = np.sqrt(
    12.0
)  # of (x, v) -> (grad x - v, E v): an upper bound, the true value tends to sqrt((17 + sqrt 33) / 2) = 3.37


def gradient(x: np.ndarray) -> np.ndarray:
    """Forward differences (2, h, w) of an image (h, w), along the columns first; zero in the last column and row."""
    g = np.zeros((2, *x.shape), x.dtype)
    g[0, :, :-1] = x[:, 1:] - x[:, :-1]
    g[1, :-1] = x[1:] - x[:-1]
    return g


def gradient_adjoint(p: np.ndarray) -> np.ndarray:
    """The adjoint (h, w) of `gradient`: minus the divergence of p (2, h, w)."""
    a = np.zeros_like(p[0])
    a[:, :-1] -= p[0, :, :-1]
    a[:, 1:] += p[0, :, :-1]
    a[:-1] -= p[1, :-1]
    a[1:] += p[1, :-1]
    return a


def symmetrised_gradient(v: np.ndarray) -> np.ndarray:
    """E v = (d1 v1, d2 v2, (d2 v1 + d1 v2) / 2), (3, h, w), by backward differences of a field v (2, h, w)."""
    e = np.zeros((3, *v.shape[1:]), v.dtype)
    e[0, :, 1:] = v[0, :, 1:] - v[0, :, :-1]
    e[1, 1:] = v[1, 1:] - v[1, :-1]
    e[2, 1:, 1:] = (v[0, 1:, 1:] - v[0, :-1, 1:] + v[1, 1:, 1:] - v[1, 1:, :-1]) / 2
    return e


def symmetrised_gradient_adjoint(q: np.ndarray) -> np.ndarray:
    """The adjoint (2, h, w) of `symmetrised_gradient` for the inner product q11 e11 + q22 e22 + 2 q12 e12."""
    a = np.zeros((2, *q.shape[1:]), q.dtype)
    a[0, :, 1:] += q[0, :, 1:]
    a[0, :, :-1] -= q[0, :, 1:]
    a[1, 1:] += q[1, 1:]
    a[1, :-1] -= q[1, 1:]
    mixed = q[2, 1:, 1:]
    a[0, 1:, 1:] += mixed
    a[0, :-1, 1:] -= mixed
    a[1, 1:, 1:] += mixed
    a[1, 1:, :-1] -= mixed
    return a


def symmetric_product(q: np.ndarray, e: np.ndarray) -> float:
    """Inner product of two fields (3, h, w) of symmetric 2 x 2 matrices, stored as (11, 22, 12)."""
    return float(np.vdot(q[0], e[0]) + np.vdot(q[1], e[1]) + 2 * np.vdot(q[2], e[2]))


def dot_test(
    forward: Callable[[np.ndarray], np.ndarray],
    adjoint: Callable[[np.ndarray], np.ndarray],
    x: np.ndarray,
    y: np.ndarray,
    range_product: Callable[[np.ndarray, np.ndarray], float] = np.vdot,
) -> float:
    """|<A x, y> - <x, A* y>| relative to the size of the products: near the unit round-off if and only if A* is the
    adjoint.

    `range_product` is the inner product of the space A maps into.
    """
    image = forward(x)
    left, right = range_product(image, y), np.vdot(x, adjoint(y))
    size = np.linalg.norm(image) * np.linalg.norm(y) + np.linalg.norm(x) * np.linalg.norm(adjoint(y))
    return float(abs(left - right) / max(size, np.finfo(float).tiny))
