"""Rotations as quaternions and back, against scipy and by what a quaternion is."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ipcli.io.motion.quaternions import matrices, quaternions

FLOAT32 = 4 * np.finfo(np.float32).eps


def drawn(*shape, seed=0):
    count = int(np.prod(shape))
    return Rotation.random(count, random_state=seed).as_matrix().reshape(*shape, 3, 3)


def test_there_and_back_is_the_same_rotation():
    rotations = drawn(40, 5)
    found = quaternions(rotations)
    assert found.shape == (40, 5, 4)
    assert found.dtype == np.float32
    np.testing.assert_allclose(matrices(found), rotations, atol=FLOAT32)


def test_matrices_are_those_of_scipy_whatever_the_length_and_sign():
    q = np.random.default_rng(1).standard_normal((200, 4)) * np.logspace(-6, 6, 200)[:, None]
    np.testing.assert_allclose(matrices(q), Rotation.from_quat(q).as_matrix(), atol=1e-14)
    np.testing.assert_allclose(matrices(-q), matrices(q), atol=1e-14)


@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0.6, 0, -0.8)])
@pytest.mark.parametrize("angle", [0.0, 1e-4, 1.0, np.pi - 1e-4, np.pi, 2.0 * np.pi - 0.5])
def test_a_turn_about_an_axis_is_sine_and_cosine_of_half_the_angle(axis, angle):
    expected = np.array([*(np.sin(angle / 2) * np.array(axis)), np.cos(angle / 2)])
    found = quaternions(Rotation.from_rotvec(angle * np.array(axis)).as_matrix())
    assert found[3] >= 0
    assert min(np.abs(found - expected).max(), np.abs(found + expected).max()) < FLOAT32


def test_products_go_with_the_rotations():
    """Hamilton's product of the quaternions is the quaternion of the product of the matrices."""
    first, second = drawn(50, seed=2), drawn(50, seed=3)
    p, q = quaternions(first).astype(float), quaternions(second).astype(float)
    w = p[:, 3:] * q[:, 3:] - (p[:, :3] * q[:, :3]).sum(axis=1, keepdims=True)
    v = p[:, 3:] * q[:, :3] + q[:, 3:] * p[:, :3] + np.cross(p[:, :3], q[:, :3])
    np.testing.assert_allclose(matrices(np.hstack([v, w])), first @ second, atol=FLOAT32)


def test_what_is_not_known_stays_unknown_and_alone():
    rotations = drawn(4, 3)
    rotations[1, 2, 0, 0] = np.nan
    rotations[3] = np.nan
    found = quaternions(rotations)
    unknown = np.zeros((4, 3), bool)
    unknown[1, 2] = unknown[3] = True
    np.testing.assert_array_equal(np.isnan(found), np.repeat(unknown[..., None], 4, axis=-1))
    np.testing.assert_array_equal(np.isnan(matrices(found)).all(axis=(-2, -1)), unknown)
    np.testing.assert_allclose(matrices(found)[~unknown], rotations[~unknown], atol=FLOAT32)
    assert np.isnan(quaternions(np.full((2, 3, 3), np.nan))).all()
