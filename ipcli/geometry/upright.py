"""Worlds whose vertical is another axis, turned by whole axes so that y points up."""

from __future__ import annotations

import numpy as np

Y_UP_FROM = {
    "y": np.eye(3),
    "z": np.roll(np.eye(3), 1, axis=1),
    "x": np.roll(np.eye(3), -1, axis=1),
    "-y": np.diag([1.0, -1.0, -1.0]),
    "-z": np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]),
    "-x": np.array([[0, 1.0, 0], [-1, 0, 0], [0, 0, 1]]),
}  # rotations (3, 3) by the axis that points up


def upright(vectors: np.ndarray, up: str) -> np.ndarray:
    """Vectors (..., 3) of a world in which `up` points up, in one where y does; those of y up as they are."""
    return vectors if up == "y" else vectors @ Y_UP_FROM[up].T
