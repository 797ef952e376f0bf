"""Pose of the rig from map points seen by its cameras: RANSAC, Levenberg-Marquardt on SE(3), covariance (3.2)-(3.4).

`rig_from_world` maps map points into the rig's frame. The thesis' (3.2) writes R (X + t), its step 3 R x + t: two
different t; here only the second form is used. With a metric rig the scale s of (3.2) is 1.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ipcli.geometry import lie
from ipcli.geometry.rig import Rig
from ipcli.kernels import consensus
from ipcli.models.gaze.parameters import Tracking

CHUNK = 32  # samples between two looks at how many more are needed
CONFIDENCE = 0.9999
FIORE = 6  # points of its minimal sample


@dataclass(frozen=True, eq=False)
class Sightings:
    """Map points seen in a frame: undistorted pixels, NaN in a camera that does not see one."""

    points: np.ndarray  # (n, 3) metres in the world
    left: np.ndarray  # (n, 2)
    right: np.ndarray  # (n, 2)
    sigma: np.ndarray  # (n,) pixels

    def __getitem__(self, chosen) -> Sightings:
        return Sightings(self.points[chosen], self.left[chosen], self.right[chosen], self.sigma[chosen])


@dataclass(frozen=True, eq=False)
class Pose:
    """A pose with what it rests on. The covariance is of the twist (omega, v) on the left of `rig_from_world`."""

    rig_from_world: np.ndarray  # (4, 4)
    covariance: np.ndarray  # (6, 6)
    inliers: np.ndarray  # (n,) bool, of the sightings
    error: float  # root mean square of the inliers' residuals, pixels


def residuals(rig: Rig, pose: np.ndarray, seen: Sightings) -> np.ndarray:
    """Predicted minus seen pixels (n, 4): left u, v, right u, v; NaN where not seen, infinite behind a camera."""
    inside = seen.points @ pose[:3, :3].T + pose[:3, 3]
    parts = []
    for camera, pixels in enumerate((seen.left, seen.right)[: len(rig.models)]):
        error = rig.project(camera, inside) - pixels
        behind = np.isnan(error) & np.isfinite(pixels)
        parts.append(np.where(behind, np.inf, error))
    if len(parts) == 1:
        parts.append(np.full_like(parts[0], np.nan))
    return np.concatenate(parts, axis=1)


def stereo_error(errors: np.ndarray) -> np.ndarray:
    """(3.3): squared reprojection error of both cameras, the mean over those that see the point; (n,) pixels^2."""
    squares = errors**2
    counts = np.isfinite(errors[:, ::2]) | np.isinf(errors[:, ::2])
    return np.nansum(squares, axis=1) / np.maximum(counts.sum(axis=1), 1)


def ransac(rig: Rig, seen: Sightings, p: Tracking, rng: np.random.Generator) -> np.ndarray | None:
    """The hypothesis (4, 4) with the best truncated error (3.3) over both cameras (MSAC); None without any."""
    count, size = len(seen.points), 3 if p.pose == "p3p" else FIORE
    solve: Callable = _p3p if p.pose == "p3p" else _fiore
    if count < max(size + 1, 4):
        return None
    rays = rig.rays(0, seen.left)
    cameras = len(rig.models)
    pixels = np.stack([seen.left, seen.right][:cameras])
    best, best_cost, needed, tried = None, np.inf, p.samples, 0
    while tried < needed:
        tried += CHUNK
        samples = [rng.choice(count, size, replace=False) for _ in range(CHUNK)]
        poses = solve(seen.points, rays, samples)
        if not len(poses):
            continue
        costs, fitting = consensus.msac(
            poses, rig.cam_from_rig, rig.flat_intrinsics(), seen.points, pixels, p.error**2
        )  # fmt: skip
        first = int(costs.argmin())
        if costs[first] < best_cost:
            best, best_cost = poses[first], float(costs[first])
            needed = min(p.samples, _needed(float(fitting[first]) / count, size))
    return best


def _needed(share: float, size: int) -> int:
    """Samples for one of inliers alone with probability `CONFIDENCE`."""
    good = min(max(share**size, 1e-9), 1 - 1e-9)
    return int(np.ceil(np.log(1 - CONFIDENCE) / np.log(1 - good)))


def _p3p(points: np.ndarray, rays: np.ndarray, samples: list[np.ndarray]) -> np.ndarray:
    """Poses (m, 4, 4) of all samples of three."""
    import cv2

    turns: list[np.ndarray] = []
    moves: list[np.ndarray] = []
    for sample in samples:
        try:
            _, turn, move = cv2.solveP3P(
                points[sample], rays[sample, None, :2].copy(), np.eye(3), None, cv2.SOLVEPNP_AP3P
            )
        except cv2.error:
            continue
        turns += turn
        moves += move
    poses = np.tile(np.eye(4), (len(turns), 1, 1))
    if turns:
        poses[:, :3, :3] = lie.exp(np.array(turns).reshape(-1, 3))
        poses[:, :3, 3] = np.array(moves).reshape(-1, 3)
    return poses[np.isfinite(poses).all(axis=(1, 2))]


def _fiore(points: np.ndarray, rays: np.ndarray, samples: list[np.ndarray]) -> np.ndarray:
    """Poses (m, 4, 4) of all samples of six."""
    return np.array([found for sample in samples for found in fiore(points[sample], rays[sample])]).reshape(-1, 4, 4)


def fiore(points: np.ndarray, rays: np.ndarray) -> list[np.ndarray]:
    """Fiore's linear exterior orientation (2001) of n >= 6 points (n, 3) and rays (n, 3) with z = 1.

    The depths Z solve (V2^T kron I)(rays * Z) = 0, where V2 spans the null space of the homogeneous points; then
    absolute orientation. The scale s of (3.2) is divided out.
    """
    homogeneous = np.vstack([points.T, np.ones(len(points))])
    null = np.linalg.svd(homogeneous)[2][4:]
    if not len(null):
        return []
    system = np.concatenate([null * rays[:, axis] for axis in range(3)])
    depths = np.linalg.svd(system)[2][-1]
    depths = depths * np.sign(depths.sum())
    if not (depths > 0).all():
        return []
    seen = rays * depths[:, None]
    return [absolute_orientation(points, seen)]


def absolute_orientation(points: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Rigid (4, 4) that carries points onto seen / s with the best scale s (Umeyama 1991), metric in `points`."""
    a, b = points - points.mean(axis=0), seen - seen.mean(axis=0)
    u, _, vt = np.linalg.svd(b.T @ a)
    turn = u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt
    scale = np.trace(turn.T @ b.T @ a) / max(np.square(a).sum(), 1e-300)
    pose = np.eye(4)
    pose[:3, :3] = turn
    pose[:3, 3] = seen.mean(axis=0) / scale - turn @ points.mean(axis=0)
    return pose


def refine(rig: Rig, pose: np.ndarray, seen: Sightings, *, cut: float, loss: float = 2.0, iterations: int = 12) -> Pose:
    """Levenberg-Marquardt on SE(3) of (3.4) with a Cauchy loss (`loss` sigmas), then inliers within `cut` pixels.

    The covariance is that of the least squares of the inliers, scaled by their robust residual.
    """
    damping, cost = 1e-4, np.inf
    errors, jacobian = _linearised(rig, pose, seen)
    cost = _robust_cost(errors, loss)
    for _ in range(iterations):
        weights = 1 / (1 + np.square(errors).sum(axis=1) / loss**2)
        hessian = np.einsum("n,nai,naj->ij", weights, jacobian, jacobian)
        gradient = np.einsum("n,nai,na->i", weights, jacobian, errors)
        step = np.linalg.solve(hessian + damping * np.diag(np.diag(hessian)) + 1e-12 * np.eye(6), -gradient)
        trial = lie.se3_exp(step) @ pose
        trial_errors, trial_jacobian = _linearised(rig, trial, seen)
        trial_cost = _robust_cost(trial_errors, loss)
        if trial_cost < cost:
            done = cost - trial_cost < 1e-5 * cost
            pose, errors, jacobian, cost, damping = trial, trial_errors, trial_jacobian, trial_cost, damping / 5
            if done:
                break
        else:
            damping *= 10
            if damping > 1e6:
                break
    return _judged(rig, pose, seen, jacobian, cut)


def _judged(rig: Rig, pose: np.ndarray, seen: Sightings, jacobian: np.ndarray, cut: float) -> Pose:
    """Inliers, their error, and the covariance of the pose."""
    raw = residuals(rig, pose, seen)
    inliers = stereo_error(raw) < cut**2
    values = raw[inliers]
    values = values[np.isfinite(values)]
    if len(values) < 7:
        return Pose(pose, np.full((6, 6), np.nan), np.zeros(len(seen.points), bool), np.nan)
    scaled = (raw / seen.sigma[:, None])[inliers]
    variance = np.nansum(scaled**2) / (np.isfinite(scaled).sum() - 6)
    hessian = np.einsum("nai,naj->ij", jacobian[inliers], jacobian[inliers])
    covariance = variance * np.linalg.pinv(hessian, hermitian=True)
    return Pose(pose, covariance, inliers, float(np.sqrt(np.mean(values**2))))


def _robust_cost(errors: np.ndarray, loss: float) -> float:
    return float(np.log1p(np.square(errors).sum(axis=1) / loss**2).sum())


def _linearised(rig: Rig, pose: np.ndarray, seen: Sightings) -> tuple[np.ndarray, np.ndarray]:
    """Residuals (n, 4) in sigmas and their derivatives (n, 4, 6) by a twist on the left; 0 where not seen."""
    inside = seen.points @ pose[:3, :3].T + pose[:3, 3]
    errors, jacobian = np.zeros((len(inside), 4)), np.zeros((len(inside), 4, 6))
    for camera, pixels in enumerate((seen.left, seen.right)[: len(rig.models)]):
        cam, k = rig.cam_from_rig[camera], rig.intrinsics[camera]
        x, y, z = (inside @ cam[:3, :3].T + cam[:3, 3]).T
        known = np.isfinite(pixels).all(axis=1) & (z > 1e-6)
        z = np.where(known, z, 1.0)
        scale = np.where(known, 1 / seen.sigma, 0.0)
        for row, (focal, along, centre) in enumerate(((k[0, 0], x, k[0, 2]), (k[1, 1], y, k[1, 2]))):
            predicted = focal * along / z + centre
            errors[:, 2 * camera + row] = np.where(known, (predicted - pixels[:, row]) * scale, 0.0)
            slope = (focal * scale / z)[:, None] * (cam[row, :3] - (along / z)[:, None] * cam[2, :3])
            jacobian[:, 2 * camera + row, 3:] = slope
            jacobian[:, 2 * camera + row, :3] = np.cross(inside, slope)
    return errors, jacobian
