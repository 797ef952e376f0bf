"""Resampling, lengths, heading and rotations of motions against closed forms and the laws that define them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ipcli.errors import ParameterError
from ipcli.geometry import lie, motion
from ipcli.geometry.skeleton import Groups, Skeleton, forward_kinematics
from ipcli.measurements import motions
from ipcli.measurements.motions import Clip, Motion
from tests.fixtures.mocap_bodies import GROUPS as BODY
from tests.fixtures.mocap_bodies import OFFSETS, poses

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
    np.testing.assert_allclose(
        motion.bone_lengths(SKELETON, moved.positions), motion.bone_lengths(SKELETON, body.positions), atol=1e-12
    )
    np.testing.assert_allclose(
        motion.heading(SKELETON, moved.positions, GROUPS),
        about_y @ motion.heading(SKELETON, body.positions, GROUPS),
        atol=1e-12,
    )
    lengths = motion.bone_lengths(SKELETON, body.positions)
    assert motion.body_height(SKELETON, body.positions, GROUPS) == pytest.approx(lengths[[0, 2, 4]].sum())


def test_a_body_that_faces_z_has_its_left_at_x_and_one_lying_on_its_side_has_no_heading():
    positions = np.zeros((2, 5, 3))
    positions[0, 2], positions[0, 3] = [0.2, 0.1, 0], [-0.2, 0, 0]
    positions[1, 2], positions[1, 3] = [0, 0.4, 0], [0, 0, 0]
    found = motion.heading(SKELETON, positions, GROUPS)
    np.testing.assert_allclose(found[0], np.eye(3), atol=1e-15)
    assert np.isnan(found[1, :, 0]).all()


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


def test_a_body_that_is_not_alike_on_both_sides_has_no_mirror_image():
    lame = Skeleton(("head", "root", "left", "right", "foot", "knee"), (1, -1, 5, 1, 2, 1))
    with pytest.raises(ParameterError, match="'left' and 'right' are no mirror images"):
        replace(GROUPS, parts={"all": ("root",)}).images(lame)
    with pytest.raises(ParameterError, match="'left' and 'head' are no mirror images"):
        replace(GROUPS, parts={"left_side": ("left",), "right_side": ("head",)}).images(SKELETON)


def test_rotations_from_positions_carry_x_onto_each_bone():
    positions = np.random.default_rng(6).normal(size=(4, 5, 3))
    positions[1, 2] = np.nan
    positions[2, 0] = positions[2, 1]
    found = motion.rotations_from_positions(SKELETON, positions)
    bone = positions[:, 3] - positions[:, 1]
    np.testing.assert_allclose(found[:, 3, :, 0], bone / np.linalg.norm(bone, axis=-1, keepdims=True), atol=1e-14)
    np.testing.assert_array_equal(found[:, 1], np.broadcast_to(np.eye(3), (4, 3, 3)))
    assert np.isnan(found[1, [2, 4]]).all()
    assert np.isnan(found[2, 0]).all()
    assert np.isfinite(found[0]).all()
