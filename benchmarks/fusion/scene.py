"""A generated scene for benchmarks: two walls, a floor and three balls, cast from an arc of cameras, with bad
sensors.
"""

from __future__ import annotations

import numpy as np

from ipcli.measurements.views import View
from ipcli.rng import stream

PLANES = np.array(
    [[0.12, 0.0, 1.0, 3.2], [-1.0, 0.0, 0.35, 2.3], [0.0, 1.0, 0.1, 1.1]]
)  # normal . point = offset, seen from below it
BALLS = np.array([[-0.55, 0.35, 2.1, 0.45], [0.35, 0.55, 1.7, 0.25], [0.6, -0.25, 2.5, 0.4]])  # centre, radius
LAPLACE = 0.03  # metres
HOLES = 6  # a view
SINGLE = 0.03  # share of the pixels that are missing one by one
ROWS = 64  # cast at a time, so that large images need little memory beyond themselves


def views(count: int, shape: tuple[int, int], seed: int = 0) -> list[View]:
    """Views of one scene with their truth; the middle one is the reference. The same numbers in every run of a seed."""
    return [view(index, count, shape, seed) for index in range(count)]


def view(index: int, count: int, shape: tuple[int, int], seed: int = 0) -> View:
    """One of `count` views, spread evenly over the same arc whatever their number."""
    intrinsics, pose = camera(shape), pose_at(2 * index / max(count - 1, 1) - 1)
    truth = cast(shape, intrinsics, pose)
    depth = observed(truth, stream(seed, "benchmarks", f"{index}"))
    return View(f"{index:03d}", depth, intrinsics, pose, truth=truth)


def camera(shape: tuple[int, int]) -> np.ndarray:
    """Intrinsics (3, 3) of a camera with the same field of view at every size."""
    h, w = shape
    return np.array([[0.9 * w, 0, (w - 1) / 2], [0, 0.9 * w, (h - 1) / 2], [0, 0, 1]])


def pose_at(place: float) -> np.ndarray:
    """cam_from_world on the arc; place in [-1, 1]."""
    turn = 0.08 * place
    c, s = np.cos(turn), np.sin(turn)
    pose = np.eye(4)
    pose[:3, :3] = [[c, 0, -s], [0, 1, 0], [s, 0, c]]
    pose[:3, 3] = -pose[:3, :3] @ [0.2 * place, 0.02 * place, 0.0]
    return pose


def cast(shape: tuple[int, int], intrinsics: np.ndarray, cam_from_world: np.ndarray) -> np.ndarray:
    """True depth (h, w) float32."""
    h, w = shape
    depth = np.empty(shape, np.float32)
    to_world = cam_from_world[:3, :3].T @ np.linalg.inv(intrinsics)
    origin = np.linalg.inv(cam_from_world)[:3, 3]
    for top in range(0, h, ROWS):
        v, u = np.mgrid[top : min(top + ROWS, h), :w].astype(np.float64)
        depth[top : top + ROWS] = _nearest(origin, np.stack([u, v, np.ones_like(u)], axis=-1) @ to_world.T)
    return depth


def _nearest(origin: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Depth of the first surface along rays (..., 3) whose z in the camera is 1."""
    depth = np.full(directions.shape[:-1], np.inf)
    for *normal, offset in PLANES:
        slope = directions @ normal
        with np.errstate(divide="ignore"):
            np.fmin(depth, np.where(slope > 0, (offset - origin @ normal) / slope, np.inf), out=depth)
    for *centre, radius in BALLS:
        a, b = (directions**2).sum(axis=-1), directions @ (origin - centre)
        inside = b * b - a * (((origin - centre) ** 2).sum() - radius**2)
        np.fmin(depth, np.where(inside > 0, (-b - np.sqrt(np.maximum(inside, 0))) / a, np.inf), out=depth)
    return depth


def observed(truth: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """The truth with Laplace noise, elliptic holes and single missing pixels (NaN), float32."""
    h, w = truth.shape
    noise = rng.random(truth.shape, np.float32) - np.float32(0.5)
    missing = rng.random(truth.shape, np.float32) < SINGLE
    # Laplace by inversion: the generator has no float32 one, and at 12 Mpx that counts
    size = np.log1p(-np.minimum(2 * np.abs(noise), np.float32(1 - 1e-6)))
    depth = truth - np.float32(LAPLACE) * np.sign(noise) * size
    for _ in range(HOLES):
        row, column, tall, wide = rng.uniform((0, 0, h / 60, w / 60), (h, w, h / 12, w / 12))
        rows, columns = _span(row, tall, h), _span(column, wide, w)
        v, u = np.mgrid[rows, columns]
        missing[rows, columns] |= ((v - row) / tall) ** 2 + ((u - column) / wide) ** 2 < 1
    depth[missing | (depth <= 0)] = np.nan
    return depth


def _span(centre: float, reach: float, size: int) -> slice:
    return slice(max(int(centre - reach), 0), min(int(centre + reach) + 2, size))
