"""The fused half steps of TGV against the plain operators and proximal maps they are made of."""

import numpy as np
import pytest

from ipcli.inverse.regularize.operators import (
    gradient,
    gradient_adjoint,
    symmetrised_gradient,
    symmetrised_gradient_adjoint,
)
from ipcli.inverse.regularize.proximal import project_balls
from ipcli.kernels import tgv as kernels

SHAPES = [(1, 1), (1, 7), (6, 1), (2, 2), (5, 8), (13, 17)]
TAU, TAU_V, SIGMA, ALPHA1, ALPHA0, RHO = (np.float32(value) for value in (0.21, 0.17, 0.4, 0.8, 1.3, 1.7))
each_shape = pytest.mark.parametrize("shape", SHAPES, ids=str)


def exist(c, shape):
    """1 where a difference stays inside the image: the components of grad (c = 2) or of E (c = 3)."""
    mask = np.ones((c, *shape), np.float32)
    if c == 2:
        mask[0, :, -1] = mask[1, -1] = 0
    else:
        mask[0, :, 0] = mask[1, 0] = mask[2, 0] = mask[2, :, 0] = 0
    return mask


def point(shape, seed=0):
    """x, v, p, q with the duals zero where there is no difference."""
    rng = np.random.default_rng(seed)
    x, v, p, q = (rng.normal(size=(*c, *shape)).astype(np.float32) for c in ((), (2,), (2,), (3,)))
    return x, v, p * exist(2, shape), q * exist(3, shape)


@each_shape
def test_primal_descent_follows_the_adjoint_operators(shape):
    x, v, p, q = point(shape)
    y, v_bar, v_new = np.empty_like(x), np.empty_like(v), v.copy()
    kernels.primal_descent(y, v_new, v_bar, x, p, q, TAU, TAU_V, RHO)
    step = -TAU_V * (symmetrised_gradient_adjoint(q) - p)
    np.testing.assert_allclose(y, x - TAU * gradient_adjoint(p), atol=2e-6)
    np.testing.assert_allclose(v_bar, v + 2 * step, atol=2e-6)
    np.testing.assert_allclose(v_new, v + RHO * step, atol=2e-6)


@each_shape
def test_dual_ascent_follows_the_operators_and_projects(shape):
    x, v, p, q = point(shape)
    p_new, q_new = p.copy(), q.copy()
    kernels.dual_ascent(p_new, q_new, x, v, SIGMA, ALPHA1, ALPHA0, RHO)
    p_twin = project_balls(p + SIGMA * (gradient(x) - v) * exist(2, shape), ALPHA1, (1, 1))
    q_twin = project_balls(q + SIGMA * symmetrised_gradient(v), ALPHA0, (1, 1, 2))
    np.testing.assert_allclose(p_new, p + RHO * (p_twin - p), atol=2e-6)
    np.testing.assert_allclose(q_new, q + RHO * (q_twin - q), atol=2e-6)


@each_shape
def test_dual_ascent_without_relaxation_ends_feasible_and_never_fills_differences_that_do_not_exist(shape):
    x, v, p, q = point(shape)
    kernels.dual_ascent(p, q, 10 * x, 10 * v, SIGMA, ALPHA1, ALPHA0, np.float32(1))
    assert np.sqrt((p**2).sum(axis=0)).max() <= ALPHA1 * (1 + 1e-6)
    assert np.sqrt(q[0] ** 2 + q[1] ** 2 + 2 * q[2] ** 2).max() <= ALPHA0 * (1 + 1e-6)
    assert not p[exist(2, shape) == 0].any() and not q[exist(3, shape) == 0].any()


@each_shape
def test_value_rows_are_the_norms_of_the_operators(shape):
    x, v, _, _ = point(shape)
    g, e = (gradient(x) - v) * exist(2, shape), symmetrised_gradient(v)
    slope, curvature = np.sqrt((g**2).sum(axis=0)), np.sqrt(e[0] ** 2 + e[1] ** 2 + 2 * e[2] ** 2)
    expected = (ALPHA1 * slope + ALPHA0 * curvature).sum(axis=1, dtype=np.float64)
    np.testing.assert_allclose(kernels.value_rows(x, v, float(ALPHA1), float(ALPHA0)), expected, rtol=2e-6)


@each_shape
def test_dual_residual_rows_are_those_of_the_adjoint_operators_times_the_bound_of_the_slopes(shape):
    _, _, p, q = point(shape)
    tilt, steepest = np.empty(shape, np.float32), np.random.default_rng(1).random(shape, np.float32)
    rows = kernels.dual_residual_rows(tilt, p, q, steepest)
    np.testing.assert_allclose(tilt, gradient_adjoint(p), atol=2e-6)
    expected = (steepest * np.abs(p - symmetrised_gradient_adjoint(q))).sum(axis=(0, 2))
    np.testing.assert_allclose(rows, expected, rtol=1e-5, atol=1e-6)
