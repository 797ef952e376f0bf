"""Pose from map points: recovery, outliers, both minimal solvers, an honest covariance."""

import numpy as np
import pytest

from ipcli.geometry import lie
from ipcli.models.gaze import pose
from ipcli.models.gaze.parameters import Tracking
from tests.fixtures.gaze_rig import stereo_rig

TRUE = lie.se3_exp(np.array([0.1, -0.2, 0.05, 0.3, -0.1, 0.2]))


def seen(rng, noise=0.0, outliers=0.0, count=200):
    rig = stereo_rig()
    inside = rng.uniform([-1.5, -1.2, 1.5], [1.5, 1.2, 8], (count, 3))
    world = (inside - TRUE[:3, 3]) @ TRUE[:3, :3]
    left, right = (rig.project(c, inside) + rng.normal(0, noise, (count, 2)) for c in range(2))
    bad = rng.random(count) < outliers
    left[bad] = rng.uniform(0, 480, (int(bad.sum()), 2))
    return rig, pose.Sightings(world, left, right, np.ones(count)), bad


@pytest.mark.parametrize("solver", ["p3p", "fiore"])
def test_ransac_and_refinement_recover_the_pose_among_outliers(solver):
    rng = np.random.default_rng(0)
    rig, sightings, bad = seen(rng, noise=0.1, outliers=0.3)
    p = Tracking(pose=solver)
    start = pose.ransac(rig, sightings, p, rng)
    found = pose.refine(rig, start, sightings, cut=3.0)
    assert np.abs(lie.se3_log(found.rig_from_world @ lie.se3_inverse(TRUE))).max() < 2e-3
    assert not found.inliers[bad].any()
    assert found.inliers[~bad].all()


def test_fiore_is_exact_without_noise():
    rig, sightings, _ = seen(np.random.default_rng(1), count=12)
    (found,) = pose.fiore(sightings.points, rig.rays(0, sightings.left))
    assert np.allclose(found, TRUE, atol=1e-8)


def test_without_matches_there_is_no_pose():
    rig, sightings, _ = seen(np.random.default_rng(2))
    assert pose.ransac(rig, sightings[:3], Tracking(), np.random.default_rng(0)) is None


def test_the_covariance_is_that_of_repeated_draws():
    errors, given = [], []
    for draw in range(200):
        rig, sightings, _ = seen(np.random.default_rng(draw), noise=0.7, count=80)
        found = pose.refine(rig, TRUE, sightings, cut=6.0, loss=10.0)
        errors.append(lie.se3_log(found.rig_from_world @ lie.se3_inverse(TRUE)))
        given.append(found.covariance)
    squares = [e @ np.linalg.solve(c, e) for e, c in zip(errors, given, strict=True)]
    assert np.mean(squares) == pytest.approx(6, abs=1.0)  # chi^2 of six degrees of freedom: 6 +- .25


def test_one_camera_will_do():
    rng = np.random.default_rng(4)
    rig, sightings, _ = seen(rng, noise=0.1)
    alone = pose.Sightings(sightings.points, sightings.left, np.full_like(sightings.left, np.nan), sightings.sigma)
    start = pose.ransac(rig, alone, Tracking(), rng)
    found = pose.refine(rig, start, alone, cut=3.0)
    assert np.abs(lie.se3_log(found.rig_from_world @ lie.se3_inverse(TRUE))).max() < 3e-3


def test_agrees_with_pycolmaps_generalised_pose():
    pycolmap = pytest.importorskip("pycolmap")
    rng = np.random.default_rng(5)
    rig, s, _ = seen(rng, noise=0.3)
    cameras = [
        pycolmap.Camera(model="PINHOLE", width=640, height=480, params=[k[0, 0], k[1, 1], k[0, 2], k[1, 2]])
        for k in rig.intrinsics
    ]
    cams = [pycolmap.Rigid3d(np.ascontiguousarray(m[:3])) for m in rig.cam_from_rig]
    n = len(s.points)
    answer = pycolmap.estimate_and_refine_generalized_absolute_pose(
        np.concatenate([s.left, s.right]), np.concatenate([s.points, s.points]), [0] * n + [1] * n, cams, cameras,
        estimation_options={"max_error": 3.0}, refinement_options={"loss_function_scale": 1.0},
    )  # fmt: skip
    theirs = np.vstack([answer["rig_from_world"].matrix(), [0, 0, 0, 1]])
    ours = pose.refine(rig, TRUE, s, cut=3.0).rig_from_world
    assert np.abs(lie.se3_log(ours @ lie.se3_inverse(theirs))).max() < 1e-3
