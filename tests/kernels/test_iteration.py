"""The iteration of TGV: its half steps against the operators and proximal maps they are made of, whole sweeps against
half steps.
"""

import numpy as np
import pytest

from ipcli.inverse.regularize.operators import (
    gradient,
    gradient_adjoint,
    symmetrised_gradient,
    symmetrised_gradient_adjoint,
)
from ipcli.inverse.regularize.proximal import project_balls
from ipcli.kernels import iteration as kernels
from tests.fixtures.primal_dual import ALPHA0, RHO, SIGMA, TAU, TAU_V, each_shape, exist, point, radii


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
    p_new, q_new, alpha1 = p.copy(), q.copy(), radii(shape)
    kernels.dual_ascent(p_new, q_new, x, v, SIGMA, alpha1, ALPHA0, RHO)
    p_twin = project_balls(p + SIGMA * (gradient(x) - v) * exist(2, shape), alpha1, (1, 1))
    q_twin = project_balls(q + SIGMA * symmetrised_gradient(v), ALPHA0, (1, 1, 2))
    np.testing.assert_allclose(p_new, p + RHO * (p_twin - p), atol=2e-6)
    np.testing.assert_allclose(q_new, q + RHO * (q_twin - q), atol=2e-6)


@each_shape
def test_dual_ascent_without_relaxation_ends_feasible_and_never_fills_differences_that_do_not_exist(shape):
    x, v, p, q = point(shape)
    alpha1 = radii(shape)
    kernels.dual_ascent(p, q, 10 * x, 10 * v, SIGMA, alpha1, ALPHA0, np.float32(1))
    assert (np.sqrt((p**2).sum(axis=0)) <= alpha1 * (1 + 1e-6)).all()
    assert np.sqrt(q[0] ** 2 + q[1] ** 2 + 2 * q[2] ** 2).max() <= ALPHA0 * (1 + 1e-6)
    assert not p[exist(2, shape) == 0].any()
    assert not q[exist(3, shape) == 0].any()


@pytest.mark.parametrize("weighted", [False, True])
@pytest.mark.parametrize("iterations", [1, 2, 5, 9])
@pytest.mark.parametrize("shape", [(1, 7), (6, 1), (2, 2), (3, 8), (29, 17)], ids=str)
def test_a_sweep_is_as_many_iterations_of_the_half_steps_bit_by_bit(shape, iterations, weighted):
    rng = np.random.default_rng(3)
    h, w = shape
    stack = np.sort(np.where(rng.random((h, 5, w)) < 0.2, np.inf, rng.normal(size=(h, 5, w))), axis=1).astype(
        np.float32
    )
    weights = np.where(np.isfinite(stack), rng.random(stack.shape), 0).astype(np.float32) if weighted else None
    total = weights.sum(axis=1) if weighted else np.isfinite(stack).sum(axis=1, dtype=np.float32)
    alpha1, scale, rhos = (
        radii(shape),
        rng.random(shape, np.float32),
        rng.uniform(1, 1.9, iterations).astype(np.float32),
    )
    swept, (x, v, p, q) = point(shape, seed=4), point(shape, seed=4)
    kernels.sweep_l1(*swept, stack, weights, total, scale, (TAU, TAU_V, SIGMA), alpha1, ALPHA0, rhos)
    y, x_bar, v_bar = np.empty_like(x), np.empty_like(x), np.empty_like(v)
    for rho in rhos:
        kernels.primal_descent(y, v, v_bar, x, p, q, TAU, TAU_V, rho)
        kernels.prox_l1(x, x_bar, y, stack, weights, total, scale, TAU, rho)
        kernels.dual_ascent(p, q, x_bar, v_bar, SIGMA, alpha1, ALPHA0, rho)
    for one, other in zip(swept, (x, v, p, q), strict=True):
        np.testing.assert_array_equal(one, other)
