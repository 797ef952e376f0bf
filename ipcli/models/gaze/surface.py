"""The surface before the head in one frame: inverse depth over the pixels of a rectified left camera."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ipcli.geometry import lens, stereo
from ipcli.geometry.rig import Rig
from ipcli.measurements.recording import Frame
from ipcli.models.gaze import patch

MARGIN = 48  # rows above and below the gaze that are matched
WIDEST_SEARCH = 256  # pixels
STEPS = 1.02  # ratio of neighbouring depths along a ray that is followed through the surface


@dataclass(frozen=True, eq=False)
class Surface:
    """Inverse depths (h, w), NaN unknown, of a pinhole camera that shares camera 0's centre."""

    inverse: np.ndarray  # (h, w) 1 / metres
    top: int  # row of the rectified picture that row 0 is
    intrinsics: np.ndarray  # (3, 3)
    rectified_from_rig: np.ndarray  # (3, 3)
    sigma: float  # of an inverse depth, 1 / metres
    pair: tuple[np.ndarray, np.ndarray] | None = None  # (h, w) uint8 each: what was matched
    base: float = np.nan  # pixels * metres: disparity = base * inverse depth

    def meet(self, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Inverse depths (n,) along z where rays of the rig's frame first go through the surface; NaN without.

        From the near end to the far one: the first step at which the surface is no longer behind the ray.
        """
        o, d = origins @ self.rectified_from_rig.T, directions @ self.rectified_from_rig.T
        if np.abs(o).max(initial=0.0) < 1e-9:
            with np.errstate(invalid="ignore", divide="ignore"):
                return self._at(np.where(d[:, 2:] > 1e-3, d / d[:, 2:], np.nan))
        known = self.inverse[np.isfinite(self.inverse)]
        if not known.size:
            return np.full(len(o), np.nan)
        high, low = float(known.max()) * 1.1, max(float(known.min()) * 0.9, 1e-3)
        levels = np.geomspace(high, low, max(int(np.log(high / low) / np.log(STEPS)), 8))
        depth = 1 / levels
        with np.errstate(invalid="ignore", divide="ignore"):
            along = (depth[None] - o[:, 2:]) / np.where(d[:, 2:] > 1e-3, d[:, 2:], np.nan)
        points = o[:, None] + along[..., None] * d[:, None]
        seen = self._at(points / depth[None, :, None])
        crossed = (seen >= levels) & (np.roll(seen, 1, axis=1) < np.roll(levels, 1)) & (np.arange(len(levels)) > 0)
        first = crossed.argmax(axis=1)
        hit = crossed.any(axis=1)
        rows = np.arange(len(o))
        return np.where(hit, seen[rows, first], np.nan)

    def plane_around(self, ideal: np.ndarray, reach: float, start: np.ndarray, agree: float) -> patch.Plane | None:
        """The plane (n . X = 1, rectified frame) around normalised coordinates (3,), aligned to the pictures.

        `reach`: half the patch, pixels. Only pixels whose depth is within `agree` of the plane `start` belong to it.
        """
        if self.pair is None:
            return None
        u, v = np.rint(lens.pixels_of(ideal[:2], self.intrinsics)).astype(int) - [0, self.top]
        half = int(np.ceil(reach))
        rows = np.arange(max(v - half, 0), min(v + half + 1, self.inverse.shape[0]))
        columns = np.arange(max(u - half, 0), min(u + half + 1, self.inverse.shape[1]))
        pixels = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
        flat = lens.normalised_of(pixels + np.array([0.0, self.top]), self.intrinsics)
        rays = np.concatenate([flat, np.ones((len(flat), 1))], axis=1)
        known = self.inverse[pixels[:, 1], pixels[:, 0]]
        mine = np.abs(known / np.where(rays @ start > 0, rays @ start, np.nan) - 1) < agree
        return patch.align(*self.pair, rays[mine], pixels[mine], self.base, start)

    def _at(self, ideal: np.ndarray) -> np.ndarray:
        """Inverse depth at normalised coordinates (..., 3) with z = 1; NaN outside."""
        pixels = lens.pixels_of(ideal[..., :2], self.intrinsics)
        inside = np.isfinite(pixels).all(axis=-1)
        at = np.rint(np.where(inside[..., None], pixels, -1)).astype(int)
        u, v = at[..., 0], at[..., 1] - self.top
        inside &= (u >= 0) & (v >= 0) & (u < self.inverse.shape[1]) & (v < self.inverse.shape[0])
        return np.where(inside, self.inverse[np.where(inside, v, 0), np.where(inside, u, 0)], np.nan)


class Matcher:
    """Dense matching of a rig, its rectifying maps made once."""

    def __init__(self, rig: Rig, sigma: float):
        self.rig, self.sigma = rig, sigma
        width, height = (int(side) for side in rig.sizes[0])
        self.shape = (height, width)
        middle = rig.rectifying()[0][:, 2] if rig.is_stereo else np.array([0.0, 0.0, 1.0])
        shift = rig.focal * middle[:2] / middle[2]
        centre = rig.intrinsics[0, :2, 2] + shift
        self.intrinsics = np.array([[rig.focal, 0, centre[0]], [0, rig.focal, centre[1]], [0, 0, 1.0]])

    @cached_property
    def maps(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """For each camera, where the rectified pixels (h, w) are in its picture."""
        from ipcli.geometry.cameras import rays

        found = []
        for camera, turn in enumerate(self.rig.rectifying()):
            directions = rays(self.shape, self.intrinsics) @ turn
            with np.errstate(divide="ignore", invalid="ignore"):
                ideal = np.where(directions[..., 2:] > 0.05, directions[..., :2] / directions[..., 2:], np.nan)
            k = self.rig.intrinsics[camera]
            offset = np.array([self.rig.offset if camera == 1 else 0.0, 0.0])
            drawn = (
                lens.pixels_of(lens.distort(self.rig.models[camera], self.rig.distortions[camera], ideal), k) + offset
            )
            drawn = np.nan_to_num(drawn, nan=-1e4).astype(np.float32)
            found.append((drawn[..., 0].copy(), drawn[..., 1].copy()))
        return found

    def rows_of(self, directions: np.ndarray) -> tuple[int, int]:
        """First and last row that rays (n, 3) of the rig's frame need, with a margin."""
        turn = self.rig.rectifying()[0] if self.rig.is_stereo else np.eye(3)
        d = directions @ turn.T
        v = self.intrinsics[1, 1] * d[:, 1] / np.maximum(d[:, 2], 0.05) + self.intrinsics[1, 2]
        v = v[np.isfinite(v)]
        height = self.shape[0]
        if not v.size:
            return 0, height
        low, high = int(np.clip(v.min() - MARGIN, 0, height - 1)), int(np.clip(v.max() + MARGIN, 1, height))
        return low, max(high, low + 1)

    def surface(self, frame: Frame, nearest: float, rows: tuple[int, int] | None = None) -> Surface:
        """The surface in these rows; `nearest` (metres) tells how far to search."""
        if frame.right is None:
            return self._measured(frame)
        import cv2

        top, bottom = rows or (0, self.shape[0])
        left, right = (
            cv2.remap(image, u[top:bottom], v[top:bottom], cv2.INTER_LINEAR)
            for image, (u, v) in zip((frame.left, frame.right), self.maps, strict=True)
        )
        base = self.rig.focal * self.rig.baseline
        search = int(np.clip(16 * np.ceil((base / nearest + 8) / 16), 32, WIDEST_SEARCH))
        disparity, _ = stereo.semi_global(left, right, disparities=search, mode="sgbm", consistency=1.0)
        return Surface(
            disparity / base, top, self.intrinsics, self.rig.rectifying()[0], self.sigma / base, (left, right), base
        )

    def _measured(self, frame: Frame) -> Surface:
        """Of a depth camera: what it measured, or nothing."""
        depth = frame.depth if frame.depth is not None else np.full(self.shape, np.nan, np.float32)
        k = self.rig.intrinsics[0]
        with np.errstate(divide="ignore"):
            return Surface(1 / depth, 0, k, np.eye(3), self.sigma / (self.rig.focal * 0.08))
