"""Orthographic cameras with a scale, and the views of an animal that have a name.

World axes are those of the animal: x forward, y to its left, z up. Camera axes: x right and y down in the image, z
along the view direction. A world point X falls on the pixel (column, row) = scale * (R X)[:2] + shift.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

NAMED = {  # rows: right, down and the direction of view, in world axes
    "left": ((-1, 0, 0), (0, 0, -1), (0, -1, 0)),
    "right": ((1, 0, 0), (0, 0, -1), (0, 1, 0)),
    "front": ((0, 1, 0), (0, 0, -1), (-1, 0, 0)),
    "back": ((0, -1, 0), (0, 0, -1), (1, 0, 0)),
    "top": ((0, -1, 0), (-1, 0, 0), (0, 0, -1)),
    "bottom": ((0, 1, 0), (-1, 0, 0), (0, 0, 1)),
}


@dataclass(frozen=True, eq=False)
class Orthographic:
    """A camera: rotation (3, 3) cam_from_world, scale in pixels a unit of the world, shift (2,) in pixels."""

    rotation: np.ndarray
    scale: float
    shift: np.ndarray

    def project(self, points: np.ndarray) -> np.ndarray:
        """Pixels (..., 2) as (column, row) of world points (..., 3)."""
        return self.scale * (points @ self.rotation[:2].T) + self.shift

    def pixel(self, points: np.ndarray, shape: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray]:
        """Row and column (...) of the pixel of an image (h, w) that is nearest to each of world points (..., 3)."""
        at = np.rint(self.project(points)).astype(int)
        return np.clip(at[..., 1], 0, shape[0] - 1), np.clip(at[..., 0], 0, shape[1] - 1)

    def depth(self, points: np.ndarray) -> np.ndarray:
        """Depth (...) of world points (..., 3) along the direction of view, in units of the world."""
        return points @ self.rotation[2]

    def lift(self, pixels: np.ndarray, depth: np.ndarray | float) -> np.ndarray:
        """World points (..., 3) of pixels (..., 2) at a depth (...), or one depth for all."""
        inplane = (pixels - self.shift) / self.scale
        along = np.broadcast_to(depth, inplane.shape[:-1])[..., None]
        return np.concatenate([inplane, along], axis=-1) @ self.rotation

    @property
    def direction(self) -> np.ndarray:
        """Where the camera looks (3,), in the world."""
        return self.rotation[2]

    def turned(self, vector: np.ndarray) -> Orthographic:
        """The camera after a small rotation (3,), radians about its own axes."""
        from scipy.spatial.transform import Rotation

        return replace(self, rotation=Rotation.from_rotvec(vector).as_matrix() @ self.rotation)


def of_view(view: str) -> np.ndarray:
    """Rotation (3, 3) of a view of NAMED, or of one `by_angles`."""
    if view in NAMED:
        return np.array(NAMED[view], np.float64)
    azimuth, elevation = map(float, view.split(","))
    return looking(azimuth, elevation)


def by_angles(azimuth: float, elevation: float) -> str:
    """The word for a view from these angles in degrees, as `looking` takes them: one word for one view, the name where
    it has one. ValueError for angles that are none of a camera.
    """
    if not (-360 <= azimuth <= 360 and -90 <= elevation <= 90):
        raise ValueError("an azimuth outside -360 to 360, or an elevation outside -90 to 90 degrees")
    rotation = looking(azimuth, elevation)
    for name, rows in NAMED.items():
        if np.allclose(rotation, rows, atol=1e-6):
            return name
    return f"{azimuth % 360:g},{elevation:g}"


def looking(azimuth: float, elevation: float, roll: float = 0.0) -> np.ndarray:
    """Rotation (3, 3) of a camera that stands at an azimuth (degrees; 0 in front of the animal, 90 to its left) and an
    elevation above the ground, upright but for a roll about the direction of view.
    """
    a, e, r = np.radians([azimuth, elevation, roll])
    forward = -np.array([np.cos(a) * np.cos(e), np.sin(a) * np.cos(e), np.sin(e)])
    right = np.array([-np.sin(a), np.cos(a), 0.0])
    down = np.cross(forward, right)
    c, s = np.cos(r), np.sin(r)
    return np.stack([c * right + s * down, -s * right + c * down, forward])


def fibonacci(count: int) -> np.ndarray:
    """Directions (count, 3), evenly over the sphere."""
    k = np.arange(count) + 0.5
    z = 1 - 2 * k / count
    turn = np.pi * (1 + 5**0.5) * k
    radius = np.sqrt(1 - z * z)
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), z], axis=1)


def angle_between(a: np.ndarray, b: np.ndarray) -> float:
    """Degrees of the rotation from one rotation matrix (3, 3) to another."""
    return float(np.degrees(np.arccos(np.clip((np.trace(a @ b.T) - 1) / 2, -1, 1))))
