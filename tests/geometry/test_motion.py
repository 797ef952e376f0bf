"""Resampling, lengths, heading and rotations of motions against closed forms and the laws that define them."""

from __future__ import annotations

import numpy as np
import pytest

from ipcli.errors import ParameterError
from ipcli.geometry import lie, motion
from ipcli.geometry.skeleton import Clip, Groups, Motion, Skeleton, forward_kinematics

SKELETON = Skeleton(("head", "root", "left", "right", "foot"), (1, -1, 1, 1, 2))
GROUPS = Groups({"all": SKELETON.joints}, "root", ("left",), ("right",), "head", ("foot",))


def moving(frames: int, rate: float = 120.0) -> Motion:
    """Joints in uniform motion, frames in uniform turning: both are known exactly at any time."""
    rng = np.random.default_rng(3)
    times = np.arange(frames)[:, None, None] / rate
    positions = rng.normal(size=(5, 3)) + times * rng.normal(size=(5, 3))
    rotations = lie.exp(rng.normal(size=(5, 3))) @ lie.exp(times * rng.normal(size=(5, 3)))
    return Motion(SKELETON, positions, rate, rotations)


@pytest.mark.parametrize("rate", [30.0, 50.0, 120.0, 77.7, 240.0])
def test_uniform_motion_is_resampled_exactly(rate):
    whole = moving(61)
    found = motion.resample(whole, rate)
    count = int(np.floor(60 / 120 * rate + 1e-9)) + 1
    assert found.rate == rate and len(found.positions) == count
    times = np.arange(count)[:, None, None] / rate
    speed = (whole.positions[1] - whole.positions[0]) * 120
    np.testing.assert_allclose(found.positions, whole.positions[0] + times * speed, atol=1e-12)
    turn = lie.log(np.swapaxes(whole.rotations[0], -1, -2) @ whole.rotations[1]) * 120
    np.testing.assert_allclose(found.rotations, whole.rotations[0] @ lie.exp(times * turn), atol=1e-10)


def test_a_whole_fraction_picks_frames_and_touches_no_bit():
    whole = moving(61)
    np.testing.assert_array_equal(motion.resample(whole, 40).positions, whole.positions[::3])
    np.testing.assert_array_equal(motion.resample(whole, 40).rotations, whole.rotations[::3])


def test_next_to_an_unknown_frame_nothing_is_made_up():
    whole = moving(9)
    whole.positions[4, 2] = np.nan
    found = motion.resample(whole, 240).positions
    assert np.isnan(found[[7, 8, 9], 2]).all() and np.isfinite(found[[6, 10], 2]).all() and np.isfinite(found[8, [0, 1, 3, 4]]).all()


def test_one_frame_stays_one_and_labels_go_along():
    assert len(motion.resample(moving(1), 30).positions) == 1
    clip = Clip("a", moving(9), frame_labels=np.array(list("aaaabbbbb")))
    assert "".join(motion.resample_clip(clip, 60).frame_labels) == "aabbb"
    with pytest.raises(ParameterError, match="rate 0 Hz"):
        motion.resample(moving(3), 0)


def test_forward_kinematics_of_joints_in_any_order_is_the_product_of_the_chain():
    rng = np.random.default_rng(4)
    turns, moves = lie.exp(rng.normal(size=(6, 5, 3))), rng.normal(size=(1, 5, 3))
    rotations, positions = forward_kinematics(SKELETON, turns, moves)
    foot = moves[0, 1] + turns[:, 1] @ moves[0, 2] + turns[:, 1] @ turns[:, 2] @ moves[0, 4]
    np.testing.assert_allclose(positions[:, 4], foot, atol=1e-13)
    np.testing.assert_allclose(rotations[:, 4], turns[:, 1] @ turns[:, 2] @ turns[:, 4], atol=1e-13)


def test_bones_heading_and_height_do_not_feel_where_the_body_is():
    rng = np.random.default_rng(5)
    body = Motion(SKELETON, rng.normal(size=(7, 5, 3)), 30)
    about_y, shift = lie.exp(np.array([0, 0.7, 0])), np.array([3.0, -1, 2])
    moved = Motion(SKELETON, body.positions @ about_y.T + shift, 30)
    np.testing.assert_allclose(motion.bone_lengths(moved), motion.bone_lengths(body), atol=1e-12)
    np.testing.assert_allclose(motion.heading(moved, GROUPS), about_y @ motion.heading(body, GROUPS), atol=1e-12)
    lengths = motion.bone_lengths(body)
    assert motion.body_height(body, GROUPS) == pytest.approx(lengths[[0, 2, 4]].sum())


def test_a_body_that_faces_z_has_its_left_at_x_and_one_lying_on_its_side_has_no_heading():
    positions = np.zeros((2, 5, 3))
    positions[0, 2], positions[0, 3] = [0.2, 0.1, 0], [-0.2, 0, 0]
    positions[1, 2], positions[1, 3] = [0, 0.4, 0], [0, 0, 0]
    found = motion.heading(Motion(SKELETON, positions, 30), GROUPS)
    np.testing.assert_allclose(found[0], np.eye(3), atol=1e-15)
    assert np.isnan(found[1, :, 0]).all()


def test_rotations_from_positions_carry_x_onto_each_bone():
    positions = np.random.default_rng(6).normal(size=(4, 5, 3))
    positions[1, 2] = np.nan
    positions[2, 0] = positions[2, 1]
    found = motion.rotations_from_positions(SKELETON, positions)
    bone = positions[:, 3] - positions[:, 1]
    np.testing.assert_allclose(found[:, 3, :, 0], bone / np.linalg.norm(bone, axis=-1, keepdims=True), atol=1e-14)
    np.testing.assert_array_equal(found[:, 1], np.broadcast_to(np.eye(3), (4, 3, 3)))
    assert np.isnan(found[1, [2, 4]]).all() and np.isnan(found[2, 0]).all() and np.isfinite(found[0]).all()
