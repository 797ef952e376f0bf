"""Diagnostics of chains whose answer is known: independent draws, autoregressions, chains that disagree."""

import numpy as np
import pytest

from ipcli.inverse.bayes.diagnostics import effective_draws, split_r_hat


def autoregression(rho, m=4, n=20_000, seed=0):
    from scipy.signal import lfilter

    noise = np.random.default_rng(seed).standard_normal((m, n))
    return lfilter([np.sqrt(1 - rho**2)], [1, -rho], noise, axis=1)


@pytest.mark.parametrize("rho", [0.0, 0.3, 0.8])
def test_an_autoregression_is_worth_what_theory_says(rho):
    chains = autoregression(rho)
    assert effective_draws(chains) == pytest.approx(chains.size * (1 - rho) / (1 + rho), rel=0.12)
    assert split_r_hat(chains) == pytest.approx(1, abs=5e-3)


def test_chains_at_two_places_do_not_agree_nor_does_one_that_drifts():
    chains = autoregression(0.0, n=200)
    assert split_r_hat(chains + np.array([[0], [0], [0], [5]])) > 1.5
    assert split_r_hat(chains[:1] + np.linspace(0, 5, 200)) > 1.5
    assert effective_draws(chains + np.array([[0], [0], [0], [5]])) < 20


def test_chains_that_do_not_move_and_chains_too_short():
    assert split_r_hat(np.full((2, 10), 3.0)) == 1
    assert effective_draws(np.full((2, 10), 3.0)) == 20
    assert split_r_hat(np.array([[1.0] * 10, [2.0] * 10])) == np.inf
    assert np.isnan(split_r_hat(np.ones((1, 3))))
    assert np.isnan(effective_draws(np.ones((2, 3))))
