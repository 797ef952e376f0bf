"""An action that was never learnt is more novel than those that were; what is lost is what was allowed."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from ipcli.models.mocap import recognition
from ipcli.models.mocap.behaviours import Model
from ipcli.models.mocap.novelty import PREFIXES, Fold, Measured, Profiles, Reference, combined, measure, without_action
from ipcli.models.mocap.parameters import MOTION, Decision
from ipcli.models.mocap.projection import Projection

ACTIONS, GROUPS, FRAMES = 4, ("arm", "leg", "body", MOTION), 6
ROWS = np.random.default_rng(7).normal(-12.0, 4.0, (ACTIONS + 1, ACTIONS, len(GROUPS)))  # the last is of no action


def model(actions=ACTIONS):
    """All that recognition asks of a model whose densities are given."""
    project = Projection(np.zeros(2), np.eye(2))
    size = (actions, len(GROUPS))
    empty = tuple((None,) * len(GROUPS) for _ in range(actions))
    return Model(tuple("abcd"[:actions]), GROUPS, (project,) * len(GROUPS), empty, np.ones(size))


def clips(seed, actions, spread=1.5):
    """log densities (f, a, g) of clips, and the clip of each frame: of an action a high density of it, and a row of
    the others that is its own; people differ."""
    rng = np.random.default_rng(seed)
    centre = ROWS[actions].copy()
    for row, action in zip(centre, actions, strict=True):
        row[min(action, 1) if action == ACTIONS else action] = -2.0
    centre += spread * rng.standard_normal(centre.shape)
    frames = np.repeat(centre, FRAMES, axis=0)
    return frames + rng.standard_normal(frames.shape), np.repeat(np.arange(len(actions)), FRAMES)


def fold(seed, each=6):
    actions = np.repeat(np.arange(ACTIONS), each)
    density, query = clips(seed, actions)
    return Fold(model(), density, query, actions)


@pytest.fixture(scope="module")
def reference():
    return Reference.of_folds([fold(1), fold(2), fold(3)], Decision(), ordered=True)


def asked(seed, actions, ordered=True):
    density, query = clips(seed, np.asarray(actions))
    return measure(model(), density, query, len(actions), Decision(), ordered=ordered)


def test_an_action_that_was_not_learnt_is_told_from_those_that_were(reference):
    known = reference.novelty(asked(10, np.repeat(np.arange(ACTIONS), 20)))
    unknown = reference.novelty(asked(11, [ACTIONS] * 40))
    assert (known[:, None] < unknown).mean() > 0.97
    limit = reference.threshold(Decision())
    assert (known > limit).mean() <= 0.08
    assert (unknown > limit).mean() >= 0.6


def test_held_out_actions_are_more_novel_than_held_out_people(reference):
    assert np.median(reference.unknown) > np.quantile(reference.known, 0.9)


@pytest.mark.parametrize("reject", [0.8, 0.9, 0.98])
def test_no_more_of_the_held_out_clips_are_lost_than_allowed(reference, reject):
    lost = (reference.known > reference.threshold(Decision(reject=reject))).mean()
    assert 1 - reject - 1 / len(reference.known) <= lost <= 1 - reject + 1 / len(reference.known)


def test_the_more_may_be_lost_the_more_is_caught(reference):
    limits = [reference.threshold(Decision(reject=share)) for share in (0.7, 0.9, 0.99)]
    assert limits == sorted(limits)
    assert reference.threshold(Decision(reject=1.0)) == np.inf


@pytest.mark.parametrize("ordered", [True, False])
def test_a_calibration_survives_as_arrays(ordered):
    made = Reference.of_folds([fold(1), fold(2)], Decision(), ordered=ordered)
    back = Reference.of_arrays(GROUPS, made.arrays(PREFIXES[ordered]), PREFIXES[ordered])
    queries = asked(12, [0, 1, ACTIONS], ordered)
    np.testing.assert_array_equal(back.novelty(queries), made.novelty(queries))
    assert Reference.of_arrays(GROUPS, made.arrays(PREFIXES[ordered]), PREFIXES[not ordered]) is None


def test_motion_is_not_asked_where_frames_are_in_no_order():
    poses = [Reference.of_folds([fold(1), fold(2)], Decision(), ordered=False)]
    moved = [replace(one, log_density=one.log_density + (np.array(GROUPS) == MOTION)) for one in (fold(1), fold(2))]
    poses.append(Reference.of_folds(moved, Decision(), ordered=False))
    np.testing.assert_array_equal(poses[0].known, poses[1].known)


def test_the_order_of_frames_makes_no_difference(reference):
    density, query = clips(13, np.array([0, 2, 3]))
    order = np.random.default_rng(0).permutation(len(query))
    one, other = (measure(model(), density[rows], query[rows], 3, Decision()) for rows in (slice(None), order))
    np.testing.assert_allclose(reference.novelty(one), reference.novelty(other), rtol=1e-12)


def test_a_group_that_is_not_seen_is_left_out_and_a_clip_without_frames_has_no_novelty(reference):
    density, query = clips(14, np.array([0, 1, 2]))
    density[query == 0, :, 1] = np.nan
    density[query == 2] = np.nan
    found = reference.novelty(measure(model(), density, query, 3, Decision()))
    assert np.isfinite(found).tolist() == [True, True, False]


def test_a_held_out_clip_without_frames_counts_for_nothing():
    lame = fold(1)
    lame.log_density[lame.query == 3] = np.nan
    found = Reference.of_folds([lame, fold(2)], Decision(), ordered=True)
    assert len(found.action) == len(found.known) == 2 * 6 * ACTIONS - 1
    assert np.isfinite(found.known).all()


def test_there_is_nothing_to_calibrate_on_without_a_second_fold():
    assert Reference.of_folds([], Decision(), ordered=True) is None
    assert Reference.of_folds([fold(1)], Decision(), ordered=True) is None


def test_means_are_over_the_frames_that_tell():
    density, query = clips(15, np.array([0, 1]))
    density[0, :, 2] = np.nan
    found = measure(model(), density, query, 2, Decision())
    np.testing.assert_allclose(found.density[0, :, 2], density[1:FRAMES, :, 2].mean(axis=0) / 2)
    posterior = np.exp(recognition.frame_posteriors(model(), density, Decision()))
    np.testing.assert_allclose(found.share[1], posterior[FRAMES:].mean(axis=0))
    assert found.best.tolist() == [0, 1]


def test_a_model_without_an_action_has_all_that_is_of_the_others():
    less = without_action(replace(model(), alpha=np.arange(16.0).reshape(4, 4)), 1)
    assert less.actions == ("a", "c", "d")
    assert less.alpha[:, 0].tolist() == [0, 8, 12]
    assert len(less.predictives) == 3


def test_distances_are_in_units_of_the_spread_within_actions():
    rng = np.random.default_rng(3)
    points = rng.standard_normal((4000, 3)) * [1.0, 2.0, 5.0]
    action = np.arange(4000) % 2
    profiles = Profiles(points + 10.0 * action[:, None], action)
    found = profiles.distance(np.array([[1.0, 2.0, 5.0], [11.0, 12.0, 15.0], [0, 0, 0]]), np.array([0, 1, 2]))
    np.testing.assert_allclose(found[:2], 1.0, rtol=0.1)
    assert np.isnan(found[2])


def test_the_nearest_clips_are_those_of_the_same_action():
    points = np.array([[0.0], [1.0], [2.0], [10.0], [10.0]])
    profiles = Profiles(points, np.array([0, 0, 0, 1, 1]))
    found = profiles.nearest(np.array([[0.0], [0.0], [0.0]]), np.array([0, 1, 2]))
    np.testing.assert_allclose(found[:2], np.array([0.5, 10.0]) / points.std(), rtol=1e-6)
    assert np.isnan(found[2])


def test_scores_that_are_not_known_are_left_out_of_the_novelty():
    scale = np.array([[1.0, 2.0], [0.0, 1.0]])
    found = combined(np.array([[3.0, 3.0], [3.0, np.nan], [np.nan, np.nan]]), scale)
    assert found[:2].tolist() == [2.0, 1.0]
    assert np.isnan(found[2])


def test_queries_are_joined_and_chosen_by_all_that_is_said_of_them():
    one = asked(16, [0, 1])
    both = Measured.joined([one, asked(17, [2])])
    for name in ("log_posterior", "share", "density", "evidence"):
        np.testing.assert_array_equal(getattr(both.of(np.array([True, True, False])), name), getattr(one, name))


def test_novelty_agrees_with_the_known_novelty_of_a_clip_asked_again():
    """A Gaussian row is at its usual place: half of new clips are less novel than half of the held-out ones."""
    made = Reference.of_folds([fold(n, 20) for n in range(1, 4)], Decision(), ordered=True)
    new = made.novelty(asked(20, np.repeat(np.arange(ACTIONS), 50)))
    assert stats.ks_2samp(new, made.known).statistic < 0.25
