"""The Wishart distribution against SciPy: density, draws, and the multivariate gamma function."""

import numpy as np
import pytest
from scipy import special, stats

from ipcli.inverse.bayes import wishart


def an_inverse_scale(d, rng):
    root = rng.normal(size=(d, d))
    return root @ root.T + np.eye(d)


@pytest.mark.parametrize("d", [1, 2, 5])
def test_the_density_is_that_of_scipy(d):
    rng = np.random.default_rng(d)
    inverse_scale, dof = an_inverse_scale(d, rng), d + 1.5
    s = np.linalg.inv(an_inverse_scale(d, rng))
    expected = stats.wishart(dof, np.linalg.inv(inverse_scale)).logpdf(s)
    assert wishart.log_density(s, dof, inverse_scale) == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("d", [1, 3, 8])
def test_the_gamma_function_is_that_of_scipy_at_one_number_and_at_many(d):
    a = np.array([0.5 * d, 0.5 * d + 3.25, 40.0])
    expected = special.multigammaln(a, d)
    np.testing.assert_allclose(wishart.log_gamma(a, d), expected, rtol=1e-12)
    assert wishart.log_gamma(float(a[1]), d) == pytest.approx(expected[1], rel=1e-12)


def test_draws_have_the_mean_and_the_log_determinant_they_should():
    rng, d, dof = np.random.default_rng(1), 3, 7.5
    inverse_scale = an_inverse_scale(d, rng)
    draws = np.array([wishart.draw(dof, inverse_scale, rng) for _ in range(20000)])
    mean = dof * np.linalg.inv(inverse_scale)
    error = draws.std(axis=0) / np.sqrt(len(draws))
    assert (np.abs(draws.mean(axis=0) - mean) < 5 * error).all()
    log_det = np.linalg.slogdet(draws)[1]
    expected = special.digamma(0.5 * (dof - np.arange(d))).sum() + d * np.log(2) - np.linalg.slogdet(inverse_scale)[1]
    assert abs(log_det.mean() - expected) < 5 * log_det.std() / np.sqrt(len(draws))


def test_roots_of_no_dimensions_are_empty():
    assert wishart.root_from(np.array([2.0]), np.empty((1, 0, 0)), np.random.default_rng(0)).shape == (1, 0, 0)
