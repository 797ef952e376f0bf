"""The tree of mixtures: the normal that one look has, and how unsure it is where two normals look alike."""

import numpy as np
import pytest

from ipcli.models.brdf import tree

RNG = np.random.default_rng(0)
AHEAD, LEFT, RIGHT = np.array([0, 0, 1.0]), np.array([-0.6, 0, 0.8]), np.array([0.6, 0, 0.8])


@pytest.fixture(scope="module")
def learnt():
    """Three normals; left and right look the same, and left is thrice as frequent."""
    kinds = RNG.choice(3, 800, p=[0.4, 0.45, 0.15])
    normals = np.stack([AHEAD, LEFT, RIGHT])[kinds]
    look = np.where(kinds[:, None] == 0, 1.0, -1.0) + 0.1 * RNG.normal(size=(800, 4))
    height = kinds[:, None] + 0.05 * RNG.normal(size=(800, 1))
    return tree.learn((height, normals + 0.02 * RNG.normal(size=normals.shape)), look, normals, RNG, most=(4, 4, 4))


def test_a_look_of_one_normal_tells_it(learnt):
    found = tree.posterior(learnt, np.full((1, 4), 1.0))
    np.testing.assert_allclose(found.normals[0], AHEAD, atol=0.01)
    assert found.concentration[0] > 0.99


def test_a_look_of_two_normals_gives_their_mean_by_how_frequent_they_are(learnt):
    found = tree.posterior(learnt, -1.0 + 0.1 * np.random.default_rng(1).normal(size=(400, 4)))
    mean = (found.normals * found.concentration[:, None]).mean(axis=0)
    np.testing.assert_allclose(mean, 0.75 * LEFT + 0.25 * RIGHT, atol=0.08)
    assert found.concentration.mean() < 0.95


def test_a_look_that_was_never_seen_has_little_evidence(learnt):
    known, strange = tree.posterior(learnt, np.array([[1.0] * 4, [1.0, -1.0, 1.0, -1.0]])).evidence
    assert strange < known - 20


def test_few_points_stay_one_leaf():
    few = tree.learn((np.arange(20.0)[:, None],), RNG.normal(size=(20, 2)), np.tile(AHEAD, (20, 1)), RNG, most=(4, 4))
    assert len(few.leaves) == 1
    assert len(few.leaves[0].counts) == 1
