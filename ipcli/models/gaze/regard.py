"""Points of regard: where a gaze ray meets the scene, with what it is known to (thesis 3.2, steps 1-3).

Depth comes from the scene, never from the eyes' vergence. The uncertainty holds four parts: the error of the gaze
carried over the surface, the error of the surface, its spread around the ray, and the pose of the head.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipcli.geometry import lie
from ipcli.geometry.rig import Rig
from ipcli.measurements.recording import Gaze
from ipcli.models.gaze.parameters import Looking
from ipcli.models.gaze.patch import Plane
from ipcli.models.gaze.surface import Surface

RINGS = np.array([1 / 6, 3 / 6, 5 / 6])  # quantiles of the distance from the middle of a Gaussian in the plane
SPOKES = 8
AGREE = 0.08  # relative difference of depth within which neighbours are of one surface
WINDOW = 2.0  # half the patch that is aligned to the pictures, in sigmas of the gaze
NARROWEST, WIDEST = 7.0, 20.0  # pixels of it
LOCKED = 0.15  # of the error of a dense disparity: what interpolation leaves of it in one that is aligned
LEAST = 0.4  # share of the neighbourhood that must have depth
HIT, NO_DEPTH, LOST, INVALID, OUTSIDE, FAR = "hit", "no depth", "lost", "invalid", "outside", "far"
OUTCOMES = (HIT, NO_DEPTH, LOST, INVALID, OUTSIDE, FAR)


@dataclass(frozen=True, eq=False)
class Regard:
    """A point of regard in the rig's frame of the frame it was seen in."""

    point: np.ndarray  # (3,) metres, NaN unless hit
    covariance: np.ndarray  # (3, 3) metres^2, without the pose
    outcome: str


def pattern() -> np.ndarray:
    """Offsets (25, 2) of a standard normal in the plane: its middle and three rings, of unit variance."""
    radii = np.sqrt(-2 * np.log(1 - RINGS))
    angles = 2 * np.pi * np.arange(SPOKES) / SPOKES
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    points = np.concatenate([radius * ring for radius in radii])
    points = np.concatenate([np.zeros((1, 2)), points])
    return points / np.sqrt(np.square(points).sum() / (2 * len(points)))


def cone(direction: np.ndarray, sigma: float) -> np.ndarray:
    """Unit directions (25, 3) around one, spread by `sigma` radians along each axis."""
    d = direction / np.linalg.norm(direction)
    side = np.cross(d, [0.0, 1.0, 0.0] if abs(d[1]) < 0.9 else [1.0, 0.0, 0.0])
    side /= np.linalg.norm(side)
    offsets = sigma * pattern()
    spread = d + offsets[:, :1] * side + offsets[:, 1:] * np.cross(d, side)
    return spread / np.linalg.norm(spread, axis=1, keepdims=True)


def look(surface: Surface, origin: np.ndarray, direction: np.ndarray, p: Looking) -> Regard:
    """Where a ray (of the rig's frame) meets the surface.

    Depths around the ray that agree with most are taken for a plane. The gaze's error is carried over that plane, and
    over other surfaces as they are: at the rim of an object the region holds both. Along the ray the error is the
    plane's, not a pixel's: from the pictures' noise where the plane could be aligned to them, else `disparity_sigma`.
    It is that of all the places where the gaze may be: a plane's tilt is known less well than its middle.
    """
    rays = cone(direction, np.radians(p.sigma))
    inverse = surface.meet(np.broadcast_to(origin, rays.shape), rays)
    known = np.isfinite(inverse)
    if known.mean() < LEAST:
        return Regard(np.full(3, np.nan), np.full((3, 3), np.nan), NO_DEPTH)
    turn = surface.rectified_from_rig
    o, d = turn @ origin, rays @ turn.T
    with np.errstate(divide="ignore", invalid="ignore"):
        points = o + ((1 / inverse - o[2]) / d[:, 2])[:, None] * d  # in the rectified frame
    middle = float(np.median(inverse[known]))
    agree = known & (np.abs(inverse / middle - 1) < AGREE)
    plane = _plane(surface, points[agree], p)
    length = float((1 - plane.normal @ o) / (plane.normal @ d[0]))
    if not 0 < length < p.farthest:
        return Regard(np.full(3, np.nan), np.full((3, 3), np.nan), FAR)
    point = o + length * d[0]
    flat = o + ((1 - plane.normal @ o) / (d @ plane.normal))[:, None] * d
    off = np.where(agree[:, None], flat, points)[known] - point
    by_plane = flat / (d @ plane.normal)[:, None]  # derivative of each ray's length by the normal, without its sign
    along = np.einsum("ni,ij,nj->n", by_plane, plane.covariance, by_plane)
    covariance = off.T @ off / known.sum() + np.einsum("n,ni,nj->ij", along, d, d) / len(d)
    return Regard(turn.T @ point, turn.T @ covariance @ turn, HIT)


def _plane(surface: Surface, points: np.ndarray, p: Looking) -> Plane:
    """The plane n . X = 1 through points (n, 3) of the rectified frame, where possible aligned to the pictures."""
    ideal = points / points[:, 2:]
    inverse = 1 / points[:, 2]
    normal, *_ = np.linalg.lstsq(ideal, inverse, rcond=1e-6)
    middle = ideal.mean(axis=0)
    reach = max(WINDOW * np.radians(p.sigma) * surface.intrinsics[0, 0], NARROWEST)
    found = surface.plane_around(middle, min(reach, WIDEST), normal, AGREE)
    one = middle / (middle @ middle)  # its product with the middle is 1: all inverse depths there are off alike
    if found is None:
        return Plane(normal, surface.sigma**2 * np.outer(one, one))
    return Plane(found.normal, found.covariance + (LOCKED * surface.sigma) ** 2 * np.outer(one, one))


def in_world(regard: Regard, rig_from_world: np.ndarray, pose_covariance: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The point (3,) and its covariance (3, 3) in the world, the pose's (6, 6) added: X = R^T (x - t)."""
    turn = rig_from_world[:3, :3].T
    point = turn @ (regard.point - rig_from_world[:3, 3])
    by_twist = np.concatenate([turn @ lie.hat(regard.point), -turn], axis=1)
    covariance = turn @ regard.covariance @ turn.T + by_twist @ np.nan_to_num(pose_covariance) @ by_twist.T
    return point, covariance


def rays_of(gaze: Gaze, rig: Rig) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Origins (n, 3), unit directions (n, 3) in the rig's frame, and whether a pixel lies inside the picture (n,)."""
    count = len(gaze.times)
    directions = np.full((count, 3), np.nan)
    inside = ((gaze.pixels >= -0.5) & (gaze.pixels <= rig.sizes[0] - 0.5)).all(axis=1)
    if inside.any():
        rays = rig.rays(0, rig.undistorted(0, gaze.pixels[inside]))
        directions[inside] = rays / np.linalg.norm(rays, axis=1, keepdims=True)
    if gaze.directions is not None:
        given = np.isfinite(gaze.directions).all(axis=1)
        directions[given] = gaze.directions[given]
        inside |= given
    origins = np.zeros((count, 3)) if gaze.origins is None else np.nan_to_num(gaze.origins)
    return origins, directions, inside


def nearest_frames(times: np.ndarray, gaze_times: np.ndarray, gap: float) -> np.ndarray:
    """The frame (n,) nearest in time to each sample, -1 where none is within `gap` s."""
    right = np.clip(np.searchsorted(times, gaze_times), 0, len(times) - 1)
    left = np.maximum(right - 1, 0)
    nearest = np.where(np.abs(times[left] - gaze_times) <= np.abs(times[right] - gaze_times), left, right)
    return np.where(np.abs(times[nearest] - gaze_times) <= gap, nearest, -1)


def poses_at(times: np.ndarray, poses: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Poses (n, 4, 4) between those of the frames around each time, along the screw; NaN next to a lost frame.

    A sample at a frame's own time needs that frame alone.
    """
    right = np.clip(np.searchsorted(times, wanted), 0, len(times) - 1)
    left = np.where(np.isclose(times[right], wanted, atol=1e-6), right, np.maximum(right - 1, 0))
    gap = times[right] - times[left]
    share = np.where(gap > 0, (wanted - times[left]) / np.where(gap > 0, gap, 1.0), 0.0)
    return lie.se3_interpolate(poses[left], poses[right], np.clip(share, 0.0, 1.0))
