"""What is judged from people not learnt from knows nothing of them."""

from dataclasses import replace

import numpy as np

from ipcli.models.mocap.parameters import Learning
from ipcli.stages import mocap_train
from ipcli.stages.motions import Motions
from tests.mocap_bodies import GROUPS
from tests.mocap_clips import every


def taught(clips):
    known = Motions(tuple(clips), GROUPS, {})
    names, actions = mocap_train.numbered(known.labels)
    params = mocap_train.Params(learning=Learning(frames=80))
    return mocap_train.rehearsals(known, actions, params, 0)


def test_half_of_the_people_do_not_teach_a_rehearsal_not_even_their_bones():
    clips = every(frames=12, repeats=1)
    changed = []
    for one in clips:
        crooked = one.motion.positions * [1.0, 1.3, 0.7] if one.actor in ("bob", "dan") else one.motion.positions
        changed.append(replace(one, motion=replace(one.motion, positions=crooked, rotations=None)))
    before, after = taught(clips), taught(changed)
    for cell, points in before["half 1: "].lesson.points.items():
        np.testing.assert_array_equal(points, after["half 1: "].lesson.points[cell])
    assert any((points != after["half 2: "].lesson.points[cell]).any() for cell, points in before["half 2: "].lesson.points.items())


def test_the_splits_follow_the_clips_that_are_chosen():
    clips = every(frames=4, repeats=1)
    entries = np.arange(len(clips)) % 3
    known = mocap_train.chosen(Motions(tuple(clips), GROUPS, {"one": entries}), mocap_train.Params(actors=("bob",)))
    assert [clip.actor for clip in known.clips] == ["bob"] * 3
    np.testing.assert_array_equal(known.splits["one"], [entries[n] for n, clip in enumerate(clips) if clip.actor == "bob"])
