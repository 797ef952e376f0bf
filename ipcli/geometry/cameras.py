"""Pinhole cameras and the points their depth maps show.

Conventions, the same everywhere in ipcli: the centre of the top left pixel is at (0, 0) (OpenCV), x points right, y
down and z forward; depth is the z coordinate in the camera frame; ``cam_from_world`` maps world points into the camera.
"""

from __future__ import annotations

import numpy as np


def rays(shape: tuple[int, int], intrinsics: np.ndarray, top: int = 0) -> np.ndarray:
    """Directions K^-1 (u, v, 1) of all pixels, (h, w, 3) float64: z is 1, so that depth times ray is the point. Rows
    count from `top`.
    """
    v, u = np.indices(shape, dtype=np.float64)
    v += top
    return np.stack([u, v, np.ones(shape)], axis=-1) @ np.linalg.inv(intrinsics).T


def back_project(depth: np.ndarray, intrinsics: np.ndarray, top: int = 0) -> np.ndarray:
    """Points (h, w, 3) in the camera frame and the unit of ``depth`` (h, w); NaN where the depth is. Rows count from
    `top`.
    """
    return depth[..., None] * rays(depth.shape, intrinsics, top)


def project(points: np.ndarray, intrinsics: np.ndarray) -> np.ndarray:
    """Pixels (u, v) (..., 2) of points (..., 3) in the camera frame; NaN for those not in front of the camera."""
    homogeneous = points @ np.asarray(intrinsics).T
    in_front = np.where(homogeneous[..., 2:] > 0, homogeneous[..., 2:], np.nan)
    return homogeneous[..., :2] / in_front


def transform(dst_from_src: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Points (..., 3) moved by a rigid motion (4, 4)."""
    return points @ dst_from_src[:3, :3].T + dst_from_src[:3, 3]
