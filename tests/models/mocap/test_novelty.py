"""A clip that is like no held-out clip of its likeliest action has higher scores than those that are."""

import numpy as np
import pytest

from ipcli.models.mocap import recognition
from ipcli.models.mocap.novelty import MEASURED, SCORES, Measured, Profiles, gaps, measure, scores
from ipcli.models.mocap.parameters import Decision
from tests.fixtures.held_out import ACTIONS, FRAMES, GROUPS, asked, clips, model

EVERY = np.repeat(np.arange(ACTIONS), 20)


@pytest.fixture(scope="module")
def told():
    """The scores of clips of the actions, and of none of them, against others of the actions."""
    held_out = asked(1, EVERY)
    return [scores(GROUPS, held_out, EVERY, one) for one in (asked(2, EVERY), asked(3, [ACTIONS] * 40))]


@pytest.mark.parametrize("score", ["groups", "actions", "motion", "course of motion", "course of the body"])
def test_scores_of_an_action_that_was_not_learnt_are_higher(told, score):
    known, unknown = (one[:, SCORES.index(score)] for one in told)
    assert (known[:, None] < unknown).mean() > 0.9


def test_the_density_score_is_that_of_motion_under_the_likeliest_action():
    one = asked(4, [0, 2])
    found = scores(GROUPS, asked(1, EVERY), EVERY, one)[:, SCORES.index("density")]
    np.testing.assert_array_equal(found, [-one.density[0, 0, 3], -one.density[1, 2, 3]])


def test_without_motion_the_body_is_asked():
    held_out, one = asked(1, EVERY, ordered=False), asked(4, [0, 2], ordered=False)
    found = scores(GROUPS, held_out, EVERY, one)
    told = [score for score, column in zip(SCORES, found.T, strict=True) if np.isfinite(column).all()]
    assert told == ["density", "groups", "actions", "motion"]
    np.testing.assert_array_equal(found[:, SCORES.index("density")], [-one.density[0, 0, 2], -one.density[1, 2, 2]])


def test_a_group_that_a_held_out_clip_does_not_show_is_taken_as_its_others():
    density, query = clips(5, EVERY)
    density[query == 0, :, 1] = np.nan
    held_out = measure(model(), density, query, len(EVERY), Decision())
    assert np.isfinite(scores(GROUPS, held_out, EVERY, asked(6, [0, 1]))).all()


def with_course(seed, backwards=False):
    """What is said of clips that are more and more like one action towards their end, or their beginning."""
    density, query = clips(seed, EVERY)
    density += 5.0 * (np.arange(len(query)) % FRAMES >= FRAMES // 2)[:, None, None] * (np.arange(ACTIONS) == 3)[:, None]
    if backwards:
        density = density.reshape(-1, FRAMES, *density.shape[1:])[:, ::-1].reshape(density.shape)
    return measure(model(), density, query, len(EVERY), Decision())


def test_a_known_action_done_backwards_has_another_course_and_is_else_the_same():
    known, backwards = (scores(GROUPS, with_course(5), EVERY, with_course(6, back)) for back in (False, True))
    np.testing.assert_allclose(known[:, :4], backwards[:, :4])
    assert (known[:, None, 4:] < backwards[:, 4:]).mean(axis=(0, 1)).min() > 0.8


def test_the_course_is_the_means_of_thirds_whatever_queries_are_between():
    density, query = clips(5, np.array([0, 1]))
    density[FRAMES + 2 :] = np.nan  # the second clip has two frames
    order = np.argsort(np.tile(np.arange(FRAMES), 2), kind="stable")  # a frame of one, a frame of the other
    found = measure(model(), density[order], query[order], 2, Decision())
    evidence = recognition.group_posteriors(density[:FRAMES])
    np.testing.assert_allclose(found.course[0], evidence.reshape(3, FRAMES // 3, ACTIONS, -1).mean(axis=1))
    assert np.isfinite(found.course[1]).all(axis=(1, 2)).tolist() == [True, False, False]
    assert np.isnan(measure(model(), density, query, 2, Decision(), ordered=False).course).all()


def test_a_held_out_clip_whose_course_is_not_known_is_left_out_of_that_score():
    density, query = clips(5, EVERY)
    density[:2, :, 3] = np.nan  # a third of the first clip
    held_out = measure(model(), density, query, len(EVERY), Decision())
    assert np.isfinite(scores(GROUPS, held_out, EVERY, asked(6, [0, 1]))).all()
    own = scores(GROUPS, asked(1, EVERY), EVERY, held_out)[0]
    assert np.isfinite(own).tolist() == [True, True, True, True, False, True]


def test_gaps_grow_slower_than_what_they_are_of():
    np.testing.assert_allclose(gaps(np.log([[0.5, 0.25, 0.5]])), [[0.0, np.log1p(np.log(2)), 0.0]])


def test_means_are_over_the_frames_that_tell():
    density, query = clips(15, np.array([0, 1]))
    density[0, :, 2] = np.nan
    found = measure(model(), density, query, 2, Decision())
    np.testing.assert_allclose(found.density[0, :, 2], density[1:FRAMES, :, 2].mean(axis=0) / 2)
    posterior = recognition.frame_posteriors(model(), density, Decision())
    np.testing.assert_allclose(found.log_posterior[1], posterior[FRAMES:].mean(axis=0))
    assert found.best.tolist() == [0, 1]


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


def test_queries_are_joined_and_chosen_by_all_that_is_said_of_them():
    one = asked(16, [0, 1])
    both = Measured.joined([one, asked(17, [2])])
    for name in MEASURED:
        np.testing.assert_array_equal(getattr(both.of(np.array([True, True, False])), name), getattr(one, name))
