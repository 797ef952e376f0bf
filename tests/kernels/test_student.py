"""The density of a mixture of t densities against SciPy, and the vector log and exp against NumPy's."""

import numpy as np
import pytest
from scipy.special import logsumexp

from ipcli.inverse.bayes.predictive import Predictive
from ipcli.kernels import student as kernels


def a_predictive(m, d, rng):
    chol = np.tril(rng.normal(size=(m, d, d)), -1) + np.eye(d) * rng.uniform(0.1, 2, size=(m, d, 1))
    weight = np.log(rng.dirichlet(np.ones(m)))
    return Predictive(weight, rng.uniform(1, 60, size=m), rng.normal(size=(m, d)) * 3, chol, np.zeros(m, np.int32))


@pytest.mark.parametrize(("n", "m", "d"), [(1, 1, 1), (127, 3, 2), (300, 25, 7), (128, 5, 30), (0, 2, 2)])
def test_the_kernel_gives_the_density_that_scipy_gives(n, m, d):
    rng = np.random.default_rng(0)
    predictive, x = a_predictive(m, d, rng), rng.normal(size=(n, d)) * rng.choice([1.0, 50.0], size=(n, 1))
    plain = logsumexp(predictive.log_weight + predictive.students.log_density(x), axis=1)
    np.testing.assert_allclose(predictive.log_density(x), plain, rtol=1e-11, atol=1e-11)


def test_far_away_it_is_finite_and_where_a_point_is_not_finite_it_is_nan():
    predictive = a_predictive(3, 2, np.random.default_rng(1))
    found = predictive.log_density(np.array([[1e120, -1e120], [np.nan, 0.0], [0.0, np.inf], [0.0, 0.0]]))
    assert np.isfinite(found[[0, 3]]).all()
    assert np.isnan(found[[1, 2]]).all()


def test_exp_and_log_are_exact_to_two_units_in_the_last_place():
    rng, scratch = np.random.default_rng(2), np.empty(kernels.LANES)
    for scale in (1e-12, 1e-3, 1.0, 30.0, 200.0):
        x = -scale * rng.random(kernels.LANES)
        y = x.copy()
        kernels._exp(y, scratch)
        np.testing.assert_allclose(y, np.exp(x), rtol=2 * np.finfo(float).eps)
        z = np.exp(scale * rng.random(kernels.LANES))
        logged = z.copy()
        kernels._log(logged, scratch)
        np.testing.assert_allclose(logged, np.log(z), rtol=2 * np.finfo(float).eps, atol=1e-300)
    x = np.full(kernels.LANES, -np.inf)
    kernels._exp(x, scratch)
    assert (x < 1e-300).all()
