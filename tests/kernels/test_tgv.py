"""Value and dual residual of TGV against the plain operators they are made of."""

import numpy as np

from ipcli.inverse.regularize.operators import (
    gradient,
    gradient_adjoint,
    symmetrised_gradient,
    symmetrised_gradient_adjoint,
)
from ipcli.kernels import tgv as kernels
from tests.fixtures.primal_dual import ALPHA0, each_shape, exist, point, radii


@each_shape
def test_value_rows_are_the_norms_of_the_operators(shape):
    (x, v, _, _), alpha1 = point(shape), radii(shape)
    g, e = (gradient(x) - v) * exist(2, shape), symmetrised_gradient(v)
    slope, curvature = np.sqrt((g**2).sum(axis=0)), np.sqrt(e[0] ** 2 + e[1] ** 2 + 2 * e[2] ** 2)
    expected = (alpha1 * slope + ALPHA0 * curvature).sum(axis=1, dtype=np.float64)
    np.testing.assert_allclose(kernels.value_rows(x, v, alpha1, float(ALPHA0)), expected, rtol=2e-6)


@each_shape
def test_dual_residual_rows_are_those_of_the_adjoint_operators_times_the_bound_of_the_slopes(shape):
    _, _, p, q = point(shape)
    tilt, steepest = np.empty(shape, np.float32), np.random.default_rng(1).random(shape, np.float32)
    rows = kernels.dual_residual_rows(tilt, p, q, steepest)
    np.testing.assert_allclose(tilt, gradient_adjoint(p), atol=2e-6)
    expected = (steepest * np.abs(p - symmetrised_gradient_adjoint(q))).sum(axis=(0, 2))
    np.testing.assert_allclose(rows, expected, rtol=1e-5, atol=1e-6)
