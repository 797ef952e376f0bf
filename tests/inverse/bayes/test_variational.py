"""The variational mixture: bounded by the evidence that enumeration gives, rising, and right about clear clusters."""

import numpy as np
import pytest
from scipy.special import gammaln

from ipcli.inverse.bayes.variational import StickPrior, fit, updated

PRIOR = StickPrior(alpha=0.7, beta=0.3, shape=2.0, width=0.5)


def cluster_evidence(x: np.ndarray, prior: StickPrior) -> float:
    """log p of points (n, d) in one cluster, from the predictive density of Normal-Gamma dimensions in closed form."""
    n, b0 = len(x), prior.shape * prior.width
    beta, shape = prior.beta + n, prior.shape + n / 2
    rate = b0 + 0.5 * ((x**2).sum(axis=0) - x.sum(axis=0) ** 2 / beta)
    each = 0.5 * np.log(prior.beta / beta) + gammaln(shape) - gammaln(prior.shape) - n / 2 * np.log(2 * np.pi)
    return float((each + prior.shape * np.log(b0) - shape * np.log(rate)).sum())


def partitions(n: int):
    """All partitions of n points, as labels."""

    def grow(labels):
        if len(labels) == n:
            yield labels
            return
        for k in range(max(labels, default=-1) + 2):
            yield from grow([*labels, k])

    yield from grow([])


def evidence(x: np.ndarray, prior: StickPrior) -> float:
    """log p(x) of the Dirichlet process mixture, by all partitions."""
    terms = []
    for labels in partitions(len(x)):
        sizes = np.bincount(labels)
        crp = len(sizes) * np.log(prior.alpha) + gammaln(sizes).sum()
        crp += gammaln(prior.alpha) - gammaln(prior.alpha + len(x))
        terms.append(crp + sum(cluster_evidence(x[np.array(labels) == k], prior) for k in range(len(sizes))))
    return float(np.logaddexp.reduce(terms))


def test_the_bound_lies_below_the_evidence_of_enumeration_and_near_it():
    x = np.array([[-2.0, 1.0], [-2.1, 0.9], [-1.9, 1.2], [2.0, -1.0], [2.2, -1.1], [1.8, -0.8]])
    true = evidence(x, PRIOR)
    bounds = [fit(x, most, PRIOR, np.random.default_rng(0)).bound for most in (1, 2, 4)]
    assert all(bound < true for bound in bounds)
    assert max(bounds) > true - 1.5
    assert bounds[1] > bounds[0] + 1  # two clusters explain these points better than one


def test_with_one_cluster_the_bound_is_its_evidence():
    x = np.random.default_rng(1).normal(size=(9, 3))
    stick = (
        np.log(1 / PRIOR.alpha)
        + gammaln(10)
        + gammaln(PRIOR.alpha)
        - gammaln(10 + PRIOR.alpha)
        + np.log(PRIOR.alpha) * 2
    )
    assert updated(x, np.ones((9, 1)), PRIOR).bound == pytest.approx(cluster_evidence(x, PRIOR) + stick, rel=1e-9)


def test_clear_clusters_in_many_dimensions_are_found_and_no_more():
    rng = np.random.default_rng(2)
    centres = rng.normal(size=(4, 32))
    labels = rng.integers(0, 4, 300)
    x = centres[labels] + 0.2 * rng.normal(size=(300, 32))
    found = fit(x, 12, StickPrior(), rng)
    assert len(found.counts) == 4
    told = found.assigned(x).argmax(axis=1)
    assert all(len(np.unique(told[labels == k])) == 1 for k in range(4))


def test_merges_put_one_cluster_together_that_the_start_has_split():
    x = np.random.default_rng(4).normal(size=(300, 2))
    split = fit(x, 6, StickPrior(width=1.0), np.random.default_rng(0), iterations=20, merges=False)
    joined = fit(x, 6, StickPrior(width=1.0), np.random.default_rng(0), iterations=20)
    assert len(joined.counts) == 1 < len(split.counts)
    assert joined.bound > split.bound
