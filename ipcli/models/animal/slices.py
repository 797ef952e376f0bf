"""Where an aspect lies along its view and how thick it is, told by the outline of its part in a view that leans to it.

The planes that hold both directions of view (epipolar planes) cut a part into slices. The first view tells how far a
slice reaches across, and the other where it ends seen from beside: at a contour, where background lies beyond. Between
views that are not at right angles the visual hull of a slice is a parallelogram that leans along the other view, up to
twice as long as the animal, and its middle says nothing of the part's. So the aspect is taken as upright in its own
view, and is moved and made thicker until each slice ends where the outline does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ipcli.geometry.orthographic import Orthographic
from ipcli.measurements.part_images import PartImage, pixels_of

BEYOND = 2.0  # pixels beyond the end of a mask at which there is background where the end is a contour
FACTORS = np.geomspace(0.25, 2.5, 24)  # thickness over the aspect's own, between which that of a slice is interpolated
AS_LIFTED = 4  # slices that count as if they had the aspect's own thickness: few slices hardly tell another
ENOUGH = 3  # slices that end at a contour: with fewer, ends at other parts count too
SMOOTH = 2.0  # slices: deviation of the Gaussian along the depths


@dataclass(frozen=True, eq=False)
class Slices:
    """Slices of a part, each `width` wide along `axis` (3,), the k-th about (first + k) * width, all in world units.

    `seen` (2, n) are the lower and upper end of each in the other view, NaN of none, `is_contour` (2, n) whether
    background lies beyond, and `lifted` (factors, 2, n) the ends of the aspect at depth 0, for each of FACTORS. `lean`
    is the sine of the angle between the views: how far an end moves with the depth.
    """

    axis: np.ndarray
    first: int
    width: float
    lean: float
    seen: np.ndarray
    is_contour: np.ndarray
    lifted: np.ndarray

    @classmethod
    def of(
        cls,
        heights: np.ndarray,
        camera: Orthographic,
        part: int,
        image: PartImage,
        beside: Orthographic,
        width: float,
    ) -> Slices:
        """Those of an aspect with heights (h, w), in pixels of its camera, and of the part in an image from beside."""
        normal = np.cross(camera.direction, beside.direction)
        lean = float(np.linalg.norm(normal))
        axis = normal / lean
        across = np.cross(axis, beside.direction)
        aspect, mask = pixels_of(heights > 0), pixels_of(image.mask(part))
        height = heights[heights > 0] / camera.scale
        here, there = camera.lift(aspect.astype(np.float64), 0.0), beside.lift(mask.astype(np.float64), 0.0)
        own, its = (np.round(points @ axis / width).astype(int) for points in (here, there))
        first = int(min(own.min(), its.min()))
        count = int(max(own.max(), its.max())) - first + 1
        lifted = [_ends(own - first, here @ across, factor * lean * height, count) for factor in FACTORS]
        seen = _ends(its - first, there @ across, np.zeros(len(there)), count)
        step = BEYOND * beside.rotation[:2] @ across
        is_contour = _contours(image.silhouette, mask, its - first, there @ across, step, count)
        return cls(axis, first, width, lean, seen, is_contour, np.array(lifted))

    def ratios(self) -> np.ndarray:
        """How much thicker than its aspect the part is, in each slice both of whose ends are contours."""
        wide, asked = self.lifted[:, 1] - self.lifted[:, 0], self.seen[1] - self.seen[0]
        both = np.flatnonzero(self.is_contour.all(axis=0) & np.isfinite(wide[0]))
        return np.array([np.interp(asked[k], wide[:, k], FACTORS) for k in both])

    def depths(self, factor: float) -> np.ndarray | None:
        """The depth (n,) of the aspect's middle in each slice, made thicker by a factor; None if no slice tells it."""
        from scipy.ndimage import distance_transform_edt, gaussian_filter1d

        at = np.interp(factor, FACTORS, np.arange(len(FACTORS)))
        low = int(min(at, len(FACTORS) - 2))
        lifted = self.lifted[low] + (at - low) * (self.lifted[low + 1] - self.lifted[low])
        moved = (lifted - self.seen) / self.lean
        is_told = np.isfinite(moved)
        if (is_told & self.is_contour).any(axis=0).sum() >= ENOUGH:
            is_told &= self.is_contour
        known = is_told.any(axis=0)
        if not known.any():
            return None
        mean = np.where(is_told, moved, 0.0).sum(axis=0) / np.maximum(is_told.sum(axis=0), 1)
        weight = gaussian_filter1d(known.astype(np.float64), SMOOTH)
        smooth = gaussian_filter1d(mean, SMOOTH) / np.maximum(weight, 1e-9)
        return smooth[distance_transform_edt(~known, return_distances=False, return_indices=True)[0]]

    def number(self, points: np.ndarray) -> np.ndarray:
        """The slice that is nearest to each coordinate along the axis."""
        return np.clip(np.round(points / self.width).astype(int) - self.first, 0, self.seen.shape[1] - 1)


def fitted(ratios: Sequence[float]) -> float:
    """One factor from the ratios of slices."""
    return float(np.median([*ratios, *[1.0] * AS_LIFTED]))


def _ends(number: np.ndarray, at: np.ndarray, reach: np.ndarray, count: int) -> np.ndarray:
    """Least at - reach and largest at + reach (2, count) of points (m,) in each slice."""
    ends = np.full((2, count), np.nan)
    np.fmin.at(ends[0], number, at - reach)
    np.fmax.at(ends[1], number, at + reach)
    return ends


def _contours(
    silhouette: np.ndarray, pixels: np.ndarray, number: np.ndarray, at: np.ndarray, step: np.ndarray, count: int
) -> np.ndarray:
    """Whether (2, count) the first and the last pixel (m, 2) of each slice have background a `step` (2,) beyond."""
    is_contour = np.zeros((2, count), bool)
    shown = np.pad(silhouette, 1)
    order = np.lexsort((at, number))
    sliced = number[order]
    for side, sign in enumerate((-1, 1)):
        last = np.unique(sliced[::-sign], return_index=True)[1]
        beyond = pixels[order[::-sign][last]] + sign * step
        column, row = np.clip(np.rint(beyond).astype(int) + 1, 0, np.array(shown.shape[::-1]) - 1).T
        is_contour[side, np.unique(sliced)] = ~shown[row, column]
    return is_contour
