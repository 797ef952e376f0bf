"""Pinhole cameras: rays, points and pixels by their definitions."""

from __future__ import annotations

import numpy as np

from ipcli.geometry.cameras import back_project, project, rays, transform
from tests.fixtures.fusion_scenes import pose_at

INTRINSICS = np.array([[310.0, 0.4, 20.3], [0.0, 290.0, 14.6], [0.0, 0.0, 1.0]])


def test_projection_undoes_back_projection_and_keeps_missing_depth_missing():
    depth = np.random.default_rng(3).uniform(1, 5, (4, 6)).astype(np.float32)
    depth[1, 2] = np.nan
    pixels = project(back_project(depth, INTRINSICS), INTRINSICS)
    v, u = np.indices(depth.shape)
    known = np.isfinite(depth)
    np.testing.assert_allclose(pixels[known], np.stack([u, v], -1)[known], atol=1e-9)
    assert np.isnan(pixels[~known]).all()


def test_the_centre_of_the_first_pixel_is_the_origin_of_pixel_coordinates():
    camera = np.array([[2.0, 0, 0], [0, 2.0, 0], [0, 0, 1.0]])
    np.testing.assert_array_equal(rays((2, 2), camera)[0, 0], (0, 0, 1))
    np.testing.assert_array_equal(rays((2, 2), camera)[1, 1], (0.5, 0.5, 1))


def test_points_behind_the_camera_have_no_pixel():
    assert np.isnan(project(np.array([[0.0, 0.0, -1.0], [1.0, 0.0, 0.0]]), INTRINSICS)).all()


def test_a_motion_moves_points_as_its_matrix_does_and_keeps_their_distances():
    motion, points = pose_at((0.3, -1.0, 2.0), 0.7), np.random.default_rng(1).normal(size=(7, 3))
    moved = transform(motion, points)
    np.testing.assert_allclose(moved, (np.c_[points, np.ones(7)] @ motion.T)[:, :3])
    np.testing.assert_allclose(
        np.linalg.norm(np.diff(moved, axis=0), axis=1), np.linalg.norm(np.diff(points, axis=0), axis=1)
    )
