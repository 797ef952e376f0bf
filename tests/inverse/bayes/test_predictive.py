"""The predictive density: Neal's formula, averages, changes of coordinates."""

import numpy as np
import pytest
from scipy.special import logsumexp

from ipcli.inverse.bayes.hyperparameters import Hyperparameters
from ipcli.inverse.bayes.predictive import Predictive

LABELS = np.array([0, 0, 1, 1, 1, 2], np.int32)


def of_seed(seed, d=2):
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(d, d))
    hyper = Hyperparameters(rng.normal(size=d), 0.4, root @ root.T + np.eye(d), d + 0.6, 1.3)
    return rng.normal(size=(len(LABELS), d)), hyper


def draws(count):
    return [Predictive.of_draw(*arranged(seed)) for seed in range(count)]


def arranged(seed):
    x, hyper = of_seed(seed)
    return x, LABELS, hyper


def test_a_draw_is_the_ratio_of_marginal_likelihoods_by_the_restaurant():
    """p(x | cluster) is the marginal likelihood with x over that without it: a way that knows of no t density."""
    from ipcli.inverse.bayes.normal_wishart import SetStatistics

    x, hyper = of_seed(0)
    new, base = np.array([[0.3, -0.7]]), hyper.base()
    parts = []
    for label, weight in [(0, 2), (1, 3), (2, 1), (3, hyper.alpha)]:
        mine = x[label == LABELS]
        both = np.concatenate([mine, new])
        with_it, without = (
            base.log_marginal(SetStatistics.of(points, np.zeros(len(points), int), 1))[0] for points in (both, mine)
        )
        parts.append(np.log(weight / (len(x) + hyper.alpha)) + with_it - without)
    assert Predictive.of_draw(x, LABELS, hyper).log_density(new)[0] == pytest.approx(logsumexp(parts), rel=1e-10)


def test_the_mean_averages_densities_and_its_draws_come_out_again():
    each = draws(4)
    whole, x = Predictive.mean(each), np.random.default_rng(9).normal(size=(7, 2))
    expected = logsumexp([one.log_density(x) for one in each], axis=0) - np.log(4)
    np.testing.assert_allclose(whole.log_density(x), expected, rtol=1e-10)
    assert whole.draws == 4
    for n, one in enumerate(each):
        np.testing.assert_allclose(whole.of(n).log_density(x), one.log_density(x), rtol=1e-10)


@pytest.mark.parametrize(("wanted", "kept"), [(1, [0]), (2, [0, 4]), (3, [0, 2, 4]), (5, None), (9, None)])
def test_thinned_are_evenly_spread_draws(wanted, kept):
    whole, x = Predictive.mean(draws(5)), np.random.default_rng(9).normal(size=(3, 2))
    expected = whole if kept is None else whole.of(np.array(kept))
    np.testing.assert_array_equal(whole.thinned(wanted).log_density(x), expected.log_density(x))


def test_in_other_coordinates_densities_change_by_the_determinant():
    one, x = draws(1)[0], np.random.default_rng(9).normal(size=(5, 2))
    shift, chol = np.array([3.0, -1.0]), np.array([[2.0, 0.0], [0.7, 0.5]])
    moved = one.affine(shift, chol).log_density(shift + x @ chol.T)
    np.testing.assert_allclose(moved, one.log_density(x) - np.log(np.diagonal(chol)).sum(), rtol=1e-10)


def test_responsibilities_are_the_shares_of_the_components():
    one, x = draws(1)[0], np.random.default_rng(9).normal(size=(5, 2))
    share = one.responsibilities(x)
    joint = one.log_weight + one.students.log_density(x)
    np.testing.assert_allclose(np.log(share), joint - one.log_density(x)[:, None], atol=1e-10)


def test_it_can_be_made_again_from_its_arrays():
    one, x = Predictive.mean(draws(2)), np.zeros((1, 2))
    np.testing.assert_array_equal(Predictive(**one.arrays()).log_density(x), one.log_density(x))
