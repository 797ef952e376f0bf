"""Coordinates of a group: the spread of an action is the unit, and what tells actions apart is kept."""

import numpy as np
import pytest

from ipcli.models.mocap import projection
from ipcli.models.mocap.parameters import BODY, Features

ACTIONS = np.repeat(np.arange(4), 200)


@pytest.fixture(scope="module")
def x():
    """Four actions apart in one of six directions, of unlike spread in all."""
    rng = np.random.default_rng(0)
    mixing = rng.normal(size=(6, 6))
    return (rng.normal(size=(800, 6)) * [3, 1, 0.5, 2, 0.1, 1] + np.outer(ACTIONS, [0, 0, 2, 0, 0, 0])) @ mixing


def within(y):
    return np.mean([np.cov(y[a == ACTIONS].T, bias=True) for a in range(4)], axis=0)


@pytest.mark.parametrize("shrinkage", [0.0, 0.2, 1.0])
def test_the_spread_within_an_action_is_the_unit_but_for_the_share_of_a_sphere(x, shrinkage):
    """Each principal variance v within an action becomes v / ((1 - s) v + (s + least) mean v)."""
    y = projection.fit(x, ACTIONS, "arm", Features(shrinkage=shrinkage))(x)
    v = np.linalg.eigvalsh(within(x))
    expected = v / ((1 - shrinkage) * v + (shrinkage + projection.LEAST_SPREAD) * v.mean())
    np.testing.assert_allclose(np.linalg.eigvalsh(within(y)), np.sort(expected), rtol=1e-7)


def test_the_first_coordinate_is_what_tells_the_actions_apart(x):
    y = projection.fit(x, ACTIONS, "arm", Features(shrinkage=0.0))(x)
    means = np.array([y[a == ACTIONS].mean(axis=0) for a in range(4)])
    assert np.ptp(means[:, 0]) > 10
    assert np.ptp(means[:, 1:], axis=0).max() < 1
    np.testing.assert_allclose(y.mean(axis=0), 0, atol=1e-9)


@pytest.mark.parametrize(("group", "kept"), [("arm", 2), (BODY, 3)])
def test_no_more_coordinates_are_kept_than_asked_for(x, group, kept):
    settings = Features(dimensions=2, body_dimensions=3)
    found = projection.fit(x, ACTIONS, group, settings)
    assert found.matrix.shape == (6, kept)
    every = projection.fit(x, ACTIONS, group, Features())
    np.testing.assert_allclose(found(x), every(x)[:, :kept], atol=1e-9)


def test_a_direction_without_spread_is_left_out(x):
    flat = np.column_stack([x, x[:, 0] + x[:, 1], np.full(800, 3.0)])
    assert projection.fit(flat, ACTIONS, "arm", Features(shrinkage=0.0)).matrix.shape[1] <= 7
    constant = projection.fit(np.ones((800, 2)), ACTIONS, "arm", Features())
    assert np.isfinite(constant(np.ones((3, 2)))).all()


def test_standard_coordinates_have_unit_spread_and_a_constant_stays_finite(x):
    both = np.column_stack([x, np.full(800, 3.0)])
    y = projection.fit(both, ACTIONS, "arm", Features(projection="standard"))(both)
    np.testing.assert_allclose(y[:, :6].std(axis=0), 1)
    np.testing.assert_allclose(y.mean(axis=0), 0, atol=1e-9)
    assert not y[:, 6].any()


def test_what_is_not_known_stays_unknown(x):
    missing = x[:3].copy()
    missing[1, 2] = np.nan
    y = projection.fit(x, ACTIONS, "arm", Features())(missing)
    assert np.isfinite(y[[0, 2]]).all()
    assert np.isnan(y[1]).all()
