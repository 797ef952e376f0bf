"""The sampler's kernels against plain NumPy: points put in and taken out, predictives, one sweep with the same random
numbers.
"""

import numpy as np
import pytest

from ipcli.inverse.bayes.normal_wishart import NormalWishart, SetStatistics
from ipcli.kernels import dirichlet as kernels
from ipcli.kernels import points as point_kernels


def setting(n, d, seed):
    """SetStatistics, and a base measure as the kernels and as NumPy take it: (x, xi, rho, beta, chol, alpha),
    `NormalWishart`.
    """
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(d, d))
    psi = root @ root.T + 0.5 * np.eye(d)
    xi, rho, beta, alpha = rng.normal(size=d), 0.3, d + 0.7, 0.8
    return (rng.normal(size=(n, d)) * 2, xi, rho, beta, np.linalg.cholesky(psi), alpha), NormalWishart.one(
        xi, rho, beta, psi
    )


def psi_of(clusters, k):
    return clusters.lower[:, :, k] @ np.diag(1 / clusters.inverse[:, k]) @ clusters.lower[:, :, k].T


@pytest.mark.parametrize("d", [1, 2, 7, 40])
def test_points_put_in_and_taken_out_again_leave_a_cluster_as_it_was_and_as_computed_afresh(d):
    (x, *given), prior = setting(60, d, seed=d)
    base, scratch = kernels._base(*given, len(x)), np.empty(d)
    clusters = kernels._allocate(d, 2)
    kernels._open(clusters, 1, base)
    for point in x[:20]:
        kernels._add(clusters, 1, point, base, scratch)
    before = (
        clusters.lower[:, :, 1].copy(),
        clusters.inverse[:, 1].copy(),
        clusters.mean[:, 1].copy(),
        clusters.logdet[1],
    )
    for point in x[20:]:
        kernels._add(clusters, 1, point, base, scratch)
    for point in x[20:]:
        assert kernels._take(clusters, 1, point, base, scratch)
    for was, now in zip(
        before, (clusters.lower[:, :, 1], clusters.inverse[:, 1], clusters.mean[:, 1], clusters.logdet[1]), strict=True
    ):
        np.testing.assert_allclose(now, was, rtol=1e-10, atol=1e-10)
    post = prior.posterior(SetStatistics.of(x[:20], np.zeros(20, int), 1))
    np.testing.assert_allclose(psi_of(clusters, 1), post.psi[0], rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose(clusters.mean[:, 1], post.mean[0], rtol=1e-10, atol=1e-10)
    assert clusters.logdet[1] == pytest.approx(np.linalg.slogdet(post.psi[0])[1], abs=1e-10)


def scores(x, labels, i, prior, alpha, k):
    """log weight times predictive of point i at a new cluster, then at each of the k of the others; -inf at those that
    are empty.
    """
    others = np.delete(np.arange(len(x)), i)
    points = SetStatistics.of(x[others], labels[others], k)
    known = prior.posterior(points).predictive().log_density(x[i : i + 1])[0]
    with np.errstate(divide="ignore"):
        return np.append(np.log(alpha) + prior.predictive().log_density(x[i : i + 1])[0], np.log(points.count) + known)


@pytest.mark.parametrize("d", [0, 1, 3, 12])
def test_a_point_asks_about_the_others_of_its_cluster_without_being_taken_out(d):
    (x, *given), prior = setting(14, d, seed=1)
    labels = np.array([0, 0, 0, 1, 1, 2, 0, 1, 3, 3, 3, 3, 3, 0], np.int32)
    base = kernels._base(*given, len(x))
    clusters = kernels._gather(x, labels, base, 4)
    for i in range(len(x)):
        kernels._ask(clusters, 5, x[i], labels[i] + 1, base)
        np.testing.assert_allclose(clusters.score[:5], scores(x, labels, i, prior, given[-1], 4), rtol=1e-9, atol=1e-9)
        assert (clusters.score[5:8] == -np.inf).all()


def plain_sweep(x, labels, prior, alpha, rng):
    """A sweep by NumPy. Labels are not renumbered until its end; the label given up last is the first to be
    used again.
    """
    free, slots = [], labels.max() + 1
    for i in range(len(x)):
        found = scores(x, labels, i, prior, alpha, slots)
        total = np.cumsum(np.exp(found - found.max()))
        choice = int(np.searchsorted(total, rng.random() * total[-1], side="right"))
        was_alone = np.sum(labels == labels[i]) == 1
        if choice == 0 and was_alone:
            continue
        if was_alone:
            free.append(labels[i])
        if choice == 0 and not free:
            slots += 1
        labels[i] = choice - 1 if choice else (free.pop() if free else slots - 1)
    labels[:] = np.unique(labels, return_inverse=True)[1]


@pytest.mark.parametrize(("n", "d", "alpha"), [(40, 2, 0.8), (40, 7, 6.0), (30, 1, 25.0)])
def test_a_sweep_is_the_one_numpy_makes_with_the_same_random_numbers(n, d, alpha):
    (x, *given, _), prior = setting(n, d, seed=4)
    ours, theirs = (np.random.default_rng(9).integers(5, size=n).astype(np.int32) for _ in range(2))
    rng, same = np.random.default_rng(2), np.random.default_rng(2)
    for _ in range(4):
        k, _ = kernels.sweep(x, ours, int(ours.max()) + 1, *given, alpha, rng)
        plain_sweep(x, theirs, prior, alpha, same)
        np.testing.assert_array_equal(ours, theirs)
        assert k == ours.max() + 1
    assert k > 5 or alpha < 20  # the many clusters of a large alpha need more room than there was at first


@pytest.mark.parametrize("d", [1, 4])
def test_the_gain_of_a_split_is_that_of_the_marginal_likelihoods_and_of_the_restaurant(d):
    from ipcli.inverse.bayes.chain import log_partition

    (x, *given), prior = setting(9, d, seed=6)
    base, side = kernels._base(*given, len(x)), np.array([1, 2, 2, 1, 1, 2, 2])
    gain = kernels._log_gain(x, 0, 1, np.arange(2, 9), side, base, np.log(given[-1]))
    labels = np.array([0, 1, *(side - 1)])
    apart, together = SetStatistics.of(x, labels, 2), SetStatistics.of(x, 0 * labels, 1)
    expected = log_partition(apart.count, given[-1]) - log_partition(together.count, given[-1])
    expected += prior.log_marginal(apart).sum() - prior.log_marginal(together).sum()
    assert gain == pytest.approx(expected, rel=1e-10)


def test_the_labels_of_split_merge_have_no_gaps():
    (x, *given), _ = setting(50, 2, seed=7)
    labels, rng, k = np.zeros(50, np.int32), np.random.default_rng(1), 1
    for _ in range(200):
        before = k
        k, splits, merges = kernels.split_merge(x, labels, k, *given[:-1], 20.0, 3, 1, rng)
        assert k == before + splits - merges == len(np.unique(labels)) == labels.max() + 1


@pytest.mark.parametrize("d", [0, 1, 5])
def test_statistics_are_those_of_numpy(d):
    rng = np.random.default_rng(3)
    x, labels = rng.normal(size=(40, d)), np.array([0, 2, 4, 2] * 10, np.int32)
    count, mean, scatter = point_kernels.statistics(x, labels, 5)
    np.testing.assert_array_equal(count, [10, 0, 20, 0, 10])
    for k in (0, 2, 4):
        mine = x[labels == k]
        np.testing.assert_allclose(mean[k], mine.mean(axis=0), rtol=1e-12)
        np.testing.assert_allclose(scatter[k], (mine - mean[k]).T @ (mine - mean[k]), rtol=1e-10, atol=1e-12)
    assert not mean[[1, 3]].any()
    assert not scatter[[1, 3]].any()
