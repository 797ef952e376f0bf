"""What groups of features are worth."""

import numpy as np

from ipcli.models.saliency import features, worth
from ipcli.models.saliency.scene_parameters import Classifying, SceneSaliency

GROUPS = ("F2", "F5", "F6", "height")


def rows(count=900):
    rng = np.random.default_rng(0)
    labels = np.where(rng.random(count) < 0.5, 1, -1)
    table = rng.normal(size=(count, features.COUNT)).astype(np.float32)
    table[:, 6] += 3.0 * (labels > 0)
    return table, labels, np.repeat(np.arange(9), count // 9)


def test_the_group_that_tells_is_the_best_and_the_last_that_is_left():
    table, labels, numbers = rows()
    p = SceneSaliency(group_size=1, classifying=Classifying(landmarks=40))
    found = worth.table(table, labels, numbers, numbers % 3, table[:, 6] - 1.5, GROUPS, p, 0)
    assert found["groups/names"][found["groups/balanced"].argmin()] in (
        "F5",
        "all but F2",
        "all but F6",
        "all but height",
    )
    rate = dict(zip(found["groups/names"].tolist(), found["groups/balanced"].tolist(), strict=True))
    assert rate["F5"] < 0.15
    assert rate["F6"] > 0.4
    assert rate["all but F5"] > 0.4
    assert found["elimination/names"][-1] == "F5"
    assert len(found["elimination/names"]) == 4
    assert found["folds/rates"][:, 0].sum() == (labels > 0).sum()
    assert (found["folds/rates"][:, 4] < 0.12).all()


def test_scores_of_a_subsequence_are_areas_under_the_curve():
    table, labels, _ = rows()
    found = dict(zip(worth.RANKED, worth.of_subsequence(table, labels, table[:, 6], -table[:, 6]), strict=True))
    assert found["learnt function"] > 0.95
    assert found["membranes as used"] < 0.05
    assert abs(found["blue"] - 0.5) < 0.06
    assert found["red"] == found["learnt function"]
