"""The learnt function: all forms tell two clouds apart, probabilities are calibrated, errors are as (3.35) counts."""

import numpy as np
import pytest

from ipcli.models.saliency import classifier, features
from ipcli.models.saliency.scene_parameters import Classifying


def rows(count=600, seed=0, apart=3.0):
    rng = np.random.default_rng(seed)
    labels = np.where(rng.random(count) < 0.3, 1, -1)
    table = rng.normal(size=(count, features.COUNT)).astype(np.float32)
    table[:, 6] += apart * (labels > 0)
    return table, labels


@pytest.mark.parametrize("form", ["margin", "one-class", "l1"])
def test_every_form_ranks_attended_points_higher(form):
    p = Classifying(form=form, landmarks=60)
    table, labels = rows()
    learnt = classifier.learn(table, labels, ("F5",), 0.1, p, np.random.default_rng(0))
    fresh, truth = rows(seed=1)
    assert classifier.ranking(learnt.margin(fresh), truth) > (0.85 if form == "one-class" else 0.93)
    assert ((learnt.probability(fresh) > 0.5) == (truth > 0)).mean() > 0.8


def test_one_class_is_that_of_scikit_learn():
    from sklearn.svm import OneClassSVM

    table, labels = rows(200)
    p = Classifying(form="one-class")
    learnt = classifier.learn(table, labels, ("F5",), 0.1, p, np.random.default_rng(0))
    x = (table[:, 6:9].astype(float) - learnt.centre) / learnt.scale
    theirs = OneClassSVM(kernel="rbf", gamma=1 / 6, nu=0.1).fit(x[labels > 0]).decision_function(x)
    assert learnt.margin(table) == pytest.approx(theirs, abs=1e-9)


def test_with_every_point_a_landmark_the_kernel_is_exact():
    x = np.random.default_rng(2).normal(size=(40, 3))
    supports, root = classifier._landmarks(x, 0.5, 100, np.random.default_rng(0))
    values = classifier._kernel(x, supports, 0.5) @ root
    assert values @ values.T == pytest.approx(classifier._kernel(x, x, 0.5), abs=1e-4)


def test_many_points_are_learnt_by_stochastic_gradients(monkeypatch):
    monkeypatch.setattr(classifier, "LARGE", 100)
    table, labels = rows()
    learnt = classifier.learn(table, labels, ("F5",), 0.1, Classifying(landmarks=60), np.random.default_rng(0))
    assert classifier.ranking(learnt.margin(table), labels) > 0.93


def test_five_percent_of_what_nobody_looked_at_is_above_the_threshold():
    table, labels = rows(2000)
    learnt = classifier.learn(table, labels, ("F5",), 0.1, Classifying(), np.random.default_rng(0))
    assert (learnt.margin(table)[labels < 0] > learnt.threshold).mean() == pytest.approx(0.05, abs=0.003)


def test_probabilities_are_right_as_often_as_they_say():
    rng = np.random.default_rng(5)
    margins = rng.normal(size=4000)
    labels = np.where(rng.random(4000) < classifier.logistic(2 * margins + 0.5), 1, -1)
    table, some = rows()
    learnt = classifier.learn(table, some, ("F5",), 0.1, Classifying(landmarks=20), rng)
    slope = classifier.calibrated(learnt, margins, labels).slope
    odds = np.log((labels > 0).mean() / (labels < 0).mean())  # both classes weigh the same
    assert slope == pytest.approx([2.0, 0.5 - odds], abs=0.25)


def test_the_combination_is_the_weighted_mean_which_minimises_3_20():
    table, labels = rows()
    functions = [
        classifier.learn(table, labels, groups, 0.1, Classifying(landmarks=20), np.random.default_rng(0))
        for groups in (("F5",), ("F6",))
    ]
    mean = classifier.combined(functions, [3.0, 1.0], table)
    both = np.stack([f.probability(table) for f in functions])
    assert mean == pytest.approx((3 * both[0] + both[1]) / 4)
    cost = [((3 * (u - both[0]) ** 2) + (u - both[1]) ** 2).sum() for u in (mean - 0.01, mean, mean + 0.01)]
    assert cost[1] < min(cost[0], cost[2])


def test_folds_keep_subsequences_whole_unless_they_are_random():
    numbers = np.repeat(np.arange(9), 20)
    whole = classifier.folds_of(numbers, Classifying(), np.random.default_rng(0))
    assert all(len(np.unique(whole[numbers == n])) == 1 for n in range(9))
    mixed = classifier.folds_of(numbers, Classifying(split="random"), np.random.default_rng(0))
    assert len(np.unique(mixed[numbers == 0])) > 1
    assert np.bincount(whole).tolist() == [60, 60, 60]


def test_balanced_error_rate_counts_both_classes_alike():
    rates = classifier.error_rates(np.array([1.0, -1, 1, -1, -1, -1]), np.array([1, 1, -1, -1, -1, -1]))
    assert (rates.misses, rates.alarms, rates.balanced) == (0.5, 0.25, 0.375)
    assert rates.accuracy == pytest.approx(4 / 6)


def test_place_is_learnt_where_it_is_not_left_out_and_folds_are_not_seen():
    table, labels = rows(apart=0.0)
    folds = np.arange(len(table)) % 3
    margins, found = classifier.cross_validated(
        table, labels, folds, ("F5",), 0.1, Classifying(landmarks=60), np.random.default_rng(0)
    )
    assert len(found) == 3
    assert abs(classifier.ranking(margins, labels) - 0.5) < 0.1  # nothing to learn: chance


def test_ranking_is_the_share_of_pairs_in_order():
    assert classifier.ranking(np.array([3.0, 1, 2, 2]), np.array([1, -1, 1, -1])) == pytest.approx((2 + 1.5) / 4)
    assert np.isnan(classifier.ranking(np.ones(2), np.ones(2)))
    assert classifier.groups_used(Classifying(leave_out="F1, F4"))[0] == "F2"
