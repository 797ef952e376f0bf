"""What is judged from people not learnt from knows nothing of them."""

from dataclasses import replace

import numpy as np
import pytest

from ipcli.models.mocap.motions import Motions, with_mirror_images
from ipcli.models.mocap.parameters import Learning
from ipcli.models.mocap.training import validation_splits
from tests.fixtures.mocap_bodies import GROUPS
from tests.fixtures.mocap_clips import every


def halves(clips, mirror=False):
    known = Motions(tuple(clips), GROUPS)
    learnt = with_mirror_images(known) if mirror else known
    return validation_splits(known, learnt, Learning(frames=80, mirror=mirror, folds=2), 0)


@pytest.mark.parametrize("mirror", [False, True])
def test_half_of_the_people_are_not_learnt_from_not_even_their_bones(mirror):
    clips = every(frames=12, repeats=1)
    changed = []
    for one in clips:
        crooked = one.motion.positions * [1.0, 1.3, 0.7] if one.actor in ("bob", "dan") else one.motion.positions
        changed.append(replace(one, motion=replace(one.motion, positions=crooked, rotations=None)))
    before, after = halves(clips, mirror), halves(changed, mirror)
    for cell, points in before["fold 1: "].training.points.items():
        np.testing.assert_array_equal(points, after["fold 1: "].training.points[cell])
    assert any(
        (points != after["fold 2: "].training.points[cell]).any()
        for cell, points in before["fold 2: "].training.points.items()
    )


def test_the_clips_of_a_single_person_are_halved_their_images_with_them():
    """An odd number of clips: a clip and its image must not come to different halves."""
    clips = [one for one in every(frames=12, repeats=1) if one.actor == "ann"]
    for split in halves(clips, mirror=True).values():
        mine = split.training.rows // 12
        assert {*mine % len(clips)} == {*np.flatnonzero(split.is_learnt)}
        assert (mine >= len(clips)).any()
        assert (mine < len(clips)).any()
