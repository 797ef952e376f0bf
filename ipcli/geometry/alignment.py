"""How far a path is from the truth once both are laid over each other: absolute trajectory error."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Fit:
    """dst_from_src: rotation, translation and scale, with the errors that remain."""

    rotation: np.ndarray  # (3, 3)
    translation: np.ndarray  # (3,)
    scale: float
    errors: np.ndarray  # (n,) distances after alignment, NaN where one of the two is unknown

    @property
    def rmse(self) -> float:
        """Root mean square of the errors."""
        return float(np.sqrt(np.nanmean(self.errors**2))) if np.isfinite(self.errors).any() else float("nan")

    @property
    def matrix(self) -> np.ndarray:
        """(4, 4) similarity."""
        out = np.eye(4)
        out[:3, :3], out[:3, 3] = self.scale * self.rotation, self.translation
        return out


def align(src: np.ndarray, dst: np.ndarray, *, with_scale: bool) -> Fit:
    """Least squares of dst - (s R src + t) over points (n, 3) (Umeyama 1991); NaN rows are left out."""
    known = np.isfinite(src).all(axis=1) & np.isfinite(dst).all(axis=1)
    a, b = src[known], dst[known]
    if len(a) < 3:
        return Fit(np.eye(3), np.zeros(3), 1.0, np.full(len(src), np.nan))
    centre_a, centre_b = a.mean(axis=0), b.mean(axis=0)
    u, s, vt = np.linalg.svd((b - centre_b).T @ (a - centre_a))
    sign = np.array([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    rotation = u @ np.diag(sign) @ vt
    spread = np.square(a - centre_a).sum()
    scale = float((s * sign).sum() / spread) if with_scale and spread > 0 else 1.0
    translation = centre_b - scale * rotation @ centre_a
    errors = np.full(len(src), np.nan)
    errors[known] = np.linalg.norm(scale * a @ rotation.T + translation - b, axis=1)
    return Fit(rotation, translation, scale, errors)


def path_extent(poses: np.ndarray) -> tuple[float, float]:
    """How long a path of poses (k, 4, 4) is and how far it gets from its first one; NaN poses are passed over.

    The length holds the errors of all poses, so that of one that stands still grows with their number.
    """
    places = poses[np.isfinite(poses).all(axis=(1, 2)), :3, 3]
    if not len(places):
        return 0.0, 0.0
    steps, off = np.diff(places, axis=0), places - places[0]
    return float(np.linalg.norm(steps, axis=1).sum()), float(np.linalg.norm(off, axis=1).max())
