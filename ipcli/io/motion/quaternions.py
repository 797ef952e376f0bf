"""Rotations as they are stored: quaternions x, y, z, w."""

from __future__ import annotations

import numpy as np


def quaternions(rotations: np.ndarray) -> np.ndarray:
    """Rotations (..., 3, 3) as float32 quaternions (..., 4), x, y, z, w with w >= 0; NaN where a rotation has NaN."""
    from scipy.spatial.transform import Rotation

    flat = rotations.reshape(-1, 3, 3)
    known = np.isfinite(flat).all(axis=(1, 2))
    found = np.full((len(flat), 4), np.nan, np.float32)
    if known.any():
        found[known] = Rotation.from_matrix(flat[known], assume_valid=True).as_quat(canonical=True)
    return found.reshape(*rotations.shape[:-2], 4)


def matrices(quaternions: np.ndarray) -> np.ndarray:
    """Quaternions (..., 4), x, y, z, w of any length, as rotations (..., 3, 3) float64; NaN stays."""
    q = quaternions.astype(np.float64)
    x, y, z, w = np.moveaxis(q / np.linalg.norm(q, axis=-1, keepdims=True), -1, 0)
    rows = (
        (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
        (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
        (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
    )
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
