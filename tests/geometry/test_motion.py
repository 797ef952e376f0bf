"""Lengths, heading and rotations of motions against closed forms and the laws that define them."""

from __future__ import annotations

import numpy as np
import pytest

from ipcli.geometry import lie, motion
from ipcli.measurements.motions import Motion
from tests.fixtures.five_joints import GROUPS, SKELETON


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
