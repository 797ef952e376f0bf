"""Clips that went into an artefact come back from it, each alone, whatever they lack."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ipcli import schema
from ipcli.errors import FormatError
from ipcli.io.files import h5
from ipcli.io.motion import artefact
from ipcli.measurements.motions import TEST, TRAIN
from tests.fixtures.errors import check_message
from tests.fixtures.mocap_bodies import SKELETON
from tests.fixtures.mocap_clips import clip, every, take

FLOAT32 = 4 * np.finfo(np.float32).eps


def without_rotations(one):
    return replace(one, motion=replace(one.motion, rotations=None))


def same(found, written):
    assert (found.name, found.label, found.actor) == (written.name, written.label, written.actor)
    assert (found.motion.skeleton, found.motion.rate) == (written.motion.skeleton, written.motion.rate)
    np.testing.assert_array_equal(found.motion.positions, written.motion.positions.astype(np.float32))
    assert found.motion.positions.dtype == np.float64


def test_clips_of_any_length_and_rate_come_back(tmp_path):
    written = [clip("wave", 0, 7), replace(clip("kick", 1, 1), motion=replace(clip("kick", 1, 1).motion, rate=59.94))]
    splits = {"first": np.array([TRAIN, TEST]), "second": np.array([0, TRAIN])}
    h5.write(tmp_path / "a.h5", "clips", artefact.clips_arrays(written, splits), {})
    clips = artefact.read_clips(tmp_path / "a.h5")
    assert clips.names == tuple(one.name for one in written)
    assert (clips.labels, clips.actors, clips.skeleton) == (("wave", "kick"), ("ann", "bob"), SKELETON)
    assert clips.files(clips.names[0]) == (tmp_path / "a.h5",)
    assert {name: row.tolist() for name, row in clips.splits.items()} == {"first": [1, 2], "second": [0, 1]}
    for one in written:
        found = clips.load(one.name)
        same(found, one)
        np.testing.assert_allclose(found.motion.rotations, one.motion.rotations, atol=FLOAT32)
        assert found.frame_labels is None


def test_unseen_joints_stay_unseen():
    one = clip("bow", 0, 5)
    one.motion.positions[2:, 3] = np.nan
    one.motion.rotations[1, 2] = np.nan
    found = artefact.of_arrays(artefact.clips_arrays([one], {})).load(one.name)
    same(found, one)
    np.testing.assert_array_equal(np.isnan(found.motion.rotations), np.isnan(one.motion.rotations))


def test_rotations_are_kept_only_where_every_clip_has_them():
    both = [clip("bow", 0, 3), without_rotations(clip("wave", 0, 4))]
    arrays = artefact.clips_arrays(both, {})
    assert "rotations" not in arrays
    assert artefact.of_arrays(arrays).load(both[0].name).motion.rotations is None
    assert "rotations" in artefact.clips_arrays(both[:1], {})


def test_labels_of_frames_are_those_of_the_clip_where_it_has_none_of_its_own():
    whole, one = take(), clip("kick", 2, 6)
    clips = artefact.of_arrays(artefact.clips_arrays([one, whole], {}))
    np.testing.assert_array_equal(clips.load("take").frame_labels, whole.frame_labels)
    np.testing.assert_array_equal(clips.load(one.name).frame_labels, ["kick"] * 6)


def test_the_fields_satisfy_the_schema_and_are_what_was_given_again():
    arrays = artefact.clips_arrays([*every(frames=3, repeats=1), take()], {"s": np.arange(13) % 3})
    schema.validate(schema.kind("clips"), arrays)
    clips = artefact.of_arrays(arrays)
    again = artefact.clips_arrays((clips.load(name) for name in clips.names), clips.splits)
    assert list(again) == list(arrays)
    for name, array in arrays.items():
        if name == "rotations":
            np.testing.assert_allclose(again[name], array, atol=FLOAT32)
        else:
            np.testing.assert_array_equal(again[name], array)
            assert again[name].dtype == array.dtype


def test_frames_that_do_not_add_up_are_refused():
    arrays = artefact.clips_arrays(every(frames=3, repeats=1), {})
    arrays["frames"] = arrays["frames"] + (np.arange(12) == 5)
    with pytest.raises(FormatError) as raised:
        artefact.of_arrays(arrays, "a.h5")
    check_message(raised.value, "a.h5: the frames of the clips do not add up (expected 36, got 37)")


def test_an_unsound_clip_is_refused_when_it_is_read_and_the_others_are_not():
    written = every(frames=3, repeats=1)[:2]
    arrays = artefact.clips_arrays(written, {})
    arrays["positions"][4, 0, 0] = np.inf
    clips = artefact.of_arrays(arrays, "a.h5")
    same(clips.load(written[0].name), written[0])
    with pytest.raises(FormatError) as raised:
        clips.load(written[1].name)
    check_message(raised.value, f"a.h5: clip '{written[1].name}': an infinite position at frame 1, joint 'hips'")
