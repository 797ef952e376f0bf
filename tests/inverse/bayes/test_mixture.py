"""Fitting a mixture: planted clusters, units, degenerate data, stops, workers, and the density that comes out."""

from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ipcli.errors import ParameterError
from ipcli.executor import map_items
from ipcli.inverse.bayes import generator
from ipcli.inverse.bayes.mixture import fit
from ipcli.inverse.bayes.parameters import Hyperprior, Mixture
from ipcli.inverse.bayes.partitions import nearest, variation_of_information
from ipcli.inverse.bayes.predictive import Predictive
from ipcli.rng import stream

SHORT = Mixture(sweeps=12, burn_in=4, thin=4)


def planted(n, k, d, seed, apart=4.0):
    """Points (n, d) of k Gaussians of unlike shapes, and their labels."""
    rng = np.random.default_rng(seed)
    labels = rng.integers(k, size=n)
    root = rng.normal(size=(k, d, d)) / np.sqrt(d)
    return (apart * rng.normal(size=(k, d)))[labels] + np.einsum(
        "nij,nj->ni", root[labels], rng.normal(size=(n, d))
    ), labels


@pytest.mark.parametrize(("n", "k", "d", "start"), [(400, 6, 2, 0), (500, 8, 7, 1), (300, 4, 20, 0)])
def test_planted_clusters_are_found_from_many_clusters_and_from_one(n, k, d, start):
    x, truth = planted(n, k, d, seed=1, apart=12.0)
    fitted = fit(x, Mixture(sweeps=60, burn_in=30, thin=3, start=start, moves=20), np.random.default_rng(0))
    assert variation_of_information(fitted.labels(), truth) < 0.1
    large = [np.sum(np.bincount(labels) > 0.02 * n) for labels in fitted.partitions]
    assert np.median(large) == k  # a Dirichlet process always expects a few more to come, and holds them ready


def test_one_gaussian_is_hardly_divided():
    x, _ = planted(300, 1, 7, seed=1)
    fitted = fit(x, Mixture(sweeps=300, burn_in=100, thin=5), np.random.default_rng(0))
    assert np.bincount(fitted.labels()).max() > 0.9 * len(x)


def test_the_units_of_the_data_change_the_partition_not_and_the_density_by_their_determinant():
    x, _ = planted(120, 3, 3, seed=2)
    scale, shift = np.array([[1e-3, 0, 0], [20.0, 50.0, 0], [-3.0, 1.0, 1e4]]), np.array([5.0, -1e3, 1e5])
    plain = fit(x, Mixture(sweeps=12, burn_in=4, thin=4, resolution=0), np.random.default_rng(3))
    moved = fit(x @ scale.T + shift, Mixture(sweeps=12, burn_in=4, thin=4, resolution=0), np.random.default_rng(3))
    np.testing.assert_array_equal(plain.partitions, moved.partitions)
    log_det = np.log(np.diagonal(scale)).sum()
    np.testing.assert_allclose(
        moved.predictive.log_density(x @ scale.T + shift), plain.predictive.log_density(x) - log_det, atol=1e-6
    )
    np.testing.assert_allclose(moved.log_joint, plain.log_joint - len(x) * log_det, rtol=1e-8)


def test_the_density_integrates_to_one_and_follows_the_data():
    x, _ = planted(150, 3, 1, seed=4)
    predictive = fit(x, SHORT, np.random.default_rng(0)).predictive
    at = np.linspace(-400, 400, 400_001)
    assert np.trapezoid(np.exp(predictive.log_density(at[:, None])), at) == pytest.approx(1, abs=5e-3)
    assert predictive.log_density(x).mean() > predictive.log_density(x + 30).mean() + 3


def test_a_richer_density_than_one_gaussian_is_learned():
    from scipy import stats

    x, _ = planted(1200, 5, 2, seed=6)
    predictive = fit(x[:600], SHORT, np.random.default_rng(0)).predictive
    gaussian = stats.multivariate_normal(x[:600].mean(axis=0), np.cov(x[:600].T)).logpdf(x[600:])
    assert predictive.log_density(x[600:]).mean() > gaussian.mean() + 0.3


@pytest.mark.parametrize(
    "x",
    [
        np.random.default_rng(0).normal(size=(30, 3)) * [1.0, 0.0, 1.0] + [0.0, 7.0, 0.0],
        np.repeat(np.random.default_rng(0).normal(size=(3, 4)), 20, axis=0),
        np.random.default_rng(0).normal(size=(5, 20)),
        np.random.default_rng(0).normal(size=(40, 1)) * np.ones(4),
        np.zeros((25, 2)),
        np.array([[1.0, 2.0]]),
        1e9 + np.random.default_rng(0).normal(size=(40, 2)) * 1e-3,
    ],
    ids=[
        "constant column",
        "repeated points",
        "fewer points than dimensions",
        "on a line",
        "all the same",
        "one point",
        "far off",
    ],
)
def test_data_without_spread_are_carried_by_the_prior(x):
    fitted = fit(x, Mixture(sweeps=40, burn_in=20, thin=10), np.random.default_rng(1))
    assert np.isfinite(fitted.predictive.log_density(x)).all()
    assert np.isfinite(fitted.trace).all()
    assert (fitted.predictive.log_density(x) > fitted.predictive.log_density(x + 100 * (1 + np.abs(x)))).all()


def test_what_cannot_be_fitted_is_refused_in_one_line():
    rng = np.random.default_rng(0)
    for x in (np.empty((0, 3)), np.zeros(5), np.array([[1.0, np.nan]])):
        with pytest.raises(ParameterError, match="expected"):
            fit(x, SHORT, rng)
    with pytest.raises(ParameterError, match="resolution"):
        fit(np.zeros((9, 2)), Mixture(sweeps=12, burn_in=4, resolution=0), rng)
    with pytest.raises(ParameterError, match="burn_in"):
        fit(np.eye(3), Mixture(sweeps=10, burn_in=10), rng)


def same(a, b):
    for name, array in a.predictive.arrays().items():
        np.testing.assert_array_equal(array, b.predictive.arrays()[name], err_msg=name)
    np.testing.assert_array_equal(a.partitions, b.partitions)
    np.testing.assert_array_equal(a.trace, b.trace)


@pytest.mark.parametrize("stop", [1, 2, 3])
def test_a_stopped_fit_goes_on_to_the_same_result(stop):
    x, _ = planted(60, 3, 2, seed=5)
    wanted, states = Mixture(sweeps=20, burn_in=6, thin=2, chains=2), []
    whole = fit(x, wanted, np.random.default_rng(7), watch=states.append, every=6)
    assert len(states) == 4
    same(whole, fit(x, wanted, np.random.default_rng(7), state=states[stop - 1], every=5))


def density_of(name, x):
    return fit(x, SHORT, stream(3, "test", name)).predictive.log_density(x)


@pytest.mark.slow
def test_workers_in_other_processes_give_the_same_bytes():
    x, _ = planted(80, 3, 3, seed=8)
    serial = map_items(partial(density_of, x=x), ["a", "b"])
    spawned = map_items(partial(density_of, x=x), ["a", "b"], "processes:2")
    for name, found in serial.items():
        np.testing.assert_array_equal(found, spawned[name])


def test_chains_are_the_same_in_any_number_of_threads(monkeypatch):
    from ipcli import threads

    x, _ = planted(80, 3, 3, seed=8)
    wanted = Mixture(sweeps=12, burn_in=4, chains=3)
    together = fit(x, wanted, np.random.default_rng(0))
    monkeypatch.setattr(threads, "each", lambda function, items: [function(item) for item in items])
    same(together, fit(x, wanted, np.random.default_rng(0)))


def test_hyperparameters_that_are_not_learned_stay():
    x, _ = planted(50, 2, 2, seed=9)
    held = Hyperprior(learned=("xi", "w"), rho=0.3, alpha=2.5, beta_excess=4.0)
    trace = fit(x, Mixture(sweeps=12, burn_in=4, prior=held), np.random.default_rng(0)).trace
    assert (trace[0, :, 2:5] == [2.5, 0.3, 6.0]).all()


def test_draws_can_be_taken_apart_and_thinned():
    x, _ = planted(60, 3, 2, seed=5)
    fitted = fit(x, Mixture(sweeps=24, burn_in=4, thin=4), np.random.default_rng(1))
    predictive = fitted.predictive
    assert predictive.draws == len(fitted.partitions) == 5
    each = np.array([np.exp(predictive.of(draw).log_density(x)) for draw in range(5)])
    np.testing.assert_allclose(np.exp(predictive.log_density(x)), each.mean(axis=0), rtol=1e-10)
    np.testing.assert_allclose(np.exp(predictive.thinned(2).log_density(x)), each[[0, 4]].mean(axis=0), rtol=1e-10)
    np.testing.assert_array_equal(Predictive(**predictive.arrays()).log_density(x), predictive.log_density(x))
    share = predictive.responsibilities(x)
    np.testing.assert_allclose(share.sum(axis=1), 1)
    alone = fitted.behaviours()
    assert len(alone.dof) == fitted.labels().max() + 2
    assert (alone.responsibilities(x)[:, :-1].argmax(axis=1) == fitted.labels()).mean() > 0.9


@settings(max_examples=30)
@given(st.lists(st.tuples(st.integers(0, 3), st.integers(0, 3)), min_size=1, max_size=12))
def test_the_variation_of_information_is_a_distance_that_knows_no_names(pairs):
    a, b = np.array(pairs).T
    assert variation_of_information(a, b) == pytest.approx(variation_of_information(b, a), abs=1e-12)
    assert variation_of_information(a, (a + 1) % 4) == pytest.approx(0, abs=1e-12)
    assert variation_of_information(a, b) >= -1e-12
    assert (
        variation_of_information(a, 0 * a) + variation_of_information(0 * a, b)
        >= variation_of_information(a, b) - 1e-12
    )


def test_variation_of_information_in_closed_form_and_the_nearest_of_many():
    whole, halves, quarters = np.zeros(8, int), np.repeat([0, 1], 4), np.repeat([0, 1, 2, 3], 2)
    assert variation_of_information(whole, halves) == pytest.approx(np.log(2))
    assert variation_of_information(whole, quarters) == pytest.approx(np.log(4))
    assert nearest(np.array([whole, halves, quarters])) == 1


def test_a_generator_of_another_kind_is_refused_and_its_words_come_back():
    rng = np.random.default_rng(0)
    rng.integers(10, dtype=np.int32)  # leaves half a word behind
    words, other = generator.state(rng), np.random.default_rng(1)
    generator.restore(other, words)
    assert (other.integers(1000, size=5, dtype=np.int32) == rng.integers(1000, size=5, dtype=np.int32)).all()
    with pytest.raises(ValueError, match="PCG64"):
        generator.state(np.random.Generator(np.random.MT19937(0)))
