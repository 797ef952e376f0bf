"""Depth maps seen from another camera: where points land, who hides whom, and what is not invented."""

from dataclasses import replace

import numpy as np
import pytest

from ipcli.measurements.views import View
from ipcli.models.fusion.reprojection import reproject, reproject_all
from tests.fixtures.fusion_scenes import camera, cast, pose_at

FOCAL = np.array([[64.0, 0, 20], [0, 64.0, 15], [0, 0, 1]])


def view(depth, pose=None, intrinsics=FOCAL, confidence=None):
    return View(
        "v", np.asarray(depth, np.float32), intrinsics, np.eye(4) if pose is None else pose, confidence=confidence
    )


def wall(depth, shape=(31, 41)):
    return np.full(shape, depth, np.float32)


def test_a_view_seen_from_its_own_camera_is_itself_whatever_the_pose():
    rng = np.random.default_rng(0)
    depth = rng.uniform(1, 3, (31, 41)).astype(np.float32)
    depth[rng.random(depth.shape) < 0.2] = np.nan
    own = view(depth, pose_at((3.1, -2.7, 0.9), 0.8), confidence=rng.random(depth.shape, dtype=np.float32))
    seen, confidence = reproject(own, own)
    np.testing.assert_allclose(seen, np.where(np.isnan(depth), np.inf, depth), rtol=1e-6)
    np.testing.assert_array_equal(confidence[np.isfinite(seen)], own.confidence[np.isfinite(depth)])


@pytest.mark.parametrize("disparity", [-7, 0, 5])
def test_a_wall_seen_from_a_camera_aside_moves_by_its_whole_disparity(disparity):
    """A camera at +b sees the wall f b / z pixels further left."""
    rng = np.random.default_rng(1)
    marks = rng.random((31, 41), dtype=np.float32)
    aside = pose_at((disparity * 2.0 / 64, 0, 0))
    seen, confidence = reproject(view(wall(2.0), aside, confidence=marks), view(wall(1.0)))
    expected = np.full((31, 41), np.inf)
    expected[:, max(disparity, 0) : 41 + min(disparity, 0)] = 2
    np.testing.assert_allclose(seen, expected, rtol=1e-6)
    there = np.isfinite(expected)
    np.testing.assert_array_equal(confidence[there], np.roll(marks, disparity, axis=1)[there])
    assert not confidence[~there].any()


def test_the_nearest_surface_hides_the_others():
    """A post at 1 m before a wall at 2 m moves by 8 pixels where the wall moves by 4, and hides it there."""
    depth = wall(2.0)
    depth[:, 10:14] = 1.0
    seen, _ = reproject(view(depth, pose_at((4 * 2.0 / 64, 0, 0))), view(wall(1.0)))
    np.testing.assert_allclose(seen[:, 18:22], 1.0, rtol=1e-6)
    assert np.isinf(seen[:, 14:18]).all()  # what the post hid from the other camera
    np.testing.assert_allclose(np.delete(seen, range(14, 22), axis=1)[:, 4:], 2.0, rtol=1e-6)


@pytest.mark.parametrize("missing", [np.nan, 0.0])
def test_missing_depth_plants_no_point(missing):
    """The epipole, where depth 0 would project, lies inside the image."""
    depth = wall(missing)
    depth[5, 7] = 2.0
    seen, _ = reproject(view(depth, pose_at((0.0, 0.0, 0.5), 0.05)), view(wall(1.0)))
    assert np.isfinite(seen).sum() == 1
    same, _ = reproject(view(depth), view(wall(1.0)))
    np.testing.assert_array_equal(np.argwhere(np.isfinite(same)), [[5, 7]])


def test_what_is_behind_the_reference_camera_is_not_seen():
    seen, _ = reproject(view(wall(2.0), pose_at((0, 0, 0), np.pi)), view(wall(1.0)))
    assert np.isinf(seen).all()


@pytest.mark.parametrize("shape", [(60, 80), (17, 91), (120, 33)])
def test_views_of_any_size_give_the_depth_that_the_reference_would_see(shape):
    reference = view(cast((30, 40), camera((30, 40)), np.eye(4)), intrinsics=camera((30, 40)))
    pose = pose_at((0.05, -0.02, 0.1), 0.04)
    other = view(cast(shape, camera(shape), pose), pose, camera(shape))
    seen, _ = reproject(other, reference)
    assert seen.shape == (30, 40)
    error = np.abs(seen - reference.depth)[np.isfinite(seen)]
    assert error.size > 150
    assert np.median(error) < 5e-3


def test_a_view_without_confidence_counts_1_beside_one_that_has_some_and_alone_there_are_none():
    plain, weighted = view(wall(2.0)), view(wall(2.0), confidence=wall(0.25))
    layers = reproject_all([plain, weighted], plain)
    assert layers.depth.shape == layers.confidence.shape == (2, 31, 41)
    assert (layers.confidence[0] == 1).all()
    assert (layers.confidence[1] == 0.25).all()
    assert reproject_all([plain, replace(plain)], plain).confidence is None
