"""An action that was never learnt is more novel than those that were; of new clips no more are lost than allowed."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from ipcli.models.mocap.calibration import PREFIXES, Reference, Standard, cross_conformal, threshold
from ipcli.models.mocap.novelty import measure
from ipcli.models.mocap.parameters import MOTION, Decision
from tests.fixtures.held_out import ACTIONS, GROUPS, asked, clips, fold, model

KNOWN = np.repeat(np.arange(ACTIONS), 25)


@pytest.fixture(scope="module")
def reference():
    return Reference.of_folds([fold(n, 12) for n in (1, 2, 3)], Decision(), ordered=True)


def novelty(reference, one):
    """As if the models of all folds said the same."""
    return reference.novelty([one] * 3)


def test_an_action_that_was_not_learnt_is_told_from_those_that_were(reference):
    known, unknown = novelty(reference, asked(10, KNOWN)), novelty(reference, asked(11, [ACTIONS] * 40))
    assert (known[:, None] < unknown).mean() > 0.97
    limit = threshold(Decision())
    assert (known > limit).mean() <= 0.1
    assert (unknown > limit).mean() >= 0.6


@pytest.mark.parametrize(("folds", "each"), [(2, 8), (3, 12), (6, 12)])
@pytest.mark.parametrize("reject", [0.5, 0.8, 0.95])
def test_where_models_agree_as_many_new_clips_are_lost_as_allowed(folds, each, reject):
    few_or_many = Reference.of_folds([fold(n, each) for n in range(1, folds + 1)], Decision(), ordered=True)
    found = few_or_many.novelty([asked(12, np.tile(KNOWN, 4))] * folds)
    assert (found > threshold(Decision(reject=reject))).mean() == pytest.approx(1 - reject, abs=0.08)


def test_the_more_may_be_lost_the_lower_the_threshold():
    limits = [threshold(Decision(reject=share)) for share in (0.7, 0.9, 0.99)]
    np.testing.assert_allclose(limits, [-np.log10(0.3), 1, 2])
    assert threshold(Decision(reject=1.0)) == np.inf


@pytest.mark.parametrize("ordered", [True, False])
def test_a_calibration_survives_as_arrays(ordered):
    made = Reference.of_folds([fold(1), fold(2)], Decision(), ordered=ordered)
    arrays = made.arrays(PREFIXES[ordered])
    back = Reference.of_arrays(GROUPS, arrays, PREFIXES[ordered])
    queries = [asked(12, [0, 1, ACTIONS], ordered)] * 2
    np.testing.assert_array_equal(back.novelty(queries), made.novelty(queries))
    assert Reference.of_arrays(GROUPS, arrays, PREFIXES[not ordered]) is None


def test_motion_is_not_asked_where_frames_are_in_no_order():
    folds = [fold(1), fold(2)]
    moved = [replace(one, log_density=one.log_density + (np.array(GROUPS) == MOTION)) for one in folds]
    poses = [Reference.of_folds(one, Decision(), ordered=False).scores for one in (folds, moved)]
    np.testing.assert_array_equal(*poses)


def test_a_fold_is_compared_with_the_others_alone():
    """Its own clips make no difference to what it says of a query."""
    one = [fold(1), fold(2)]
    other = [one[0], replace(one[1], log_density=one[1].log_density - 1.0)]
    found = [Reference.of_folds(folds, Decision(), ordered=True).scores for folds in (one, other)]
    assert (found[0][:24] != found[1][:24]).any()
    np.testing.assert_allclose(found[0][24:, 1:], found[1][24:, 1:])  # but for the density itself


def test_a_group_that_is_not_seen_is_left_out_and_a_clip_without_frames_has_no_novelty(reference):
    density, query = clips(14, np.array([0, 1, 2]))
    density[query == 0, :, 1] = np.nan
    density[query == 2] = np.nan
    one = measure(model(), density, query, 3, Decision())
    assert np.isfinite(novelty(reference, one)).tolist() == [True, True, False]
    assert reference.is_comparable(one).tolist() == [False, True, False]


def test_a_held_out_clip_without_frames_counts_for_nothing():
    lame = fold(1)
    lame.log_density[lame.query == 3] = np.nan
    found = Reference.of_folds([lame, fold(2)], Decision(), ordered=True)
    assert len(found.action) == len(found.fold) == len(found.scores) == 2 * 6 * ACTIONS - 1
    assert np.isfinite(found.scores).all()


def test_there_is_nothing_to_calibrate_on_without_a_second_fold():
    assert Reference.of_folds([], Decision(), ordered=True) is None
    assert Reference.of_folds([fold(1)], Decision(), ordered=True) is None


def test_scores_that_are_not_known_are_left_out_of_the_novelty():
    standard = Standard(np.array([[1.0, 0.0]]), np.array([[2.0, 1.0]]))
    each = np.array([[3.0, 3.0], [3.0, np.nan], [np.nan, np.nan]])
    found = standard.combined(each, np.zeros(3, int))
    assert found[:2].tolist() == [2.0, 1.0]
    assert np.isnan(found[2])


def test_scores_are_in_units_of_those_of_the_same_action_where_there_are_many():
    rng = np.random.default_rng(0)
    best = np.arange(4000) % 2
    each = rng.standard_normal((4000, 1)) * np.array([[1.0], [5.0]])[best] + np.array([[0.0], [30.0]])[best]
    many = Standard.of(each, best, 3)
    np.testing.assert_allclose(many.mean[:2, 0], [0, 30], atol=0.3)
    np.testing.assert_allclose(many.spread[:2, 0], [1, 5], rtol=0.3)
    np.testing.assert_allclose([many.mean[2, 0], many.spread[2, 0]], [each.mean(), each.std()])  # of no clip


def test_the_p_value_of_one_of_the_same_kind_is_uniform():
    rng = np.random.default_rng(1)
    known = [rng.standard_normal(400) + shift for shift in (0.0, 5.0)]  # each model has its own scale
    new = rng.standard_normal(500)
    found = 10 ** -cross_conformal(known, [new, new + 5.0])
    assert stats.kstest(found, "uniform").pvalue > 0.01


def test_the_p_value_by_a_fold_is_the_share_of_clips_that_are_as_novel_and_folds_count_by_their_clips():
    known = [np.array([1.0, 2.0, 3.0, 4.0]), np.array([0.0, 9.0])]
    asked_by_fold = [np.array([3.0, np.nan, np.nan]), np.array([0.0, 0.0, np.nan])]
    each = [(1.5 / 4, 4 / 6), (1.5 / 2, 2 / 6)]  # p-value of the first query and weight
    for power in (1.0, 0.5):
        found = 10 ** -cross_conformal(known, asked_by_fold, power)
        joined = sum(weight * p_value**power for p_value, weight in each) ** (1 / power)
        np.testing.assert_allclose(found[:2], [joined, 1.5 / 2])
        assert np.isnan(found[2])


def lost_of_new_people(people, level, power, *, trials=200, each=40, seed=0):
    """Share of the clips of new people whose p-value is below the level, where every clip is as novel as any other but
    for what its person and the model that judges it make of it.
    """
    rng = np.random.default_rng(seed)
    lost = []
    for _ in range(trials):
        person, clip = 0.4 * rng.standard_normal(people + 1), rng.standard_normal((people + 1, each))
        told = [person[:, None] + clip + 0.8 * rng.standard_normal(clip.shape) for _ in range(people)]
        novelty = cross_conformal([one[fold] for fold, one in enumerate(told)], [one[-1] for one in told], power)
        lost.append((10**-novelty < level).mean())
    return np.mean(lost)


@pytest.mark.parametrize("people", [2, 3, 5])
@pytest.mark.parametrize("level", [0.05, 0.1])
def test_few_or_many_people_lose_about_what_they_may(people, level):
    """Models that do not agree make the mean of their p-values strict; that of the roots is less so, and never loses
    more than it may.
    """
    by_mean, by_roots = (lost_of_new_people(people, level, power) for power in (1.0, 0.5))
    assert by_mean < by_roots
    assert 0.4 * level < by_roots < 1.1 * level


def test_what_is_beyond_all_clips_has_an_order():
    known = [np.arange(10.0)]
    found = cross_conformal(known, [np.array([8.0, 9.0, 9.5, 10.0, 1e6])])
    assert (np.diff(found) > 0).all()
