"""A pair of cameras: rectified rows agree, triangulation undoes projection, the offset moves the right camera alone."""

from dataclasses import replace

import numpy as np

from ipcli.geometry import lie
from ipcli.geometry.rig import Rig


def rig(turn=(0.02, -0.3, 0.1)):
    right = np.eye(4)
    right[:3, :3], right[:3, 3] = lie.exp(np.array(turn)), [-0.12, 0.01, -0.03]
    k = np.array([[400.0, 0, 320], [0, 410, 240], [0, 0, 1]])
    lens = np.array([-0.2, 0.05, 0.001, -0.0005])
    return Rig(np.array([[640, 480]] * 2), np.stack([k, k]), ("radtan",) * 2, (lens,) * 2, np.stack([np.eye(4), right]))


def points(count=60):
    return np.random.default_rng(0).uniform([-1, -0.8, 1.5], [1, 0.8, 6], (count, 3))


def test_rectified_rows_agree_and_disparity_is_focal_times_baseline_over_depth():
    r, x = rig(), points()
    left, right = (r.rectified(c, r.project(c, x)) for c in range(2))
    assert np.allclose(left[:, 1], right[:, 1], atol=1e-9)
    depth = (x @ r.rectifying()[0].T)[:, 2]
    assert np.allclose(left[:, 0] - right[:, 0], r.focal * r.baseline / depth, atol=1e-9)


def test_triangulation_undoes_projection():
    r, x = rig(), points()
    left, right = (r.rectified(c, r.project(c, x)) for c in range(2))
    assert np.allclose(r.triangulated(left, right), x, atol=1e-9)
    assert np.isnan(r.triangulated(right, left)).all()  # exchanged: behind the cameras


def test_distorted_and_undistorted_are_inverse_with_an_offset_too():
    r = replace(rig(), offset=0.4)
    pixels = np.random.default_rng(1).uniform([40, 40], [600, 440], (30, 2))
    for camera in range(2):
        assert np.allclose(r.distorted(camera, r.undistorted(camera, pixels)), pixels, atol=1e-6)
    assert np.allclose(rig().undistorted(1, pixels) - r.undistorted(1, pixels), [0.4, 0])
