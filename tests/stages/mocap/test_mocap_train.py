"""What is judged from people not learnt from knows nothing of them."""

from dataclasses import replace

import numpy as np
import pytest

from ipcli.models.mocap.parameters import Learning
from ipcli.stages.mocap import mocap_train
from ipcli.stages.mocap.motions import Motions, to_learn
from tests.fixtures.mocap_bodies import GROUPS
from tests.fixtures.mocap_clips import every


def taught(clips, mirror=False):
    known = Motions(tuple(clips), GROUPS, {})
    params = mocap_train.Params(learning=Learning(frames=80, mirror=mirror))
    return mocap_train.rehearsals(known, to_learn(known, mirror), params, 0)


@pytest.mark.parametrize("mirror", [False, True])
def test_half_of_the_people_do_not_teach_a_rehearsal_not_even_their_bones(mirror):
    clips = every(frames=12, repeats=1)
    changed = []
    for one in clips:
        crooked = one.motion.positions * [1.0, 1.3, 0.7] if one.actor in ("bob", "dan") else one.motion.positions
        changed.append(replace(one, motion=replace(one.motion, positions=crooked, rotations=None)))
    before, after = taught(clips, mirror), taught(changed, mirror)
    for cell, points in before["half 1: "].lesson.points.items():
        np.testing.assert_array_equal(points, after["half 1: "].lesson.points[cell])
    assert any(
        (points != after["half 2: "].lesson.points[cell]).any()
        for cell, points in before["half 2: "].lesson.points.items()
    )


def test_the_clips_of_a_single_person_are_halved_their_images_with_them():
    """An odd number of clips: a clip and its image must not come to different halves."""
    clips = [one for one in every(frames=12, repeats=1) if one.actor == "ann"]
    for trial in taught(clips, mirror=True).values():
        mine = trial.lesson.rows // 12
        assert {*mine % len(clips)} == {*np.flatnonzero(trial.taught)}
        assert (mine >= len(clips)).any()
        assert (mine < len(clips)).any()


def test_the_splits_follow_the_clips_that_are_chosen():
    clips = every(frames=4, repeats=1)
    entries = np.arange(len(clips)) % 3
    known = mocap_train.chosen(Motions(tuple(clips), GROUPS, {"one": entries}), mocap_train.Params(actors=("bob",)))
    assert [clip.actor for clip in known.clips] == ["bob"] * 3
    np.testing.assert_array_equal(
        known.splits["one"], [entries[n] for n, clip in enumerate(clips) if clip.actor == "bob"]
    )
