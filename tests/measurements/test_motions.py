"""Motions resampled and mirrored, against closed forms and the laws that define them; unsound ones do not pass."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ipcli.errors import FormatError, ParameterError
from ipcli.geometry import lie
from ipcli.geometry.skeleton import Skeleton, forward_kinematics
from ipcli.measurements import motions
from ipcli.measurements.motions import RIGID_TOLERANCE, Clip, Clips, Motion, check_motion, onto
from tests.fixtures.errors import check_message
from tests.fixtures.five_joints import GROUPS, SKELETON, moving
from tests.fixtures.mocap_bodies import GROUPS as BODY
from tests.fixtures.mocap_bodies import OFFSETS, poses


@pytest.mark.parametrize("rate", [30.0, 50.0, 120.0, 77.7, 240.0])
def test_uniform_motion_is_resampled_exactly(rate):
    whole = moving(61)
    found = motions.resample(whole, rate)
    count = int(np.floor(60 / 120 * rate + 1e-9)) + 1
    assert found.rate == rate
    assert len(found.positions) == count
    times = np.arange(count)[:, None, None] / rate
    speed = (whole.positions[1] - whole.positions[0]) * 120
    np.testing.assert_allclose(found.positions, whole.positions[0] + times * speed, atol=1e-12)
    turn = lie.log(np.swapaxes(whole.rotations[0], -1, -2) @ whole.rotations[1]) * 120
    np.testing.assert_allclose(found.rotations, whole.rotations[0] @ lie.exp(times * turn), atol=1e-10)


def test_a_whole_fraction_picks_frames_and_touches_no_bit():
    whole = moving(61)
    np.testing.assert_array_equal(motions.resample(whole, 40).positions, whole.positions[::3])
    np.testing.assert_array_equal(motions.resample(whole, 40).rotations, whole.rotations[::3])


def test_next_to_an_unknown_frame_nothing_is_made_up():
    whole = moving(9)
    whole.positions[4, 2] = np.nan
    found = motions.resample(whole, 240).positions
    assert np.isnan(found[[7, 8, 9], 2]).all()
    assert np.isfinite(found[[6, 10], 2]).all()
    assert np.isfinite(found[8, [0, 1, 3, 4]]).all()


def test_one_frame_stays_one_and_labels_go_along():
    assert len(motions.resample(moving(1), 30).positions) == 1
    clip = Clip("a", moving(9), frame_labels=np.array(list("aaaabbbbb")))
    assert "".join(motions.resample_clip(clip, 60).frame_labels) == "aabbb"
    with pytest.raises(ParameterError, match="rate 0 Hz"):
        motions.resample(moving(3), 0)


@pytest.mark.parametrize("up", [(0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (-1.0, 0.0, 0.0)])
def test_in_a_mirror_left_and_right_change_places_and_distances_stay(up):
    whole, groups = moving(5), replace(GROUPS, up=up)
    image = motions.mirrored(whole, groups)
    left, right = (SKELETON.joints.index(name) for name in ("left", "right"))
    swapped = whole.positions.copy()
    swapped[:, [left, right]] = swapped[:, [right, left]]
    apart = [np.linalg.norm(x[:, :, None] - x[:, None], axis=-1) for x in (image.positions, swapped)]
    np.testing.assert_allclose(*apart)
    np.testing.assert_allclose(image.positions @ up, swapped @ up)
    np.testing.assert_allclose(
        np.linalg.det(image.positions[:, :3] - image.positions[:, 3:4]),
        -np.linalg.det(swapped[:, :3] - swapped[:, 3:4]),
    )
    np.testing.assert_allclose(np.linalg.det(image.rotations), 1)
    again = motions.mirrored(image, groups)
    np.testing.assert_array_equal(again.positions, whole.positions)
    np.testing.assert_array_equal(again.rotations, whole.rotations)


def test_a_mirrored_body_is_put_together_by_the_mirrored_rotations():
    """Of a body that is alike on both sides: kinematics and mirror may change places."""
    whole = poses(6, 1)
    image = motions.mirrored(whole, BODY)
    skeleton, flip = whole.skeleton, np.array([-1.0, 1, 1])
    local = np.stack(
        [
            image.rotations[:, joint]
            if parent < 0
            else np.swapaxes(image.rotations[:, parent], -1, -2) @ image.rotations[:, joint]
            for joint, parent in enumerate(skeleton.parents)
        ],
        axis=1,
    )
    offsets = np.where(np.array(skeleton.parents)[None, :, None] < 0, whole.positions * flip, OFFSETS)
    np.testing.assert_allclose(forward_kinematics(skeleton, local, offsets)[1], image.positions, atol=1e-12)


@pytest.mark.parametrize(("rate", "expected"), [(60, "ab"), (20, "a"), (120, "abb"), (36, "a"), (100, "ab")])
def test_a_frame_between_two_takes_the_label_of_the_nearer_of_two_the_earlier(rate, expected):
    clip = Clip("x", moving(2, 60.0), frame_labels=np.array(["a", "b"]))
    times = np.arange(len(expected)) * 60 / rate
    nearest = "".join("ab"[int(np.ceil(time - 0.5))] for time in times)
    found = "".join(motions.resample_clip(clip, rate).frame_labels)
    assert found == nearest


@pytest.mark.parametrize("rate", [30.0, 77.7, 240.0])
def test_what_happens_before_a_place_does_not_feel_what_comes_after(rate):
    """The start of a long recording is resampled as the short one is."""
    long, short = (motions.resample(moving(frames), rate) for frames in (61, 31))
    count = len(short.positions)
    np.testing.assert_array_equal(long.positions[:count], short.positions)
    np.testing.assert_array_equal(long.rotations[:count], short.rotations)


@pytest.mark.parametrize("rate", [-1.0, np.nan, np.inf])
def test_a_rate_that_is_none_is_refused(rate):
    with pytest.raises(ParameterError, match="Hz: give a number above 0"):
        motions.resample(moving(3), rate)


def test_a_sound_motion_passes_as_it_is():
    whole = moving(4)
    whole.positions[1:] = np.nan
    assert check_motion(whole, "a.bvh") is whole
    assert check_motion(replace(whole, rotations=None), "a.bvh").rotations is None


def _changed(array, index, value):
    array = array.copy()
    array[index] = value
    return array


WHOLE = moving(3)
UNSOUND = {
    "two names": (
        {"skeleton": Skeleton(("a", "b", "a", "c", "d"), SKELETON.parents)},
        "two joints are named 'a'",
    ),
    "a parent too few": ({"skeleton": Skeleton(SKELETON.joints, (1, -1, 1, 1))}, "parents do not fit the joints"),
    "a parent that is not there": ({"skeleton": Skeleton(SKELETON.joints, (1, -1, 1, 1, 5))}, "parents do not fit"),
    "below no parent": ({"skeleton": Skeleton(SKELETON.joints, (1, -2, 1, 1, 2))}, "parents do not fit"),
    "a ring": ({"skeleton": Skeleton(SKELETON.joints, (1, -1, 4, 1, 2))}, "'left' hangs from no root"),
    "flat": ({"positions": WHOLE.positions[..., :2]}, "positions have the wrong shape (expected (frames, 5, 3)"),
    "a joint too few": ({"positions": WHOLE.positions[:, 1:]}, "got (3, 4, 3)"),
    "no frames": ({"positions": WHOLE.positions[:0]}, "no frames"),
    "infinite": ({"positions": _changed(WHOLE.positions, (2, 4, 1), -np.inf)}, "at frame 2, joint 'foot'"),
    "unknown": ({"positions": np.full_like(WHOLE.positions, np.nan)}, "no joint is known in any frame"),
    "no rate": ({"rate": 0.0}, "--source-rate"),
    "a rate of no number": ({"rate": np.nan}, "--source-rate"),
    "rotations of another length": ({"rotations": WHOLE.rotations[:2]}, "rotations have the wrong shape"),
    "a scale": ({"rotations": _changed(WHOLE.rotations, (1, 3), 1.01 * np.eye(3))}, "at frame 1, joint 'right'"),
    "a mirror": ({"rotations": _changed(WHOLE.rotations, (0, 0), np.diag([1, 1, -1]))}, "at frame 0, joint 'head'"),
}


@pytest.mark.parametrize(("change", "message"), UNSOUND.values(), ids=UNSOUND)
def test_an_unsound_motion_is_refused_and_the_place_named(change, message):
    with pytest.raises(FormatError) as raised:
        check_motion(replace(WHOLE, **change), Path("a.bvh"))
    check_message(raised.value, "skeleton" if "root" in message else "a.bvh", message)


@pytest.mark.parametrize(("factor", "sound"), [(0.9, True), (1.1, False)])
def test_a_rotation_may_be_off_by_the_tolerance(factor, sound):
    scale = np.sqrt(1 + factor * RIGID_TOLERANCE)  # of R: its square is that of R^T R
    motion = replace(WHOLE, rotations=scale * WHOLE.rotations)
    if sound:
        assert check_motion(motion, "a") is motion
    else:
        with pytest.raises(FormatError, match="no rotation at frame 0, joint 'head'"):
            check_motion(motion, "a")


def test_clips_say_how_many_of_whom_and_what_they_do():
    labels = (*"abcdefg", "")
    clips = Clips(tuple(map(str, range(8))), labels, ("ann", "bob") * 3 + ("", ""), SKELETON, None, None)
    assert repr(clips) == "Clips(8 of 2 people, 5 joints; actions: a, b, c, d, e, f, ...)"


@pytest.mark.parametrize(
    ("rate", "guess"), [(0.03, "milliseconds, give --source-rate 30"), (1 / 30, "frames a second.*--source-rate 30")]
)
def test_a_rate_that_no_motion_has_names_the_likely_cause(rate, guess):
    motion = Motion(Skeleton(("a",), (-1,)), np.ones((2, 1, 3)), rate)
    with pytest.raises(FormatError, match=f"expected 1 to 1000 Hz.*{guess}"):
        check_motion(motion, "x")


@pytest.mark.parametrize("rate", [1.0, 1000.0])
def test_rates_from_1_to_1000_are_motions(rate):
    motion = Motion(Skeleton(("a",), (-1,)), np.ones((2, 1, 3)), rate)
    assert check_motion(motion, "x") is motion


def test_a_motion_is_put_onto_another_skeleton_by_names():
    positions = np.arange(18.0).reshape(2, 3, 3)
    motion = Motion(Skeleton(("a", "b", "c"), (-1, 0, 1)), positions, 30.0)
    found = onto(motion, Skeleton(("c", "x", "a"), (1, -1, -1)))
    assert found.skeleton.parents == (-1, -1, -1)
    np.testing.assert_array_equal(found.positions[:, [0, 2]], positions[:, [2, 0]])
    assert np.isnan(found.positions[:, 1]).all()
    assert onto(motion, motion.skeleton) is motion
