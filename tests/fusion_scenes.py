"""Small generated scenes for the tests of the fusion: a slanted wall and a ball, cast exactly from cameras side by
side.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from ipcli.geometry.cameras import View, rays
from ipcli.io import h5, sequences

WALL = np.array([0.15, 0.1, 1.0])  # WALL . point = 2.5
BALL, RADIUS = np.array([0.1, 0.05, 1.9]), 0.35


def camera(shape: tuple[int, int], focal: float = 1.0) -> np.ndarray:
    """Intrinsics (3, 3) with the principal point in the middle; focal in image widths."""
    h, w = shape
    return np.array([[focal * w, 0, (w - 1) / 2], [0, focal * w, (h - 1) / 2], [0, 0, 1]])


def pose_at(centre: tuple[float, float, float], turn: float = 0.0) -> np.ndarray:
    """cam_from_world of a camera at a point, turned about the vertical axis (radians)."""
    c, s = np.cos(turn), np.sin(turn)
    pose = np.eye(4)
    pose[:3, :3] = [[c, 0, -s], [0, 1, 0], [s, 0, c]]
    pose[:3, 3] = -pose[:3, :3] @ centre
    return pose


def cast(shape: tuple[int, int], intrinsics: np.ndarray, cam_from_world: np.ndarray) -> np.ndarray:
    """True depth (h, w) float64 of the scene."""
    rotation, origin = cam_from_world[:3, :3], np.linalg.inv(cam_from_world)[:3, 3]
    directions = rays(shape, intrinsics) @ rotation  # in the world; z in the camera is 1
    wall = (2.5 - WALL @ origin) / (directions @ WALL)
    a, b = (directions**2).sum(axis=-1), directions @ (origin - BALL)
    inside = b * b - a * (np.sum((origin - BALL) ** 2) - RADIUS**2)
    return np.where(inside > 0, (-b - np.sqrt(np.maximum(inside, 0))) / a, wall)


def scene(k=5, shape=(60, 80), noise=0.02, holes=0.05, outliers=0.0, seed=1) -> list[View]:
    """k views with Laplace noise, shares of single missing pixels and of outliers, and their truth."""
    views = []
    for i in range(k):
        rng = np.random.default_rng((seed, i))
        pose = pose_at((0.04 * (i - k // 2), 0.01 * (i % 2), 0.0), 0.02 * (i - k // 2))
        truth = cast(shape, camera(shape), pose)
        depth = truth + rng.laplace(0, noise, shape)
        depth[rng.random(shape) < outliers] *= 0.7
        depth[rng.random(shape) < holes] = np.nan
        image = np.full((*shape, 3), 40 * i, np.uint8)
        depth, truth = depth.astype(np.float32), truth.astype(np.float32)
        views.append(View(f"{i:02d}", depth, camera(shape), pose, image=image, truth=truth))
    return views


def scaled(view: View, factor: float) -> View:
    """The same view in another unit of length."""
    pose = view.cam_from_world.copy()
    pose[:3, 3] *= factor
    truth = None if view.truth is None else view.truth * np.float32(factor)
    return replace(view, depth=view.depth * np.float32(factor), cam_from_world=pose, truth=truth)


def write(path: Path, views: list[View], **facts) -> Path:
    """The views as an artefact; not checked, so that broken ones can be written too."""
    given = {"unit": "m", "measured": "depth"} | facts
    h5.write(path, "views", sequences.views_artefact(views, **given), {})
    return path
