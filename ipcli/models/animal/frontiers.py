"""What the outlines of the single parts tell of cameras, without any model.

Two orthographic views share one axis: the normal of the plane of their directions lies in both images. Along it the
whole animal reaches equally far in both (frontier points, see `cameras`), and so does each part that neither view hides
there. A camera has six unknowns; with eight parts two other views give five times as many equations. Ends that are
hidden are wrong by any amount, so that errors are cut off, or weighed as Cauchy does. Two directions alone do not fix
the angle between them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ipcli.geometry.orthographic import Orthographic
from ipcli.measurements.part_images import PartImage
from ipcli.models.animal.cameras import outline_of, shared_by

LEAST = 30  # pixels of a part that has ends
HIDDEN = 0.02  # of the animal's size: ends that differ more are not the same point
LOOSE = (0.01, 0.003)  # the same, where Cauchy's weight is a half: first, and in the end
ROUNDS = 30  # evaluations of all equations and their derivatives, each time
PARALLEL = 1e-3  # sine of the angle between two views that share every axis of their images


@dataclass(frozen=True, eq=False)
class PartOutlines:
    """Convex hulls of the parts that an image shows: points (n, 2) of all, where each begins, and whose they are."""

    points: np.ndarray
    starts: np.ndarray
    parts: np.ndarray

    @classmethod
    def of(cls, image: PartImage) -> PartOutlines:
        """Those of one image's masks; and of its silhouette, as part 0."""
        labels, counts = np.unique(image.labels[image.silhouette], return_counts=True)
        shown = [int(label) for label, count in zip(labels, counts, strict=True) if count >= LEAST]
        outlines = [outline_of(image.silhouette), *(outline_of(image.labels == label) for label in shown)]
        starts = np.cumsum([0, *(len(outline) for outline in outlines[:-1])])
        return cls(np.concatenate(outlines), starts, np.array([0, *shown]))

    def ends(self, axes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Least and largest coordinate (k, parts), in pixels, along axes (k, 2) of the image."""
        along = axes @ self.points.T
        return np.minimum.reduceat(along, self.starts, axis=1), np.maximum.reduceat(along, self.starts, axis=1)


@dataclass(frozen=True, eq=False)
class Frontiers:
    """Outlines of parts in images whose cameras are known."""

    outlines: tuple[PartOutlines, ...]
    cameras: tuple[Orthographic, ...]
    size: float  # of the animal, in the world

    @classmethod
    def of(cls, images: Sequence[PartImage], cameras: Sequence[Orthographic]) -> Frontiers:
        """Those of these images."""
        outlines = tuple(PartOutlines.of(image) for image in images)
        sizes = [np.ptp(o.points, axis=0).max() / c.scale for o, c in zip(outlines, cameras, strict=True)]
        return cls(outlines, tuple(cameras), float(max(sizes)))

    def error(self, own: PartOutlines, rotations: np.ndarray, scales: np.ndarray, shifts: np.ndarray) -> np.ndarray:
        """Mean difference (n,) of the ends of all parts, over the animal's size and at most HIDDEN each, of one more
        image with these cameras: rotations (n, 3, 3), scales (n,), shifts (n, 2).
        """
        total, count = np.zeros(len(rotations)), np.zeros(len(rotations))
        for outlines, camera in zip(self.outlines, self.cameras, strict=True):
            _, mine, theirs = np.intersect1d(own.parts, outlines.parts, return_indices=True)
            for axes, is_told in shared_by(camera.rotation, rotations):
                there = _ends_in_world(own, axes, rotations, scales, shifts)
                here = _ends_in_world(outlines, axes, camera.rotation, camera.scale, camera.shift)
                away = np.abs(there[:, :, mine] - here[:, :, theirs]) / self.size
                total += is_told * np.minimum(away, HIDDEN).mean(axis=(0, 2)) * len(mine)
                count += is_told * len(mine)
        return total / np.maximum(count, 1)


def _ends_in_world(outlines: PartOutlines, axes: np.ndarray, rotation: Any, scale: Any, shift: Any) -> np.ndarray:
    """Both ends (2, k, parts) along world axes (k, 3), of one camera or of k."""
    inplane = (rotation[..., :2, :] @ axes[..., None])[..., 0]
    low, high = outlines.ends(inplane)
    begin = (inplane * shift).sum(axis=-1)
    return (np.stack([low, high]) - begin[:, None]) / np.reshape(scale, (-1, 1))


def adjusted(
    images: Sequence[PartImage], cameras: Sequence[Orthographic], is_free: Sequence[bool]
) -> list[Orthographic]:
    """The cameras after those that are free were moved so that the ends of all parts agree best, in all pairs."""
    from scipy.optimize import least_squares

    outlines = [PartOutlines.of(image) for image in images]
    size = max(float(np.ptp(o.points, axis=0).max()) / c.scale for o, c in zip(outlines, cameras, strict=True))
    free = [k for k, is_one in enumerate(is_free) if is_one]
    pairs = [(i, j) for j in range(len(images)) for i in range(j) if is_free[i] or is_free[j]]

    def moved(vector: np.ndarray) -> list[Orthographic]:
        found = list(cameras)
        for k, (*turn, zoom, right, down) in zip(free, vector.reshape(-1, 6), strict=True):
            extent, old = float(np.ptp(outlines[k].points, axis=0).max()), cameras[k]
            middle = outlines[k].points.mean(axis=0)  # stays where it is while the camera turns
            factor = np.exp(zoom)
            shift = middle + factor * (old.shift - middle) + extent * np.array([right, down])
            found[k] = Orthographic(old.turned(np.array(turn)).rotation, old.scale * factor, shift)
        return found

    def residuals(vector: np.ndarray) -> np.ndarray:
        found = moved(vector)
        return np.concatenate([_difference(outlines[i], outlines[j], found[i], found[j]) for i, j in pairs]) / size

    best = np.zeros(6 * len(free))
    for loose in LOOSE:
        best = least_squares(residuals, best, loss="cauchy", f_scale=loose, max_nfev=ROUNDS, diff_step=1e-5).x
    return moved(best)


def _difference(first: PartOutlines, second: PartOutlines, one: Orthographic, other: Orthographic) -> np.ndarray:
    """How far the ends of the parts that both show are apart along the axis that both views share, (2 parts,)."""
    _, mine, theirs = np.intersect1d(first.parts, second.parts, return_indices=True)
    axis = np.cross(one.direction, other.direction)
    length = float(np.linalg.norm(axis))
    axes = (axis / length if length > PARALLEL else one.rotation[0])[None]
    there = _ends_in_world(first, axes, one.rotation, one.scale, one.shift)[:, 0, mine]
    return (there - _ends_in_world(second, axes, other.rotation, other.scale, other.shift)[:, 0, theirs]).ravel()
