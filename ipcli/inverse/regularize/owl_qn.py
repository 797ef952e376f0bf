"""Minimise a smooth function plus weighed absolute values, with exact zeros: OWL-QN (Andrew and Gao, ICML 2007)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

SUFFICIENT = 1e-4  # share of the decrease that the pseudo-gradient promises
HALVINGS = 25

Smooth = Callable[[np.ndarray], tuple[float, np.ndarray]]


def pseudo_gradient(x: np.ndarray, gradient: np.ndarray, l1: np.ndarray) -> np.ndarray:
    """The steepest one-sided slope (n,) of f + sum l1 |x|: zero where no direction goes down."""
    signed = gradient + l1 * np.sign(x)
    down, up = gradient + l1, gradient - l1
    return np.where(x != 0, signed, np.where(down < 0, down, np.where(up > 0, up, 0.0)))


def minimise(f: Smooth, x: np.ndarray, l1: np.ndarray, iterations: int, memory: int = 8) -> np.ndarray:
    """The point (n,) after some iterations from `x` (n,); `f` gives value and gradient (n,), `l1` (n,) the weights."""
    value, gradient = f(x)
    value += float((l1 * np.abs(x)).sum())
    steps: list[tuple[np.ndarray, np.ndarray]] = []
    for _ in range(iterations):
        slope = pseudo_gradient(x, gradient, l1)
        direction = -_times_inverse_hessian(slope, steps)
        direction = np.where(direction * slope < 0, direction, 0.0)
        orthant = np.where(x != 0, np.sign(x), -np.sign(slope))
        length = 1.0 if steps else 1.0 / max(float(np.linalg.norm(slope)), 1e-12)
        for _ in range(HALVINGS):
            trial = x + length * direction
            trial = np.where((trial * orthant > 0) | (l1 == 0), trial, 0.0)
            new, new_gradient = f(trial)
            new += float((l1 * np.abs(trial)).sum())
            if new <= value + SUFFICIENT * float(slope @ (trial - x)):
                break
            length /= 2
        else:
            return x
        s, y = trial - x, new_gradient - gradient  # of the true gradients, as the curvature is the smooth part's
        if s @ y > 1e-12 * np.sqrt((s @ s) * (y @ y)):
            steps = [*steps[-(memory - 1) :], (s, y)]
        x, gradient, value = trial, new_gradient, new
        if not s.any():
            return x
    return x


def _times_inverse_hessian(vector: np.ndarray, steps: list[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """The two-loop recursion of L-BFGS."""
    q, shares = vector.copy(), []
    for s, y in reversed(steps):
        a = (s @ q) / (s @ y)
        shares.append(a)
        q -= a * y
    if steps:
        s, y = steps[-1]
        q *= (s @ y) / (y @ y)
    for (s, y), a in zip(steps, reversed(shares), strict=True):
        q += s * (a - (y @ q) / (s @ y))
    return q
