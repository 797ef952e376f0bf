"""Rows of W add to one as corrected, and as printed only where the printed formula is right."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ipcli.models.mocap import preferences

SUCCESSES = arrays(float, (4, 6), elements=st.floats(0, 30))


@given(SUCCESSES, arrays(float, (4, 6), elements=st.floats(0, 3)))
def test_corrected_rows_add_to_one(successes, prior):
    w = preferences.corrected(successes, prior)
    assert (w >= 0).all()
    np.testing.assert_allclose(w.sum(axis=1), 1)


def test_it_is_the_mode_of_the_dirichlet_posterior():
    """By search over the simplex: no other weights give prod w^(Q + kappa - 1) more."""
    successes, prior = np.array([[3.0, 1.5, 0.7]]), np.array([[1.0, 2.0, 1.4]])
    mode = preferences.corrected(successes, prior)[0]
    others = np.random.default_rng(0).dirichlet([1, 1, 1], 20000)
    power = (successes + prior - 1)[0]
    assert (np.log(others) @ power).max() <= np.log(mode) @ power


def test_a_row_without_successes_prefers_no_group():
    np.testing.assert_allclose(preferences.corrected(np.zeros((1, 4)), 1.0), 0.25)


@given(SUCCESSES)
def test_the_printed_form_is_right_if_the_kappas_add_to_the_number_of_actions(successes):
    prior = np.full((4, 6), 4 / 6)
    total = len(successes) + (successes - 1).sum(axis=1)
    rows = np.abs(total) > 1e-6
    if rows.any():
        np.testing.assert_allclose(preferences.printed(successes, prior)[rows].sum(axis=1), 1, atol=1e-8)


def test_the_printed_form_is_wrong_otherwise():
    w = preferences.printed(np.full((11, 6), 3.0), 1.0)
    assert w.sum(axis=1) == pytest.approx(np.full(11, 18 / 23))
