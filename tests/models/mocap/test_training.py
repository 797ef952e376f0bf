"""What is judged from people not learnt from knows nothing of them."""

from dataclasses import replace

import numpy as np
import pytest

from ipcli.models.mocap.motions import Motions, with_mirror_images
from ipcli.models.mocap.parameters import Learning
from ipcli.models.mocap.training import validation_splits
from tests.fixtures.mocap_bodies import GROUPS
from tests.fixtures.mocap_clips import every


def halves(clips, mirror=False, **given):
    known = Motions(tuple(clips), GROUPS)
    learnt = with_mirror_images(known) if mirror else known
    learning = Learning(frames=80, mirror=mirror, folds=2, **given)
    return validation_splits(known, learnt.features(known.reference_lengths(), learning.features), learning, 0)


@pytest.mark.parametrize("mirror", [False, True])
def test_half_of_the_people_are_not_learnt_from(mirror):
    clips = every(frames=12, repeats=1)
    changed = []
    for one in clips:  # the common skeleton alone is that of all people: their bones stay
        bent = replace(one.motion, positions=one.motion.positions[::-2].repeat(2, axis=0), rotations=None)
        changed.append(replace(one, motion=bent) if one.actor in ("bob", "dan") else one)
    before, after = halves(clips, mirror), halves(changed, mirror)
    for cell, points in before["fold 1: "].training.points.items():
        np.testing.assert_allclose(points, after["fold 1: "].training.points[cell], rtol=1e-8, atol=1e-8)
    assert any(
        np.abs(points - after["fold 2: "].training.points[cell]).max() > 1e-3
        for cell, points in before["fold 2: "].training.points.items()
    )


def test_the_clips_of_a_single_person_are_halved_their_images_with_them():
    """An odd number of clips: a clip and its image must not come to different halves."""
    clips = [one for one in every(frames=12, repeats=3) if one.actor == "ann"]
    found = halves(clips, mirror=True)
    assert len(found) == 2
    for split in found.values():
        mine = split.training.rows // 12
        assert {*mine % len(clips)} == {*np.flatnonzero(split.is_learnt)}
        assert (mine >= len(clips)).any()
        assert (mine < len(clips)).any()


def test_a_split_that_would_not_know_an_action_is_left_out():
    clips = [one for one in every(frames=12, repeats=1) if one.label != "wave" or one.actor == "bob"]
    assert len(halves(every(frames=12, repeats=1))) == 2
    assert len(halves(clips)) == 1


def test_models_to_validate_learn_from_few_frames():
    for split in halves(every(frames=12, repeats=1), fold_frames=5).values():
        assert np.bincount(split.training.actions).tolist() == [5, 5, 5]
