"""Costs of poses against the plain formula of the model."""

import numpy as np

from ipcli.geometry import lie
from ipcli.kernels import consensus
from ipcli.models.gaze import pose
from tests.fixtures.gaze_rig import stereo_rig


def test_costs_and_counts_are_those_of_the_plain_residuals():
    rng, rig = np.random.default_rng(3), stereo_rig()
    points = rng.uniform([-1, -1, 2], [1, 1, 5], (60, 3))
    points[:3, 2] = -1.0  # behind both cameras: they cost the limit
    left, right = (rig.project(camera, np.abs(points)) + rng.normal(0, 2, (60, 2)) for camera in range(2))
    right[::4] = np.nan
    left[1::5] = np.nan
    poses = lie.se3_exp(rng.normal(0, 0.004, (9, 6)))
    seen = pose.Sightings(points, left, right, np.ones(60))
    costs, counts = consensus.msac(
        poses, rig.cam_from_rig, rig.flat_intrinsics(), points, np.stack([left, right]), 9.0
    )  # fmt: skip
    errors = [pose.stereo_error(pose.residuals(rig, each, seen)) for each in poses]
    np.testing.assert_allclose(costs, [np.minimum(error, 9.0).sum() for error in errors], rtol=1e-9)
    np.testing.assert_array_equal(counts, [(error < 9.0).sum() for error in errors])
    assert 10 < counts.max() < 58
