"""Alignment against evo's and scipy's, and what it must not feel."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ipcli.geometry import lie
from ipcli.geometry.alignment import align, path_extent


def drawn(seed=0, count=40, noise=0.1):
    rng = np.random.default_rng(seed)
    src = rng.normal(size=(count, 3)) * (3, 1, 0.5)
    turn = Rotation.random(random_state=seed).as_matrix()
    return src, 1.7 * src @ turn.T + rng.normal(size=3) + noise * rng.normal(size=src.shape)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("with_scale", [False, True])
def test_it_is_that_of_evo(seed, with_scale):
    evo = pytest.importorskip("evo.core.geometry")
    src, dst = drawn(seed)
    rotation, translation, scale = evo.umeyama_alignment(src.T, dst.T, with_scale)
    found = align(src, dst, with_scale=with_scale)
    np.testing.assert_allclose(found.rotation, rotation, atol=1e-10)
    np.testing.assert_allclose(found.translation, translation, atol=1e-10)
    assert found.scale == pytest.approx(scale, rel=1e-10)
    np.testing.assert_allclose(found.errors, np.linalg.norm(scale * src @ rotation.T + translation - dst, axis=1))
    assert found.rmse == pytest.approx(np.sqrt(np.mean(found.errors**2)))


def test_the_rotation_is_that_of_scipy_even_where_a_mirror_image_would_fit_better():
    src, _ = drawn(1)
    dst = src * (1, 1, -1)
    expected = Rotation.align_vectors(dst - dst.mean(axis=0), src - src.mean(axis=0))[0].as_matrix()
    found = align(src, dst, with_scale=False)
    np.testing.assert_allclose(found.rotation, expected, atol=1e-8)
    assert np.linalg.det(found.rotation) == pytest.approx(1)


def test_no_other_similarity_near_by_is_better():
    src, dst = drawn(2)
    best, rng = align(src, dst, with_scale=True), np.random.default_rng(0)
    for _ in range(200):
        turn = Rotation.from_rotvec(0.02 * rng.normal(size=3)).as_matrix() @ best.rotation
        scale = best.scale * np.exp(0.02 * rng.normal())
        moved = scale * src @ turn.T + best.translation + 0.02 * rng.normal(size=3)
        assert np.sqrt(np.mean(np.sum((moved - dst) ** 2, axis=1))) >= best.rmse


def test_unknown_places_count_nothing_and_have_no_error():
    src, dst = drawn(3)
    whole = align(src[5:], dst[5:], with_scale=True)
    src[:3], dst[3:5, 1] = np.nan, np.inf
    found = align(src, dst, with_scale=True)
    np.testing.assert_array_equal(found.matrix, whole.matrix)
    np.testing.assert_array_equal(found.errors, [*[np.nan] * 5, *whole.errors])


def test_the_matrix_moves_the_points_as_the_errors_say():
    src, dst = drawn(4)
    found = align(src, dst, with_scale=True)
    moved = (found.matrix @ np.c_[src, np.ones(len(src))].T).T
    np.testing.assert_allclose(np.linalg.norm(moved[:, :3] - dst, axis=1), found.errors, atol=1e-12)
    np.testing.assert_array_equal(moved[:, 3], 1)


@pytest.mark.parametrize("count", [0, 2])
def test_of_two_places_nothing_can_be_told(count):
    src, dst = drawn(5, count)
    found = align(src, dst, with_scale=True)
    np.testing.assert_array_equal(found.matrix, np.eye(4))
    assert len(found.errors) == count
    assert np.isnan(found.rmse)


def test_places_that_coincide_have_no_scale():
    found = align(np.ones((5, 3)), drawn(6, 5)[1], with_scale=True)
    assert found.scale == 1
    assert np.isfinite(found.errors).all()


def test_alignment_recovers_a_similarity_and_leaves_nan_out():
    rng = np.random.default_rng(2)
    a = rng.normal(size=(20, 3))
    turn = lie.exp(np.array([0.3, -1.0, 0.4]))
    b = 1.7 * a @ turn.T + [1, 2, 3]
    b[4] = np.nan
    found = align(a, b, with_scale=True)
    assert np.isclose(found.scale, 1.7)
    assert np.allclose(found.rotation, turn)
    assert found.rmse < 1e-12
    assert np.isnan(found.errors[4])
    assert align(a, b, with_scale=False).rmse > 0.3


def test_the_extent_of_a_path_passes_over_lost_poses():
    poses = np.tile(np.eye(4), (4, 1, 1))
    poses[:, :3, 3] = [[1, 0, 0], [1, 2, 0], [9, 9, 9], [1, 2, 1.5]]
    poses[2] = np.nan
    assert path_extent(poses) == pytest.approx((3.5, 2.5))
    assert path_extent(poses[2:3]) == (0.0, 0.0)
