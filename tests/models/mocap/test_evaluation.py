"""Right and wrong answers are counted as they are, and no test clip has a part in what is learnt."""

from dataclasses import replace

import numpy as np
import pytest

from ipcli.errors import ParameterError
from ipcli.inverse.bayes.parameters import Mixture
from ipcli.models.mocap import evaluation, training
from ipcli.models.mocap.evaluation import FrameAnswers
from ipcli.models.mocap.motions import Motions
from ipcli.models.mocap.parameters import Decision, Learning
from tests.fixtures.mocap_bodies import GROUPS
from tests.fixtures.mocap_clips import every

QUICK = Learning(frames=60, mixture=Mixture(sweeps=4, burn_in=2, thin=1))
SPLITS = {"first": np.array([1, 1, 2, 2] * 3), "second": np.array([1, 2, 1, 2] * 3)}


@pytest.fixture(scope="module")
def known():
    return Motions(tuple(every(frames=12, repeats=1)), GROUPS, SPLITS)


def test_a_confusion_counts_the_answers_to_each_truth():
    found = evaluation.confusion(np.array([0, 0, 2, 2, 2]), np.array([0, 1, 2, 2, 0]), 3)
    np.testing.assert_array_equal(found, [[1, 1, 0], [0, 0, 0], [1, 0, 2]])


def test_the_accuracy_of_a_group_is_over_the_frames_that_show_it():
    posterior = np.log([[0.9, 0.1], [0.9, 0.1], [0.2, 0.8], [np.nan, np.nan]])
    assert evaluation.group_accuracy(posterior, np.array([0, 1, 1, 1])) == pytest.approx(2 / 3)
    assert evaluation.group_accuracy(np.full((3, 2), np.nan), np.zeros(3, int)) == 0


def test_each_action_of_a_clip_is_a_question_and_frames_that_show_nothing_are_none():
    clip, truth = np.array([0, 0, 0, 1, 1]), np.array([0, 0, 1, 1, 1])
    posterior = np.log([[0.9, 0.1], [0.4, 0.6], [0.3, 0.7], [0.6, 0.4], [np.nan, np.nan]])
    found = FrameAnswers.of(clip, truth, posterior)
    assert list(zip(found.clip, found.label, strict=True)) == [(0, 0), (0, 1), (1, 1)]
    np.testing.assert_array_equal(found.frame_confusion(), [[1, 1], [1, 1]])
    np.testing.assert_array_equal(found.sequence_confusion(Decision()), [[1, 0], [1, 1]])


def test_random_splits_are_drawn_anew_and_numbered_and_others_are_not(known):
    made = evaluation.make_splits(known, "clips", 0, repeats=3)
    assert [split.name for split in made] == ["random clips 1", "random clips 2", "random clips 3"]
    assert len({split.train.tobytes() for split in made}) > 1
    assert len(evaluation.make_splits(known, "leave-one-out", 0, repeats=3)) == 4


def test_frames_without_a_label_are_on_neither_side(known):
    clips = tuple(replace(clip, label="" if clip.label == "bow" else clip.label) for clip in known.clips)
    (split,) = evaluation.make_splits(Motions(clips, GROUPS), "subjects", 0, test=("dan",))
    silent = known.labels == "bow"
    assert not (split.train | split.test)[silent].any()
    assert (split.train ^ split.test)[~silent].all()


def test_of_the_published_splits_some_can_be_chosen_by_name(known):
    (split,) = evaluation.make_splits(known, "published", 0, only=("second",))
    assert split.name == "second"
    np.testing.assert_array_equal(split.test, (SPLITS["second"] == 2)[known.clip])
    with pytest.raises(ParameterError, match="second"):
        evaluation.make_splits(known, "published", 0, only=("secnd",))


@pytest.fixture(scope="module")
def evaluated(known):
    parts = evaluation.make_splits(known, "published", 0)
    return evaluation.evaluate(known, parts, QUICK, Decision(), 0, unordered=(5, 1), draws=2)


def test_every_question_is_counted_once_and_every_draw(evaluated):
    assert evaluated["splits"].tolist() == ["first", "second"]
    assert (evaluated["frame_confusion"].sum(axis=(1, 2)) == 72).all()
    assert (evaluated["sequence_confusion"].sum(axis=(1, 2)) == 6).all()
    assert (evaluated["unordered_confusion"].sum(axis=(2, 3)) == 12).all()
    for s in range(2):
        mine = evaluated["clip_split"] == s
        counts = evaluation.confusion(evaluated["clip_truth"][mine], evaluated["clip_answer"][mine], 3)
        np.testing.assert_array_equal(counts, evaluated["sequence_confusion"][s])
    assert (evaluated["train_clips"] + evaluated["test_clips"] == 12).all()


def test_how_the_mixtures_are_fitted_is_left_to_the_caller(known, evaluated):
    asked = []

    def fit(points):
        asked.extend(points)
        backwards = dict(reversed(points.items()))
        return training.fit_in_turn(backwards, QUICK, 0)

    parts = evaluation.make_splits(known, "published", 0)
    again = evaluation.evaluate(known, parts, QUICK, Decision(), 0, unordered=(5, 1), draws=2, fit=fit)
    assert {name.split(": ")[0] for name in asked} == {"first", "second"}
    for name, values in evaluated.items():
        np.testing.assert_array_equal(again[name], values, err_msg=name)


def test_the_test_clips_have_no_part_in_what_is_learnt(known):
    """Their bones and movements are other ones altogether: what is fitted stays the same to the last bit."""
    parts = evaluation.make_splits(known, "subjects", 0, test=("dan",))
    changed = tuple(
        replace(one, motion=replace(one.motion, positions=one.motion.positions * [1.0, 1.4, 0.6], rotations=None))
        if one.actor == "dan"
        else one
        for one in known.clips
    )
    seen = []

    def fit(points):
        seen.append(points)
        return training.fit_in_turn(points, QUICK, 0)

    for motions in (known, Motions(changed, GROUPS)):
        evaluation.evaluate(motions, parts, QUICK, Decision(), 0, fit=fit)
    before, after = seen
    assert list(before) == list(after)
    for name, points in before.items():
        np.testing.assert_array_equal(after[name], points)
