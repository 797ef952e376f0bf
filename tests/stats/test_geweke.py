"""Getting it right (Geweke 2004): two ways to draw from the joint of hyperparameters, partition and data must agree.

One draws all from the prior; the other alternates between a step of the sampler and new data given where it stands.
"""

from dataclasses import replace

import numpy as np
import pytest

from ipcli.inverse.bayes.chain import Chain
from ipcli.inverse.bayes.hyperparameters import Prior
from ipcli.inverse.bayes.normal_wishart import NormalWishart, SetStatistics
from ipcli.inverse.bayes.parameters import Hyperprior, Mixture

N, D = 6, 2
# Rasmussen's own priors have no moments to compare; these do.
INFORMATIVE = Hyperprior(
    rho_shape=4, rho_rate=4, beta_shape=5, beta_mean=0.2, alpha_shape=4, alpha_rate=4, w_dof=10, w_scale=0.7
)
SETTINGS = Mixture(sweeps=10**9, prior=INFORMATIVE, moves=2, scans=2)
NAMES = (
    "clusters",
    "log alpha",
    "log rho",
    "log beta excess",
    "tr W",
    "xi",
    "xi^2",
    "x",
    "log(1 + |x|^2)",
    "same cluster",
    "x x'",
)


def data(labels, hyper, rng):
    """SetStatistics (n, d) given their labels and the hyperparameters."""
    k = labels.max() + 1
    base = hyper.base()
    base = NormalWishart(*(np.repeat(getattr(base, name), k, axis=0) for name in ("mean", "rho", "beta", "psi")))
    mean, root = base.sample(rng)
    noise = np.linalg.solve(root[labels].swapaxes(1, 2), rng.normal(size=(len(labels), D, 1)))[:, :, 0]
    return mean[labels] + noise


def restaurant(n, alpha, rng):
    labels = np.zeros(n, np.int32)
    for i in range(1, n):
        counts = np.bincount(labels[:i])
        labels[i] = rng.choice(len(counts) + 1, p=np.append(counts, alpha) / (i + alpha))
    return labels


def features(x, labels, h):
    squared = np.log1p(np.sum(x**2, axis=1)).mean()
    logs = np.log([h.alpha, h.rho, h.beta - D + 1])
    return (
        labels.max() + 1,
        *logs,
        np.trace(h.w),
        h.xi[0],
        h.xi[1] ** 2,
        np.arctan(x[0, 0]),
        squared,
        labels[0] == labels[1],
        np.arctan(x[0] @ x[1]),
    )


def from_the_prior(count, rng):
    found = []
    for _ in range(count):
        hyper = Prior(INFORMATIVE, D).draw(rng)
        labels = restaurant(N, hyper.alpha, rng)
        found.append(features(data(labels, hyper, rng), labels, hyper))
    return np.array(found, float)


def from_the_sampler(kind, count, rng):
    hyper = Prior(INFORMATIVE, D).draw(rng)
    labels = restaurant(N, hyper.alpha, rng)
    chain = kind(data(labels, hyper, rng), SETTINGS, rng)
    chain.labels, chain.hyper, found = labels, hyper, []
    for _ in range(count):
        chain.move()
        chain.learn()
        chain.x = data(chain.labels, chain.hyper, rng)
        found.append(features(chain.x, chain.labels, chain.hyper))
    return np.array(found, float)


def z_scores(independent, dependent, batches=40):
    """Of the differences of the means; the error of the dependent ones from the means of batches."""
    means = dependent[: len(dependent) // batches * batches].reshape(batches, -1, dependent.shape[1]).mean(axis=1)
    variance = independent.var(axis=0, ddof=1) / len(independent) + means.var(axis=0, ddof=1) / batches
    return (independent.mean(axis=0) - dependent.mean(axis=0)) / np.sqrt(variance)


class WithClustersAtTheCentre(Chain):
    """Takes every cluster to be centred at xi when it draws the hyperparameters."""

    def learn(self):
        points = SetStatistics.of(self.x, self.labels, self.clusters)
        centred = replace(points, mean=np.tile(self.hyper.xi, (self.clusters, 1)))
        self.hyper = self.prior.update(self.hyper, centred, self.rng)


class WithTheScaleAsPrinted(Chain):
    """Takes W where the inverse scale is beta W."""

    def base(self):
        xi, rho, beta, _, alpha = super().base()
        return xi, rho, beta, np.linalg.cholesky(self.hyper.w), alpha


class WithOneClusterTooMany(Chain):
    """Counts a cluster too many when it draws alpha."""

    def learn(self):
        super().learn()
        alpha = self.prior._alpha(self.hyper.alpha, self.clusters + 1, len(self.x), self.rng)
        self.hyper = replace(self.hyper, alpha=alpha)


@pytest.fixture(scope="module")
def independent():
    return from_the_prior(20_000, np.random.default_rng(1))


@pytest.mark.parametrize("count", [8_000, pytest.param(150_000, marks=pytest.mark.slow)])
def test_sampler_and_prior_agree(independent, count):
    z = z_scores(independent, from_the_sampler(Chain, count, np.random.default_rng(2)))
    assert np.abs(z).max() < 4, dict(zip(NAMES, z.round(1), strict=True))


@pytest.mark.parametrize("kind", [WithClustersAtTheCentre, WithTheScaleAsPrinted, WithOneClusterTooMany])
def test_a_planted_mistake_is_seen(independent, kind):
    z = z_scores(independent, from_the_sampler(kind, 4_000, np.random.default_rng(3)))
    assert np.abs(z).max() > 6, dict(zip(NAMES, z.round(1), strict=True))
