"""The reduced system of bundle adjustment against the whole one, put together densely from numerical derivatives."""

from __future__ import annotations

import numpy as np
import pytest

from ipcli.geometry import lie
from ipcli.kernels import bundle

FRAMES, POINTS, LOSS = 4, 9, 2.0
COLUMNS = np.array([-1, 0, -1, 1])


@pytest.fixture
def case():
    """Poses, a rig of two cameras, points before them, and measured pixels some pixels off; each seen by some."""
    rng = np.random.default_rng(4)
    poses = lie.se3_exp(np.hstack([rng.normal(0, 0.1, (FRAMES, 3)), rng.normal(0, 0.3, (FRAMES, 3))]))
    cameras = lie.se3_exp(np.array([[0, 0, 0, 0, 0, 0], [0.02, -0.03, 0.01, -0.2, 0.01, 0.02]]))
    intrinsics = np.array([[400.0, 410, 320, 240], [390.0, 395, 310, 250]])
    points = rng.uniform([-1, -1, 3], [1, 1, 6], (POINTS, 3))
    seen = np.array(
        [
            (f, c, p)
            for p in range(POINTS)
            for f in range(FRAMES)
            for c in range(2)
            if (f + c + p) % 3 or f == p % FRAMES
        ],
        np.int64,
    )
    scales = rng.uniform(0.5, 2, len(seen))
    pixels = projected(poses, cameras, intrinsics, 0.3, points, seen) + rng.normal(0, 3, (len(seen), 2))
    return poses, cameras, intrinsics, points, seen, pixels, scales


def projected(poses, cameras, intrinsics, offset, points, seen):
    """Pixels (m, 2) by homogeneous coordinates, one observation after the other."""
    found = []
    for f, c, p in seen:
        x, y, z, _ = cameras[c] @ poses[f] @ np.append(points[p], 1)
        fx, fy, cx, cy = intrinsics[c]
        found.append((fx * x / z + cx + offset * c, fy * y / z + cy))
    return np.array(found)


def parts(matrices):
    return np.ascontiguousarray(matrices[:, :3, :3]), np.ascontiguousarray(matrices[:, :3, 3])


def test_residuals_are_predicted_minus_measured(case):
    poses, cameras, intrinsics, points, seen, pixels, _ = case
    found = bundle.residuals(*parts(poses), *parts(cameras), intrinsics, 0.3, points, seen, pixels)
    np.testing.assert_allclose(found, projected(poses, cameras, intrinsics, 0.3, points, seen) - pixels, atol=1e-10)


def test_a_point_behind_its_camera_has_no_residual(case):
    poses, cameras, intrinsics, points, seen, pixels, _ = case
    points[2, 2] = -5
    found = bundle.residuals(*parts(poses), *parts(cameras), intrinsics, 0.0, points, seen, pixels)
    np.testing.assert_array_equal(np.isnan(found).all(axis=1), seen[:, 2] == 2)


def whole_step(case, offset, damping, with_offset):
    """Steps of the free frames, of the offset and of the points by the dense damped normal equations; and the cost."""
    poses, cameras, intrinsics, points, seen, pixels, scales = case
    free = int((COLUMNS >= 0).sum())

    def errors(x):
        twists = np.zeros((FRAMES, 6))
        twists[COLUMNS >= 0] = x[: 6 * free].reshape(-1, 6)
        moved = lie.se3_exp(twists) @ poses
        shifted = points + x[6 * free + 1 :].reshape(-1, 3)
        found = projected(moved, cameras, intrinsics, offset + x[6 * free], shifted, seen)
        return ((found - pixels) * scales[:, None]).ravel()

    size, step = 6 * free + 1 + 3 * POINTS, 1e-6
    zero = np.zeros(size)
    jacobian = np.stack([(errors(zero + d) - errors(zero - d)) / (2 * step) for d in step * np.eye(size)], axis=1)
    error = errors(zero)
    square = (error.reshape(-1, 2) ** 2).sum(axis=1) / LOSS**2
    weight = np.repeat(1 / (1 + square), 2)
    hessian, gradient = (jacobian.T * weight) @ jacobian, -(jacobian.T * weight) @ error
    hessian[np.diag_indices(size)] *= 1 + damping
    kept = np.arange(size) != (6 * free if not with_offset else -1)
    solution = np.zeros(size)
    solution[kept] = np.linalg.solve(hessian[np.ix_(kept, kept)], gradient[kept])
    return solution, 0.5 * LOSS**2 * np.log1p(square).sum()


@pytest.mark.parametrize("with_offset", [False, True])
@pytest.mark.parametrize("damping", [1e-3, 0.5])
def test_the_reduced_step_is_that_of_the_whole_system(case, with_offset, damping):
    poses, cameras, intrinsics, points, seen, pixels, scales = case
    size = 6 * int((COLUMNS >= 0).sum()) + 1
    starts = np.searchsorted(seen[:, 2], np.arange(POINTS + 1))
    matrix, vector = np.zeros((size, size)), np.zeros(size)
    inverse, gradient, by_offset = np.zeros((POINTS, 3, 3)), np.zeros((POINTS, 3)), np.zeros((POINTS, 3))
    blocks, block_columns = np.zeros((len(seen), 6, 3)), np.full(len(seen), -1)
    kept = (inverse, gradient, blocks, block_columns, by_offset)
    cost = bundle.reduced_system(
        *parts(poses), *parts(cameras), intrinsics, 0.1, points, seen, pixels, scales, starts, COLUMNS, LOSS, damping,
        with_offset, matrix, vector, *kept,
    )  # fmt: skip
    if not with_offset:
        matrix[-1, -1] = 1
    step = np.linalg.solve(np.triu(matrix) + np.triu(matrix, 1).T, vector)
    moves = bundle.back_substitute(step, starts, *kept, with_offset)
    expected, expected_cost = whole_step(case, 0.1, damping, with_offset)
    assert cost == pytest.approx(expected_cost, rel=1e-12)
    np.testing.assert_allclose(np.concatenate([step, moves.ravel()]), expected, rtol=1e-5, atol=1e-7)
