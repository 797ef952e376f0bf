"""The Normal-Wishart distribution, its t predictive and the Wishart's draws against closed forms and SciPy."""

import numpy as np
import pytest
from scipy import stats

from ipcli.inverse.bayes import wishart
from ipcli.inverse.bayes.normal_wishart import NormalWishart, SetStatistics
from ipcli.inverse.bayes.student import Students


def a_prior(d, rng):
    root = rng.normal(size=(d, d))
    return NormalWishart.one(rng.normal(size=d), 0.7, d + 0.4, root @ root.T + np.eye(d))


def one_set(x):
    return SetStatistics.of(x, np.zeros(len(x), int), 1)


@pytest.fixture
def rng():
    return np.random.default_rng(5)


@pytest.mark.parametrize("d", [1, 2, 7, 20])
def test_the_marginal_likelihood_is_the_product_of_the_predictives_one_after_the_other(rng, d):
    x, at, total = rng.normal(size=(9, d)), a_prior(d, rng), 0.0
    prior = at
    for point in x:
        total += at.predictive().log_density(point[None])[0, 0]
        at = at.posterior(one_set(point[None]))
    assert prior.log_marginal(one_set(x))[0] == pytest.approx(total, rel=1e-12)


@pytest.mark.parametrize("d", [1, 3, 20])
def test_one_point_after_the_other_gives_the_posterior_of_all_together(rng, d):
    x, prior = rng.normal(size=(9, d)), a_prior(d, rng)
    at = prior
    for point in x:
        at = at.posterior(one_set(point[None]))
    together = prior.posterior(one_set(x))
    for name in ("mean", "rho", "beta", "psi"):
        np.testing.assert_allclose(getattr(at, name), getattr(together, name), rtol=1e-12, atol=1e-12)


def test_an_empty_set_leaves_the_prior_and_has_density_one(rng):
    prior = a_prior(3, rng)
    empty = SetStatistics.of(np.empty((0, 3)), np.empty(0, int), 1)
    assert prior.log_marginal(empty)[0] == 0
    np.testing.assert_array_equal(prior.posterior(empty).psi, prior.psi)


def test_the_t_density_is_that_of_scipy(rng):
    d, x = 4, rng.normal(size=(50, 4)) * 3
    chol = np.linalg.cholesky(a_prior(d, rng).psi)
    students = Students(np.array([3.7, 200.0]), rng.normal(size=(2, d)), np.repeat(chol, 2, axis=0))
    for m, dof in enumerate(students.dof):
        theirs = stats.multivariate_t(students.location[m], chol[0] @ chol[0].T, dof).logpdf(x)
        np.testing.assert_allclose(students.log_density(x)[:, m], theirs, rtol=1e-12)


def test_the_predictive_is_the_gaussian_averaged_over_draws_of_mean_and_precision(rng):
    base, at = a_prior(2, rng), np.array([[0.3, -0.2], [1.5, 2.0], [-2.0, 0.0]])
    many = NormalWishart(*(np.repeat(getattr(base, name), 200_000, axis=0) for name in ("mean", "rho", "beta", "psi")))
    mean, root = many.sample(rng)
    log_det = np.log(np.abs(np.linalg.det(root)))
    for x, expected in zip(at, np.exp(base.predictive().log_density(at)[:, 0]), strict=True):
        squared = np.sum(np.einsum("kji,kj->ki", root, x - mean) ** 2, axis=1)
        density = np.exp(log_det - 0.5 * squared) / (2 * np.pi)
        assert abs(density.mean() - expected) < 4 * density.std() / np.sqrt(len(density))


def test_wishart_draws_have_the_moments_and_the_determinant_of_the_distribution(rng):
    d, dof, n = 3, 4.6, 100_000
    scale = np.linalg.inv(a_prior(d, rng).psi[0])
    chol = np.linalg.cholesky(np.linalg.inv(scale))
    root = wishart.root_from(np.full(n, dof), np.repeat(chol[None], n, axis=0), rng)
    draws = root @ root.swapaxes(1, 2)
    error = draws.mean(axis=0) - dof * scale
    variance = dof * (scale**2 + np.outer(np.diag(scale), np.diag(scale)))
    assert (np.abs(error) < 4.5 * np.sqrt(variance / n)).all()
    np.testing.assert_allclose(draws.var(axis=0), variance, rtol=0.1)
    log_det = np.linalg.slogdet(draws)[1] - np.linalg.slogdet(scale)[1]
    chi = sum(np.log(stats.chi2(dof - i).rvs(n, random_state=i)) for i in range(d))
    assert stats.ks_2samp(log_det, chi).pvalue > 1e-3


def test_wishart_density_and_multivariate_gamma_are_those_of_scipy(rng):
    from scipy.special import multigammaln

    psi, s = a_prior(4, rng).psi[0], a_prior(4, rng).psi[0]
    assert wishart.log_density(s, 6.3, psi) == pytest.approx(
        stats.wishart(6.3, np.linalg.inv(psi)).logpdf(s), rel=1e-12
    )
    assert wishart.log_gamma(6.3, 4) == pytest.approx(multigammaln(6.3, 4), rel=1e-13)
