import numpy as np
import pytest

from ipcli.models.saliency import image_model
from ipcli.models.saliency.channels import channels
from ipcli.models.saliency.parameters import FixationLearning
from tests.fixtures.fixation_sets import picture

QUICK = FixationLearning(trees=5, leaf=5, negatives=80)


@pytest.fixture(scope="module")
def known():
    made = []
    for seed in range(3):
        canvas, (x, y) = picture(seed)
        point = np.array([x, y]) * np.array([200 / 128, 150 / 96])
        made.append((channels(canvas), np.floor(np.random.default_rng(seed).normal(point, 5, (30, 2))).astype(int)))
    return made


def test_without_training_what_stands_out_is_salient():
    canvas, (x, y) = picture(1)
    found = image_model.saliency(canvas)
    assert found.mean() == pytest.approx(1, rel=1e-4)
    assert found[int(y * 150 / 96), int(x * 200 / 128)] > 3


def test_what_was_looked_at_is_learnt_for_a_picture_that_was_not(known):
    predictor = image_model.learnt(known[:2], tuple(known[0][0]), QUICK, seed=0)
    found, points = known[2]
    made = image_model.predicted(predictor, found)
    assert made.mean() == pytest.approx(1, rel=1e-4)
    assert made[points[:, 1], points[:, 0]].mean() > 4


def test_features_are_standardised_over_the_picture_but_for_place(known):
    found = known[0][0]
    rows = image_model.features(found, ("edges", "centre"))
    assert rows.mean(axis=0)[0] == pytest.approx(0, abs=1e-5)
    assert rows.std(axis=0)[0] == pytest.approx(1, abs=1e-3)
    assert np.array_equal(rows[:, 1], found["centre"].ravel())


def test_examples_are_the_fixations_and_places_at_random(known):
    found, points = known[0]
    rows, labels = image_model.examples(found, points, ("edges",), 50, np.random.default_rng(0))
    assert labels.sum() == len(points)
    assert len(rows) == len(points) + 50
    whole = image_model.features(found, ("edges",)).reshape(150, 200)
    assert rows[:30, 0] == pytest.approx(whole[points[:, 1], points[:, 0]])


def test_a_black_map_is_even_and_grey_levels_reach_white():
    assert np.array_equal(image_model.relative(np.zeros((2, 3))), np.ones((2, 3), np.float32))
    grey = image_model.grey(np.array([[0.0, 1.0], [2.0, 4.0]], np.float32), (20, 30))
    assert grey.shape == (20, 30)
    assert grey.max() == 255
