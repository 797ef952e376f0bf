"""The sampler's kernels against plain NumPy with the same random numbers: sweeps, and split-merge moves."""

import numpy as np
import pytest

from ipcli.inverse.bayes.chain import log_partition
from ipcli.inverse.bayes.normal_wishart import NormalWishart, SetStatistics
from ipcli.kernels import dirichlet as kernels


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


def scores(x, labels, i, prior, alpha, k):
    """log weight times predictive of point i at a new cluster, then at each of the k of the others; -inf at those that
    are empty.
    """
    others = np.delete(np.arange(len(x)), i)
    points = SetStatistics.of(x[others], labels[others], k)
    known = prior.posterior(points).predictive().log_density(x[i : i + 1])[0]
    with np.errstate(divide="ignore"):
        return np.append(np.log(alpha) + prior.predictive().log_density(x[i : i + 1])[0], np.log(points.count) + known)


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


@pytest.mark.parametrize(("n", "d", "alpha"), [(40, 2, 0.8), (40, 7, 6.0), (30, 1, 25.0), (60, 40, 3.0), (20, 0, 2.0)])
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


def log_gain(x, together, side, prior, alpha):
    """log posterior of the points `together` in two sets by `side` (1 or 2), less that of all in one."""
    labels = np.asarray(side) - 1
    apart, whole = SetStatistics.of(x[together], labels, 2), SetStatistics.of(x[together], 0 * labels, 1)
    gain = log_partition(apart.count, alpha) - log_partition(whole.count, alpha)
    return gain + prior.log_marginal(apart).sum() - prior.log_marginal(whole).sum()


def plain_scan(x, i, j, members, side, target, prior, rng):
    """A restricted scan by NumPy, sides in place; the log probability of its outcome."""
    total = 0.0
    for m, point in enumerate(members):
        side[m] = 0
        sets = [[seed, *members[side == number]] for number, seed in ((1, i), (2, j))]
        found = []
        for one in sets:
            known = prior.posterior(SetStatistics.of(x[one], np.zeros(len(one), int), 1)).predictive()
            found.append(np.log(len(one)) + known.log_density(x[[point]])[0, 0])
        log_share = np.array(found) - np.logaddexp(*found)
        side[m] = target[m] or (1 if np.log(1 - rng.random()) < log_share[0] else 2)
        total += log_share[side[m] - 1]
    return total


def plain_split_merge(x, z, prior, alpha, moves, scans, rng):
    """Split-merge moves by NumPy, labels in place; (splits, merges)."""
    splits = merges = 0
    for _ in range(moves):
        i, j = int(rng.random() * len(x)), int(rng.random() * (len(x) - 1))
        j += j >= i
        members = []
        for p in range(len(x)):
            if p not in (i, j) and z[p] in (z[i], z[j]):
                at = int(rng.random() * (len(members) + 1))
                members.append(p)
                members[at], members[-1] = p, members[at]
        members, is_merge = np.array(members, int), z[i] != z[j]
        level, together = np.log(1 - rng.random()), np.array([i, j, *members])
        target = np.where(z[members] == z[i], 1, 2) if is_merge else np.zeros(len(members), int)
        if is_merge and not level < -log_gain(x, together, [1, 2, *target], prior, alpha):
            continue
        side = np.zeros(len(members), int)
        for _ in range(1 + scans):
            plain_scan(x, i, j, members, side, 0 * target, prior, rng)
        log_q = plain_scan(x, i, j, members, side, target, prior, rng)
        gain = log_gain(x, together, [1, 2, *side], prior, alpha)
        if is_merge and level < log_q - gain:
            freed, last, merges = z[j], z.max(), merges + 1
            z[z == freed] = z[i]
            z[z == last] = freed
        elif not is_merge and level < gain - log_q:
            z[together[np.array([1, 2, *side]) == 2]], splits = z.max() + 1, splits + 1
    return splits, merges


@pytest.mark.parametrize(("n", "d", "alpha"), [(2, 1, 1.0), (12, 1, 2.0), (16, 4, 8.0), (14, 0, 1.0)])
def test_split_merge_is_the_one_numpy_makes_with_the_same_random_numbers(n, d, alpha):
    """Gains, restricted scans and the probabilities of proposals: one that is wrong leads elsewhere before long."""
    (x, *given, _), prior = setting(n, d, seed=6)
    ours, theirs = np.zeros(n, np.int32), np.zeros(n, np.int32)
    rng, same, moved = np.random.default_rng(8), np.random.default_rng(8), np.zeros(2, int)
    for _ in range(30):
        k, *found = kernels.split_merge(x, ours, int(ours.max()) + 1, *given, alpha, 3, 2, rng)
        assert tuple(found) == plain_split_merge(x, theirs, prior, alpha, 3, 2, same)
        np.testing.assert_array_equal(ours, theirs)
        assert k == ours.max() + 1
        moved += found
    assert rng.random() == same.random()
    assert moved.min() > 3


def test_the_labels_of_split_merge_have_no_gaps():
    (x, *given), _ = setting(50, 2, seed=7)
    labels, rng, k = np.zeros(50, np.int32), np.random.default_rng(1), 1
    for _ in range(200):
        before = k
        k, splits, merges = kernels.split_merge(x, labels, k, *given[:-1], 20.0, 3, 1, rng)
        assert k == before + splits - merges == len(np.unique(labels)) == labels.max() + 1
