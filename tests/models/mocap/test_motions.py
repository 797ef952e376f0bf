"""Clips chosen by people and actions, and what their frames are numbered and measured by."""

from dataclasses import replace

import numpy as np
import pytest

from ipcli.errors import ParameterError
from ipcli.models.mocap import features
from ipcli.models.mocap.motions import Motions, number_actions, select, with_mirror_images
from ipcli.models.mocap.parameters import Features
from tests.fixtures.mocap_bodies import GROUPS
from tests.fixtures.mocap_clips import every, take


def test_the_splits_follow_the_clips_that_are_chosen():
    clips = every(frames=4, repeats=1)
    entries = np.arange(len(clips)) % 3
    known = select(Motions(tuple(clips), GROUPS, {"one": entries}), ("bob",), ())
    assert [clip.actor for clip in known.clips] == ["bob"] * 3
    np.testing.assert_array_equal(
        known.splits["one"], [entries[n] for n, clip in enumerate(clips) if clip.actor == "bob"]
    )


def test_labels_of_other_actions_are_forgotten_and_their_clips_kept():
    known = select(Motions((*every(frames=4, repeats=1), take()), GROUPS), (), ("kick", "bow"))
    assert len(known.clips) == 13
    assert {clip.label for clip in known.clips} == {"kick", "bow", ""}
    assert {*known.labels} == {"kick", "bow", ""}
    assert (known.labels == "").sum() == 4 * 4 + 45


@pytest.mark.parametrize(("actors", "actions", "message"), [(("bib",), (), "bob"), ((), ("kik",), "kick")])
def test_a_name_that_is_not_there_is_answered_by_the_nearest(actors, actions, message):
    with pytest.raises(ParameterError, match=message):
        select(Motions(tuple(every(frames=4, repeats=1)), GROUPS), actors, actions)


def test_clips_without_labels_leave_nothing_to_learn():
    clips = tuple(replace(clip, label="") for clip in every(frames=4, repeats=1))
    with pytest.raises(ParameterError, match="manifest"):
        select(Motions(clips, GROUPS), (), ())


def test_actions_are_numbered_in_the_order_of_their_names():
    names, number = number_actions(np.array(["wave", "", "bow", "wave"]))
    assert names == ("bow", "wave")
    np.testing.assert_array_equal(number, [1, -1, 0, 1])
    assert number_actions(np.array(["", ""]))[1].tolist() == [-1, -1]


def test_frames_count_on_from_clip_to_clip():
    clips = every(frames=4, repeats=1)[:2]
    known = Motions((*clips, take()), GROUPS)
    np.testing.assert_array_equal(known.lengths, [4, 4, 135])
    np.testing.assert_array_equal(np.bincount(known.clip), known.lengths)
    lengths, settings = known.reference_lengths(), Features()
    found = known.features(lengths, settings)
    for index, clip in enumerate(known.clips):
        for group, x in features.of_motion(clip.motion, GROUPS, lengths, settings).items():
            np.testing.assert_array_equal(found[group][known.clip == index], x)
    assert known.poses(lengths).shape == (143, len(known.skeleton.joints), 3)


def test_mirror_images_follow_the_clips_with_their_labels_and_people():
    known = Motions(tuple(every(frames=4, repeats=1)), GROUPS, {"one": np.zeros(12)})
    both = with_mirror_images(known)
    assert [*both.labels] == [*known.labels] * 2
    assert [*both.actors] == [*known.actors] * 2
    assert both.splits == {}
    lengths = known.reference_lengths()
    left, right = (np.array([name.startswith(side) for name in known.skeleton.joints]) for side in ("left", "right"))
    original, image = np.split(both.poses(lengths), 2)
    np.testing.assert_allclose(image[:, left], original[:, right] * [-1, 1, 1], atol=0.2)
