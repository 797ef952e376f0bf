"""The sampler against exact enumeration, the Chinese restaurant process and itself after a stop."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from ipcli.inverse.bayes.chain import Chain, log_partition, seeded
from ipcli.inverse.bayes.hyperparameters import Hyperparameters
from ipcli.inverse.bayes.parameters import Hyperprior, Mixture
from tests.fixtures.enumeration import canonical, partitions, posterior

FIXED = Hyperprior(learned=())
POINTS = np.array([[0.0, 0.1], [0.2, -0.1], [1.9, 2.0], [2.2, 1.7], [0.9, 1.2], [-3.0, 1.0]])
HYPER = Hyperparameters(xi=np.array([0.3, 0.5]), rho=0.4, w=np.array([[0.5, 0.1], [0.1, 0.3]]), beta=4.3, alpha=0.9)


def chain_of(x, rng, **settings):
    return Chain(x, Mixture(sweeps=10**6, prior=FIXED, **settings), rng)


def chi_square(every, counts, p, draws):
    """p-value of the counts of the partitions, those expected less than 5 times taken together."""
    observed, expected = np.array([counts.get(tuple(labels), 0) for labels in every.tolist()]), p * draws
    rare = expected < 5
    observed, expected = (np.append(a[~rare], a[rare].sum()) for a in (observed, expected))
    return stats.chisquare(observed, expected).pvalue


def after_one_move(chain, every, p, draws, rng, move):
    """Counts of where `move` leads from partitions drawn from the exact posterior: from there it must not stray."""
    counts = {}
    for at in rng.choice(len(every), size=draws, p=p):
        chain.labels = every[at].copy()
        move(chain)
        key = canonical(chain.labels)
        counts[key] = counts.get(key, 0) + 1
    return counts


def gibbs_alone(chain):
    from ipcli.kernels import dirichlet

    dirichlet.sweep(chain.x, chain.labels, chain.clusters, *chain.base(), chain.rng)


def split_merge_alone(chain):
    from ipcli.kernels import dirichlet

    dirichlet.split_merge(chain.x, chain.labels, chain.clusters, *chain.base(), 1, chain.settings.scans, chain.rng)


@pytest.mark.parametrize(
    ("move", "scans"), [(gibbs_alone, 0), (split_merge_alone, 0), (split_merge_alone, 2), (Chain.move, 3)]
)
def test_each_move_leaves_the_exact_posterior_of_the_203_partitions_as_it_is(move, scans):
    rng, draws = np.random.default_rng(17), 6_000
    every, p = posterior(POINTS, HYPER.base(), HYPER.alpha)
    assert len(every) == 203
    chain = chain_of(POINTS, rng, scans=scans)
    chain.hyper = HYPER
    assert chi_square(every, after_one_move(chain, every, p, draws, rng, move), p, draws) > 1e-3
    chain.hyper = replace(HYPER, alpha=1.6 * HYPER.alpha)  # the test must see a small mistake
    assert chi_square(every, after_one_move(chain, every, p, draws, rng, move), p, draws) < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("move", [gibbs_alone, split_merge_alone])
def test_from_one_start_each_kind_of_move_visits_the_203_partitions_as_often_as_they_are_probable(move):
    rng = np.random.default_rng(3)
    every, p = posterior(POINTS, HYPER.base(), HYPER.alpha)
    chain, counts, keep = chain_of(POINTS, rng), {}, 10
    chain.hyper = HYPER
    for sweep in range(100_000):
        move(chain)
        if sweep % keep == 0:
            key = canonical(chain.labels)
            counts[key] = counts.get(key, 0) + 1
    found = np.array([counts.get(tuple(labels), 0) for labels in every.tolist()]) / sum(counts.values())
    assert 0.5 * np.abs(found - p).sum() < 0.04  # total variation


def test_without_data_the_partitions_are_those_of_the_chinese_restaurant_process():
    """In no dimensions every density is 1."""
    n, alpha, rng = 12, 1.7, np.random.default_rng(8)
    chain = chain_of(np.empty((n, 0)), rng)
    chain.hyper = replace(chain.hyper, alpha=alpha)
    found = []
    for _ in range(10_000):
        chain.move()
        found.append(chain.clusters)
    share = alpha / (alpha + np.arange(n))
    assert np.mean(found) == pytest.approx(share.sum(), abs=0.06)
    assert np.var(found) == pytest.approx((share * (1 - share)).sum(), rel=0.08)


def test_partition_probabilities_add_to_one():
    p = [np.exp(log_partition(np.bincount(labels).astype(float), 0.7)) for labels in partitions(6)]
    assert sum(p) == pytest.approx(1, rel=1e-12)


@pytest.mark.slow
def test_the_order_of_the_points_does_not_change_the_posterior_of_the_number_of_clusters():
    rng = np.random.default_rng(2)
    x = np.concatenate([rng.normal(size=(12, 2)), rng.normal(size=(12, 2)) + 3])
    found = []
    for order in (np.arange(24), rng.permutation(24), np.argsort(x[:, 0])):
        chain = Chain(x[order], Mixture(sweeps=10**6), np.random.default_rng(5))
        chain.advance(6000)
        found.append(np.array(chain.trace)[500::10, 0])
    for other in found[1:]:
        assert stats.ks_2samp(found[0], other).pvalue > 1e-3


def test_a_restored_chain_ends_where_it_would_have_ended():
    x = np.random.default_rng(0).normal(size=(60, 3))
    settings = Mixture(sweeps=24, burn_in=5, thin=3)
    whole, broken = (Chain(x, settings, np.random.default_rng(4)) for _ in range(2))
    whole.advance(24)
    broken.advance(11)
    resumed = Chain(x, settings, np.random.default_rng(99))
    resumed.restore(broken.state())
    resumed.advance(1000)
    assert resumed.is_done
    for name, array in whole.state().items():
        np.testing.assert_array_equal(array, resumed.state()[name], err_msg=name)


def test_a_state_is_plain_arrays_that_later_sweeps_do_not_touch():
    chain = Chain(np.random.default_rng(0).normal(size=(30, 2)), Mixture(sweeps=20), np.random.default_rng(4))
    chain.advance(5)
    state = chain.state()
    before = {name: array.copy() for name, array in state.items()}
    chain.advance(5)
    assert all(array.dtype.kind in "iuf" for array in state.values())
    for name, array in before.items():
        np.testing.assert_array_equal(array, state[name])


def test_seeds_of_repeated_points_are_no_more_than_there_are_different_ones():
    x = np.repeat([[0.0, 1.0], [2.0, 3.0]], 5, axis=0)
    labels = seeded(x, 7, np.random.default_rng(0))
    assert set(labels.tolist()) == {0, 1}
    assert len(set(labels[:5].tolist())) == 1
