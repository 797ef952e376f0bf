"""A calibrated pair of cameras (or one): undistorted pixels, rectifying rotations, depth from disparity, projection.

The rig's frame is camera 0's. Undistorted pixels are those a lens-free camera of the same matrix would have.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipcli.geometry import lens


@dataclass(frozen=True, eq=False)
class Rig:
    """One or two cameras. `offset` (pixels) is how far camera 1's principal point really lies to the right."""

    sizes: np.ndarray  # (c, 2) width, height
    intrinsics: np.ndarray  # (c, 3, 3)
    models: tuple[str, ...]  # of the lenses
    distortions: tuple[np.ndarray, ...]
    cam_from_rig: np.ndarray  # (c, 4, 4)
    offset: float = 0.0

    @property
    def is_stereo(self) -> bool:
        """Whether there are two cameras."""
        return len(self.models) == 2

    @property
    def baseline(self) -> float:
        """Metres between the two cameras."""
        return float(np.linalg.norm(self.cam_from_rig[1, :3, 3])) if self.is_stereo else 0.0

    @property
    def focal(self) -> float:
        """Pixels: of the rectified pictures, and what turns pixels into angles."""
        return float(np.mean(self.intrinsics[:, [0, 1], [0, 1]]))

    def undistorted(self, camera: int, pixels: np.ndarray) -> np.ndarray:
        """Undistorted pixels (n, 2) of those in the picture; NaN where the lens cannot be undone."""
        k = self.intrinsics[camera]
        ideal = lens.undistort(self.models[camera], self.distortions[camera], lens.normalised_of(pixels, k))
        moved = lens.pixels_of(ideal, k)
        return moved - (np.array([self.offset, 0.0]) if camera == 1 else 0.0)

    def distorted(self, camera: int, pixels: np.ndarray) -> np.ndarray:
        """Pixels in the picture of undistorted ones (n, 2)."""
        k = self.intrinsics[camera]
        moved = pixels + (np.array([self.offset, 0.0]) if camera == 1 else 0.0)
        return lens.pixels_of(
            lens.distort(self.models[camera], self.distortions[camera], lens.normalised_of(moved, k)), k
        )

    def rays(self, camera: int, undistorted: np.ndarray) -> np.ndarray:
        """Directions (n, 3) in the camera's frame, z = 1, of undistorted pixels."""
        ideal = lens.normalised_of(undistorted, self.intrinsics[camera])
        return np.concatenate([ideal, np.ones((*ideal.shape[:-1], 1))], axis=-1)

    def rectifying(self) -> np.ndarray:
        """Rotations (2, 3, 3) rectified_from_cam that lay both pictures' rows along the baseline (Fusiello 2000)."""
        right_from_left = self.cam_from_rig[1]
        centre = -right_from_left[:3, :3].T @ right_from_left[:3, 3]  # of the right camera, in the left
        x = centre / np.linalg.norm(centre)
        forward = np.array([0.0, 0.0, 1.0]) + right_from_left[2, :3]  # the mean of both optical axes
        y = np.cross(forward, x)
        y /= np.linalg.norm(y)
        left = np.stack([x, y, np.cross(x, y)])
        return np.stack([left, left @ right_from_left[:3, :3].T])

    def rectified(self, camera: int, undistorted: np.ndarray) -> np.ndarray:
        """Rectified pixels (n, 2) around a principal point at 0, 0; NaN behind."""
        turned = self.rays(camera, undistorted) @ self.rectifying()[camera].T
        z = np.where(turned[..., 2:] > 1e-3, turned[..., 2:], np.nan)
        return self.focal * turned[..., :2] / z

    def triangulated(self, left: np.ndarray, right: np.ndarray) -> np.ndarray:
        """Points (n, 3) in the rig's frame of rectified pixels of both cameras; NaN for no positive disparity."""
        disparity = left[..., 0] - right[..., 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            z = np.where(disparity > 0, self.focal * self.baseline / disparity, np.nan)
        middle = np.stack([left[..., 0], (left[..., 1] + right[..., 1]) / 2, np.full_like(z, self.focal)], axis=-1)
        return (z / self.focal)[..., None] * middle @ self.rectifying()[0]

    def project(self, camera: int, points: np.ndarray) -> np.ndarray:
        """Undistorted pixels (..., 2) of points (..., 3) in the rig's frame; NaN behind the camera."""
        pose, k = self.cam_from_rig[camera], self.intrinsics[camera]
        seen = points @ pose[:3, :3].T + pose[:3, 3]
        with np.errstate(invalid="ignore", divide="ignore"):
            return lens.pixels_of(seen[..., :2] / np.where(seen[..., 2:] > 1e-6, seen[..., 2:], np.nan), k)

    def flat_intrinsics(self) -> np.ndarray:
        """(c, 4): fx, fy, cx, cy, as the kernels take them."""
        return np.ascontiguousarray(self.intrinsics[:, [0, 1, 0, 1], [0, 1, 2, 2]])
