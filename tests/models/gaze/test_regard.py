"""Points of regard: rays on generated surfaces, where the depth changes, covariance against draws, pairing in time."""

import numpy as np
import pytest

from ipcli.geometry import lie
from ipcli.measurements.recording import Gaze
from ipcli.models.gaze import fixations, regard
from ipcli.models.gaze.parameters import Looking
from ipcli.models.gaze.patch import Plane
from ipcli.models.gaze.surface import Surface
from tests.fixtures.gaze_rig import stereo_rig

K = np.array([[400.0, 0, 320], [0, 400, 240], [0, 0, 1]])


def plane(normal=(0.3, 0.2, -1.0), distance=3.0):
    """Inverse depth of n . X = -distance, which is linear in pixels."""
    v, u = np.indices((480, 640))
    rays = np.stack([(u - 320) / 400, (v - 240) / 400, np.ones((480, 640))], axis=-1)
    return rays @ (np.array(normal) / -distance)


def surface(inverse, sigma=1e-4):
    return Surface(inverse, 0, K, np.eye(3), sigma)


@pytest.mark.parametrize("origin", [np.zeros(3), np.array([0.05, 0.03, -0.02])])
def test_the_point_lies_on_the_plane_and_on_the_ray(origin):
    direction = np.array([0.2, -0.1, 1.0]) / np.linalg.norm([0.2, -0.1, 1.0])
    found = regard.look(surface(plane()), origin, direction, Looking(sigma=0.5))
    assert found.outcome == regard.HIT
    length = (-3.0 - origin @ [0.3, 0.2, -1.0]) / (direction @ [0.3, 0.2, -1.0])
    tolerance = 0.02 if origin.any() else 1e-3  # depth is that of the nearest pixel
    assert np.allclose(found.point, origin + length * direction, atol=tolerance)


def test_a_ray_stops_at_what_is_in_front():
    inverse = np.full((480, 640), 1 / 4.0)
    inverse[:, 300:360] = 1 / 2.0  # a board
    from_beside = np.array([-0.5, 0.0, 0.0])
    ray = np.array([0.5, 0.0, 2.0])  # meets the board's middle, though its own pixel at 4 m is another
    found = regard.look(surface(inverse), from_beside, ray / np.linalg.norm(ray), Looking(sigma=0.2))
    assert found.point[2] == pytest.approx(2.0, abs=0.05)


def test_at_the_rim_of_an_object_the_region_holds_both_surfaces():
    inverse = np.full((480, 640), 1 / 4.0)
    inverse[:, :322] = 1 / 2.0
    found = regard.look(surface(inverse), np.zeros(3), np.array([0.0, 0.0, 1.0]), Looking(sigma=1.0))
    beyond = np.array([4 * np.tan(np.radians(1.0)), 0, 4.0])  # a degree to the right, on the far surface
    near = np.array([-2 * np.tan(np.radians(1.0)), 0, 2.0])
    other = (beyond if found.point[2] < 3 else near) - found.point
    assert other @ np.linalg.solve(found.covariance, other) < 7.8


def test_the_covariance_is_that_of_repeated_gaze():
    p, rng = Looking(sigma=1.0), np.random.default_rng(0)
    true = np.array([0.1, -0.05, 1.0]) / np.linalg.norm([0.1, -0.05, 1.0])
    target = regard.look(surface(plane(), 1e-3), np.zeros(3), true, Looking(sigma=0.01)).point
    squares = []
    for _ in range(400):
        ray = regard.cone(true, 0.0)[0] + np.radians(1.0) * np.array([*rng.normal(size=2), 0.0])
        found = regard.look(surface(plane(), 1e-3), np.zeros(3), ray / np.linalg.norm(ray), p)
        off = target - found.point
        squares.append(off @ np.linalg.solve(found.covariance + 1e-8 * np.eye(3), off))
    assert np.mean(squares) == pytest.approx(2.0, abs=0.35)  # two degrees of freedom: hardly an error in depth


def test_a_tilt_that_is_not_known_counts_where_the_truth_may_be(monkeypatch):
    """A tilt alone does not move the point on the ray, but the places a degree beside it."""
    tilt = 0.05  # 1 / metres: error of the inverse depth at one unit of normalised coordinates, across and down
    aligned = Plane(np.array([0.0, 0.0, 1 / 3]), np.diag([tilt**2, tilt**2, 0.0]))
    monkeypatch.setattr(Surface, "plane_around", lambda *given: aligned)
    ahead = np.array([0.0, 0.0, 1.0])
    found = regard.look(surface(np.full((480, 640), 1 / 3), 0.0), np.zeros(3), ahead, Looking(sigma=1.0))
    depth = 3.0**2 * tilt * np.radians(1.0) * np.sqrt(2)  # z^2 times the inverse depth's error, both ways
    assert np.sqrt(found.covariance[2, 2]) == pytest.approx(depth, rel=0.01)


def test_the_pattern_is_a_standard_normal():
    points = regard.pattern()
    assert np.allclose(points.mean(axis=0), 0, atol=1e-12)
    assert np.allclose(points.T @ points / len(points), np.eye(2), atol=1e-12)


def test_without_depth_around_there_is_no_point():
    found = regard.look(surface(np.full((480, 640), np.nan)), np.zeros(3), np.array([0, 0, 1.0]), Looking())
    assert found.outcome == regard.NO_DEPTH
    assert np.isnan(found.point).all()


def test_too_far_is_said():
    found = regard.look(surface(np.full((480, 640), 1 / 100)), np.zeros(3), np.array([0, 0, 1.0]), Looking())
    assert found.outcome == regard.FAR


def test_the_covariance_of_the_pose_is_carried_into_the_world():
    rng = np.random.default_rng(1)
    pose, spread = lie.se3_exp(rng.normal(0, 0.5, 6)), np.diag([1, 2, 3, 4, 5, 6]) * 1e-6
    found = regard.Regard(np.array([0.3, -0.2, 2.5]), np.zeros((3, 3)), regard.HIT)
    point, covariance = regard.in_world(found, pose, spread)
    drawn = [
        regard.in_world(found, lie.se3_exp(rng.multivariate_normal(np.zeros(6), spread)) @ pose, spread)[0] - point
        for _ in range(4000)
    ]
    assert np.allclose(np.cov(np.array(drawn).T), covariance, atol=0.12 * np.trace(covariance))


def test_gaze_is_paired_with_the_nearest_frame_and_poses_are_interpolated():
    times = np.array([0.0, 0.1, 0.2])
    assert regard.nearest_frames(times, np.array([-1.0, 0.04, 0.06, 0.21, 0.5]), 0.06).tolist() == [-1, 0, 1, 2, -1]
    poses = lie.se3_exp(np.array([[0, 0, 0, 0, 0, 0], [0, 0.2, 0, 1, 0, 0], [np.nan] * 6]))
    at = regard.poses_at(times, poses, np.array([0.05, 0.1, 0.15]))
    assert np.allclose(at[0] @ at[0], poses[1])  # half the screw, twice
    assert np.allclose(at[1], poses[1])
    assert np.isnan(at[2, :3]).any()


def test_gaze_outside_the_picture_is_no_ray():
    gaze = Gaze(np.arange(3.0), np.array([[320.0, 240], [-30, 10], [np.nan, 4]]), np.ones(3, bool))
    _, directions, inside = regard.rays_of(gaze, stereo_rig())
    assert inside.tolist() == [True, False, False]
    assert np.allclose(directions[0], [0, 0, 1])


def test_fixations_are_runs_within_the_fovea():
    rng = np.random.default_rng(2)
    times = np.arange(60) / 120
    rays = np.tile([0, 0, 1.0], (60, 1)) + 0.003 * rng.normal(size=(60, 3))
    rays[30:] += [0.2, 0, 0]
    rays[45] = np.nan
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    spans = fixations.find(times, rays, 1.7, 0.1)
    assert spans.tolist() == [[0, 30], [30, 45], [46, 60]]
    points = rng.normal(0, 0.01, (60, 3))
    found = fixations.summarise(spans, points, np.tile(1e-4 * np.eye(3), (60, 1, 1)), common=0.0)
    assert np.trace(found.covariances[0]) == pytest.approx(3e-4 * np.pi / 2 / 30)
    assert found.of_sample[45] == -1
