"""Bundle adjustment: recovery of a generated scene, derivatives, the gauge, the offset, agreement with pycolmap."""

import numpy as np
import pytest

from ipcli.geometry import lie
from ipcli.models.gaze import bundle
from tests.fixtures.gaze_rig import stereo_rig


def scene(rng, frames=8, points=120, noise=0.0, offset=0.0, spread=0.3):
    """A problem at its solution: poses on a path, points before them, what both cameras see."""
    rig = stereo_rig()
    twists = np.concatenate([rng.normal(0, 0.05, (frames, 3)), rng.normal(0, spread, (frames, 3))], axis=1)
    poses = lie.se3_exp(twists)
    poses[0] = np.eye(4)
    world = rng.uniform([-2, -1.5, 2], [2, 1.5, 8], (points, 3))
    seen, pixels = [], []
    for f in range(frames):
        for c in range(2):
            uv = rig.project(c, world @ poses[f, :3, :3].T + poses[f, :3, 3])
            uv[:, 0] += offset * (c == 1)
            inside = ((uv > 0) & (uv < [640, 480])).all(axis=1)
            ids = np.flatnonzero(inside)
            seen.append(np.stack([np.full(len(ids), f), np.full(len(ids), c), ids], axis=1))
            pixels.append(uv[ids] + rng.normal(0, noise, (len(ids), 2)))
    free = np.ones(frames, bool)
    free[0] = False
    seen, pixels = np.concatenate(seen), np.concatenate(pixels)
    return rig, bundle.BundleProblem(poses, free, world, seen, pixels, np.ones(len(seen)))


def shaken(rng, problem, by=0.01):
    twists = rng.normal(0, by, (len(problem.poses), 6)) * problem.free[:, None]
    return bundle.BundleProblem(
        lie.se3_exp(twists) @ problem.poses, problem.free, problem.points + rng.normal(0, 5 * by, problem.points.shape),
        problem.seen, problem.pixels, problem.sigma,
    )  # fmt: skip


def test_recovers_the_generated_scene_to_rounding():
    rng = np.random.default_rng(1)
    rig, true = scene(rng)
    found = bundle.solve(shaken(rng, true), rig, iterations=50, tolerance=1e-14)
    assert found.costs[1] < 1e-12
    assert np.abs(found.poses - true.poses).max() < 1e-7
    seen_twice = np.bincount(true.seen[:, 2], minlength=len(true.points)) > 2
    assert np.abs(found.points - true.points)[seen_twice].max() < 1e-5


def test_fixed_frames_do_not_move():
    rng = np.random.default_rng(2)
    rig, true = scene(rng, noise=0.3)
    start = shaken(rng, true)
    start.free[[0, 3]] = False
    found = bundle.solve(start, rig)
    assert (found.poses[[0, 3]] == start.poses[[0, 3]]).all()


def test_recovers_an_offset_of_the_right_camera():
    rng = np.random.default_rng(3)
    rig, true = scene(rng, frames=12, offset=0.4, noise=0.1)
    found = bundle.solve(shaken(rng, true), rig, iterations=50, tolerance=1e-10, free_offset=True)
    assert found.offset == pytest.approx(0.4, abs=0.05)
