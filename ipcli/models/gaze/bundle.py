"""Bundle adjustment of frames and points under a fixed rig (3.8)-(3.9): Levenberg-Marquardt, points eliminated.

One more unknown may be free: an offset of the right camera's principal point, the same in all frames, which is what a
slightly wrong rectification does to depth.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ipcli.geometry import lie
from ipcli.geometry.rig import Rig
from ipcli.kernels import bundle


@dataclass(frozen=True, eq=False)
class BundleProblem:
    """Frames, points, and which camera of which frame saw which point where. Observations in any order."""

    poses: np.ndarray  # (f, 4, 4) rig_from_world
    free: np.ndarray  # (f,) bool: frames that may move
    points: np.ndarray  # (p, 3) metres
    seen: np.ndarray  # (m, 3) int: frame, camera, point
    pixels: np.ndarray  # (m, 2) undistorted
    sigma: np.ndarray  # (m,) pixels
    offset: float = 0.0  # of camera 1's principal point, beyond what the rig says


@dataclass(frozen=True, eq=False)
class Solution:
    """Adjusted poses, points and offset, with the robust cost before and after."""

    poses: np.ndarray
    points: np.ndarray
    offset: float
    costs: tuple[float, float]
    iterations: int
    covariance: np.ndarray | None = None  # (f, 6, 6) of the twists on the left; 0 where held fixed


def solve(
    problem: BundleProblem,
    rig: Rig,
    *,
    loss: float = 1.0,
    iterations: int = 20,
    tolerance: float = 1e-4,
    free_offset: bool = False,
    with_covariance: bool = False,
) -> Solution:
    """Adjust until the cost falls by less than `tolerance` of itself. Fix at least one frame: it holds the gauge."""
    order = np.lexsort((problem.seen[:, 1], problem.seen[:, 0], problem.seen[:, 2]))
    work = replace(problem, seen=problem.seen[order], pixels=problem.pixels[order], sigma=problem.sigma[order])
    system = _System(work, rig, loss, free_offset)
    poses, points, offset = work.poses, work.points, work.offset
    first, damping, used = system.cost(poses, points, offset), 1e-4, 0
    cost = first
    for _ in range(iterations):
        used += 1
        system.fill(poses, points, offset, damping)
        step, moves = system.steps()
        trial = system.moved(poses, step)
        trial_offset = offset + (float(step[-1]) if free_offset else 0.0)
        trial_cost = system.cost(trial, points + moves, trial_offset)
        if trial_cost <= cost:
            gained = cost - trial_cost
            poses, points, offset, cost = trial, points + moves, trial_offset, trial_cost
            damping = max(damping / 10, 1e-9)
            if gained < tolerance * cost:
                break
        else:
            damping *= 10
            if damping > 1e4:
                break
    covariance = system.covariance(poses, points, offset) if with_covariance else None
    return Solution(poses, points, offset, (first, cost), used, covariance)


class _System:
    """The buffers of the reduced system, and the rig as the kernels take it."""

    def __init__(self, problem: BundleProblem, rig: Rig, loss: float, free_offset: bool):
        self.problem, self.loss, self.free_offset = problem, loss, free_offset
        self.rig_rotations, self.rig_translations = (
            np.ascontiguousarray(part) for part in (rig.cam_from_rig[:, :3, :3], rig.cam_from_rig[:, :3, 3])
        )
        self.intrinsics = rig.flat_intrinsics()
        self.seen = np.ascontiguousarray(problem.seen, np.int64)
        self.pixels = np.ascontiguousarray(problem.pixels, np.float64)
        self.scales = 1.0 / problem.sigma
        count = len(problem.points)
        self.starts = np.searchsorted(problem.seen[:, 2], np.arange(count + 1))
        self.columns = np.where(problem.free, np.cumsum(problem.free) - 1, -1)
        size = 6 * int(problem.free.sum()) + 1
        self.matrix, self.vector = np.zeros((size, size)), np.zeros(size)
        self.point_inverse, self.point_gradient = np.zeros((count, 3, 3)), np.zeros((count, 3))
        self.blocks = np.zeros((len(self.seen), 6, 3))
        self.block_columns = np.full(len(self.seen), -1)
        self.by_offset = np.zeros((count, 3))

    def fill(self, poses: np.ndarray, points: np.ndarray, offset: float, damping: float) -> None:
        """Build the reduced system at this point."""
        self.matrix[:] = 0.0
        self.vector[:] = 0.0
        bundle.reduced_system(
            np.ascontiguousarray(poses[:, :3, :3]),
            np.ascontiguousarray(poses[:, :3, 3]),
            self.rig_rotations,
            self.rig_translations,
            self.intrinsics,
            offset,
            points,
            self.seen,
            self.pixels,
            self.scales,
            self.starts,
            self.columns,
            self.loss,
            damping,
            self.free_offset,
            self.matrix,
            self.vector,
            self.point_inverse,
            self.point_gradient,
            self.blocks,
            self.block_columns,
            self.by_offset,
        )
        if not self.free_offset:
            self.matrix[-1, -1] = 1.0

    def steps(self) -> tuple[np.ndarray, np.ndarray]:
        """Steps of the frames (with the offset last) and of the points."""
        step = _solve_upper(self.matrix, self.vector)
        moves = bundle.back_substitute(
            step,
            self.starts,
            self.point_inverse,
            self.point_gradient,
            self.blocks,
            self.block_columns,
            self.by_offset,
            self.free_offset,
        )
        return step, moves

    def moved(self, poses: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Poses after the step."""
        out = poses.copy()
        if len(step) > 1:
            out[self.problem.free] = lie.se3_exp(step[:-1].reshape(-1, 6)) @ poses[self.problem.free]
        return out

    def cost(self, poses: np.ndarray, points: np.ndarray, offset: float) -> float:
        """Cauchy cost; a point behind its camera costs as much as one far off."""
        errors = bundle.residuals(
            np.ascontiguousarray(poses[:, :3, :3]),
            np.ascontiguousarray(poses[:, :3, 3]),
            self.rig_rotations,
            self.rig_translations,
            self.intrinsics,
            offset,
            points,
            self.seen,
            self.pixels,
        )
        squares = np.nan_to_num((errors**2).sum(axis=1), nan=1e8) * self.scales**2
        return float(0.5 * self.loss**2 * np.log1p(squares / self.loss**2).sum())

    def covariance(self, poses: np.ndarray, points: np.ndarray, offset: float) -> np.ndarray:
        """Marginal covariances of the frames, points and offset included; in units of the given sigmas."""
        self.fill(poses, points, offset, 0.0)
        full = np.triu(self.matrix) + np.triu(self.matrix, 1).T
        inverse = np.linalg.pinv(full, hermitian=True) if len(full) < 100 else np.linalg.inv(full)
        out = np.zeros((len(poses), 6, 6))
        for frame, column in enumerate(self.columns):
            if column >= 0:
                out[frame] = inverse[6 * column : 6 * column + 6, 6 * column : 6 * column + 6]
        return out


def _solve_upper(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Cholesky of the upper triangle; with a growing ridge where rounding spoilt it."""
    from scipy.linalg import LinAlgError, cho_factor, cho_solve

    ridge = 0.0
    for _ in range(8):
        try:
            factor = cho_factor(matrix + ridge * np.diag(np.diag(matrix)), lower=False)
            return cho_solve(factor, vector)
        except LinAlgError:
            ridge = max(ridge * 10, 1e-8)
    return np.zeros_like(vector)
