"""A model as arrays and back, the frames it learns from, and densities for people not learnt from."""

import numpy as np
import pytest
from scipy import stats

from ipcli.inverse.bayes.predictive import Predictive
from ipcli.models.mocap import behaviours
from ipcli.models.mocap.behaviours import Model
from ipcli.models.mocap.parameters import BODY, MOTION, Learning
from ipcli.models.mocap.projection import Projection
from tests.fixtures.mocap_bodies import GROUPS, SKELETON

SIZES = {"arm": (7, 3), "leg": (5, 4), BODY: (12, 2)}  # features and coordinates


def a_predictive(m, d, rng):
    chol = np.tril(rng.normal(size=(m, d, d)), -1) + np.eye(d)
    weight = np.log(rng.dirichlet(np.ones(m)))
    return Predictive(weight, rng.uniform(2, 9, m), rng.normal(size=(m, d)), chol, np.zeros(m, np.int32))


def a_model():
    rng = np.random.default_rng(0)
    projections = tuple(Projection(rng.normal(size=D), rng.normal(size=(D, d))) for D, d in SIZES.values())
    cells = tuple(tuple(a_predictive(rng.integers(1, 5), d, rng) for _, d in SIZES.values()) for _ in range(2))
    return Model(("kick", "wave"), tuple(SIZES), projections, cells, rng.uniform(0.5, 3, (2, 3)))


def test_a_model_of_unequal_sizes_comes_back_from_its_arrays():
    model = a_model()
    back, rng = behaviours.of_arrays(behaviours.arrays(model)), np.random.default_rng(1)
    assert (back.actions, back.groups) == (model.actions, model.groups)
    np.testing.assert_array_equal(back.alpha, model.alpha)
    for g, (full, d) in enumerate(SIZES.values()):
        x = rng.normal(size=(4, full))
        np.testing.assert_array_equal(back.projections[g](x), model.projections[g](x))
        for a in range(2):
            y = rng.normal(size=(4, d))
            np.testing.assert_array_equal(back.predictives[a][g].log_density(y), model.predictives[a][g].log_density(y))


def test_a_body_comes_back_from_its_arrays():
    lengths = np.arange(len(SKELETON.joints)) / 10
    names = (*GROUPS.parts, BODY, MOTION)
    arrays = behaviours.body_arrays(SKELETON, GROUPS, lengths, names) | {"groups": np.array(names)}
    body = behaviours.body_of_arrays(arrays, "x.h5")
    assert body.skeleton == SKELETON
    assert body.groups.parts == GROUPS.parts
    for role in ("root", "left", "right", "top", "bottom", "up"):
        assert getattr(body.groups, role) == getattr(GROUPS, role)
    assert body.groups.source == "x.h5"
    np.testing.assert_array_equal(body.lengths, lengths)


def test_the_body_is_all_groups_but_motion_side_by_side():
    parts = {"arm": np.ones((3, 2)), MOTION: np.full((3, 4), 9.0), "leg": np.zeros((3, 1))}
    found = behaviours.with_body(parts, True)
    assert list(found) == ["arm", "leg", BODY, MOTION]
    np.testing.assert_array_equal(found[BODY], [[1, 1, 0]] * 3)
    assert list(behaviours.with_body(parts, False)) == ["arm", "leg", MOTION]


def test_of_every_action_no_more_frames_are_drawn_than_asked_for_and_all_of_a_rare_one():
    actions = np.array([0] * 50 + [-1] * 30 + [1] * 4)
    rows = behaviours.draw_frames(actions, ("often", "rare"), Learning(frames=20), np.random.default_rng(0))
    assert (np.diff(rows) > 0).all()
    assert np.bincount(actions[rows] + 1).tolist() == [0, 20, 4]


@pytest.mark.parametrize("spread", [0.3, 5.0])
def test_for_others_a_component_is_wider_by_the_spread(spread):
    """At many degrees of freedom: a Gaussian, whose convolution is known."""
    chol = np.array([[[0.7, 0.0], [0.2, 0.4]]])
    one = Predictive(np.zeros(1), np.array([1e7]), np.array([[1.0, -2.0]]), chol, np.zeros(1, np.int32))
    x = np.random.default_rng(2).normal(size=(9, 2))
    wide = stats.multivariate_normal([1.0, -2.0], chol[0] @ chol[0].T + spread * np.eye(2)).logpdf(x)
    np.testing.assert_allclose(behaviours.of_others(one, spread).log_density(x), wide, atol=1e-4)
    assert behaviours.of_others(one, 0.0) is one
