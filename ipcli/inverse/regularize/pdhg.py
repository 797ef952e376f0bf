"""The primal-dual hybrid gradient method (Chambolle and Pock, JMIV 2011) for min_x f(K x) + g(x), on any arrays.

Plain and slow: for models without kernels, and to check the fast solver of `tgv` against.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np


def pdhg(
    forward: Callable[[np.ndarray], np.ndarray],
    adjoint: Callable[[np.ndarray], np.ndarray],
    prox_g: Callable[[np.ndarray, float], np.ndarray],
    prox_conjugate: Callable[[np.ndarray, float], np.ndarray],
    x: np.ndarray,
    y: np.ndarray,
    *,
    tau: float,
    sigma: float,
    iterations: int,
    relaxation: float = 1.0,
) -> tuple[np.ndarray, np.ndarray]:
    """Primal and dual point after some iterations of (4.22)-(4.25), over-relaxed.

    prox_g(x, tau) and prox_conjugate(y, sigma) are the proximal maps of g and of the conjugate of f. Converges for
    tau sigma |K|^2 <= 1 and relaxation in (0, 2); whoever scales steps must keep to that.
    """
    for _ in range(iterations):
        x_new = prox_g(x - tau * adjoint(y), tau)
        y_new = prox_conjugate(y + sigma * forward(2 * x_new - x), sigma)
        x = x + relaxation * (x_new - x)
        y = y + relaxation * (y_new - y)
    return x, y
