"""Priors of the hyperparameters against SciPy, their conditionals against the joint density, the slice sampler against
known ones.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from ipcli.inverse.bayes import hyperparameters, slice
from ipcli.inverse.bayes.hyperparameters import ClusterDraws, Hyperparameters, Prior
from ipcli.inverse.bayes.parameters import LEARNED, Hyperprior

D = 3
INFORMATIVE = Hyperprior(
    xi_spread=2,
    rho_shape=4,
    rho_rate=3,
    beta_shape=5,
    beta_mean=0.2,
    alpha_shape=4,
    alpha_rate=2,
    w_dof=10,
    w_scale=0.7,
)


@pytest.mark.parametrize("settings", [Hyperprior(), INFORMATIVE], ids=["Rasmussen", "informative"])
def test_the_prior_density_is_that_of_scipy(settings):
    at = Prior(INFORMATIVE, D).draw(np.random.default_rng(0))
    dof, scale = max(settings.w_dof, D), settings.w_scale
    rate = settings.beta_shape / (settings.beta_mean or 1 / D)
    expected = (
        stats.multivariate_normal(np.zeros(D), settings.xi_spread * np.eye(D)).logpdf(at.xi)
        + stats.gamma(settings.rho_shape, scale=1 / settings.rho_rate).logpdf(at.rho)
        + stats.wishart(dof, scale / dof * np.eye(D)).logpdf(at.w)
        + stats.invgamma(settings.beta_shape, scale=rate).logpdf(at.beta - D + 1)
        + stats.invgamma(settings.alpha_shape, scale=settings.alpha_rate).logpdf(at.alpha)
    )
    assert Prior(settings, D).log_density(at) == pytest.approx(expected, rel=1e-11)


def test_draws_from_the_prior_follow_it():
    rng, prior = np.random.default_rng(1), Prior(INFORMATIVE, D)
    draws = [prior.draw(rng) for _ in range(4000)]
    assert stats.kstest([h.rho for h in draws], stats.gamma(4, scale=1 / 3).cdf).pvalue > 1e-3
    assert stats.kstest([h.alpha for h in draws], stats.invgamma(4, scale=2).cdf).pvalue > 1e-3
    assert stats.kstest([h.beta - D + 1 for h in draws], stats.invgamma(5, scale=25).cdf).pvalue > 1e-3
    np.testing.assert_allclose(np.mean([h.w for h in draws], axis=0), 0.7 * np.eye(D), atol=0.03)


def log_of_clusters(at, mean, s):
    """log p(mu, S | hyperparameters) of all clusters."""
    scale = np.linalg.inv(at.beta * at.w)
    return sum(
        stats.wishart(at.beta, scale).logpdf(one)
        + stats.multivariate_normal(at.xi, np.linalg.inv(at.rho * one)).logpdf(m)
        for m, one in zip(mean, s, strict=True)
    )


def test_the_slice_sampler_is_given_the_conditionals_of_beta_and_alpha_up_to_a_constant(monkeypatch):
    rng, prior, k, n = np.random.default_rng(2), Prior(INFORMATIVE, D), 4, 30
    at = prior.draw(rng)
    base = at.base()
    root = np.array([base.sample(rng)[1][0] for _ in range(k)])
    mean, s = rng.normal(size=(k, D)), root @ root.swapaxes(1, 2)
    clusters = ClusterDraws(
        k, s.sum(axis=0), np.einsum("kij,kj->i", s, mean), root, mean, float(np.linalg.slogdet(s)[1].sum())
    )
    given = {}
    monkeypatch.setattr(
        hyperparameters, "slice_draw", lambda density, t, rng: given.setdefault(len(given), density) and t or t
    )
    prior._beta(at, clusters, rng)
    prior._alpha(at.alpha, k, n, rng)
    ts = np.array([-1.0, 0.3, 1.5, 3.0])
    beta = [
        log_of_clusters(replace(at, beta=D - 1 + math.exp(t)), mean, s)
        + prior.log_density(replace(at, beta=D - 1 + math.exp(t)))
        + t
        for t in ts
    ]
    alpha = [
        k * t
        + math.lgamma(math.exp(t))
        - math.lgamma(n + math.exp(t))
        + prior.log_density(replace(at, alpha=math.exp(t)))
        + t
        for t in ts
    ]
    for density, expected in ((given[0], beta), (given[1], alpha)):
        found = np.array([density(t) for t in ts])
        np.testing.assert_allclose(found - found[0], np.array(expected) - expected[0], rtol=1e-9, atol=1e-9)


LAWS = {
    "narrow": (lambda t: -50 * (t - 2) ** 2, stats.norm(2, 0.1)),
    "skew": (lambda t: 0.5 * t - math.exp(t), stats.loggamma(0.5)),
    "wide": (lambda t: 0.0 if abs(t) < 30 else -math.inf, stats.uniform(-30, 60)),
}


@pytest.mark.parametrize("name", LAWS)
def test_slice_steps_forget_the_start_and_leave_a_density_as_it_is(name):
    log_density, law = LAWS[name]
    rng, found = np.random.default_rng(3), []
    for _ in range(1500):
        t = float(law.median()) + 0.05
        for _ in range(20):
            t = slice.draw(log_density, t, rng)
        found.append(t)
    after = [slice.draw(log_density, float(t), rng) for t in law.rvs(1500, random_state=4)]
    assert stats.kstest(found, law.cdf).pvalue > 1e-3
    assert stats.kstest(after, law.cdf).pvalue > 1e-3


def test_all_in_one_array_and_back():
    at = Prior(INFORMATIVE, D).draw(np.random.default_rng(5))
    back = Hyperparameters.of_flat(at.flat(), D)
    for name in LEARNED:
        np.testing.assert_array_equal(getattr(at, name), getattr(back, name))
