"""Fused depth maps of several cameras as one cloud: what enough of them agree on, averaged.

A pixel of one map is a point; another map confirms it, looks through it, or has something before it and cannot tell. What is
confirmed moves to the mean of the surfaces that confirm it, and the points within a cell of a grid become one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ipcli.errors import NoSolution, ParameterError
from ipcli.geometry.cameras import back_project, project, transform
from ipcli.kernels import threads
from ipcli.models.fusion.observations import MAD_TO_SIGMA, SMALLEST_NOISE
from ipcli.models.fusion.parameters import Merge

GRAZING = 0.1  # cosine between ray and normal below which a plane through a pixel says nothing about the next one
CELLS = 1 << 20  # along an axis, so that three indices fit into one integer


@dataclass(frozen=True, eq=False)
class FusedMap:
    """A fused map as the merge needs it; NaN depth where nothing was observed."""

    depth: np.ndarray  # (h, w) float32
    confidence: np.ndarray  # (h, w) float32
    observations: np.ndarray  # (h, w) uint16
    normals: np.ndarray  # (h, w, 3) float32, camera frame
    noise: np.ndarray  # (h, w) float32, scale of the noise of one observation, in the unit of depth
    intrinsics: np.ndarray
    cam_from_world: np.ndarray
    image: np.ndarray | None = None

    @cached_property
    def usable(self) -> np.ndarray:
        """Pixels (h, w) that are points of a surface."""
        known = np.isfinite(self.depth) & np.isfinite(self.normals).all(axis=-1)
        return known & (self.observations > 0) & (self.confidence > 0)

    @cached_property
    def points(self) -> np.ndarray:
        """(h * w, 3) float64 in the camera frame."""
        return back_project(self.depth, self.intrinsics).reshape(-1, 3)

    @cached_property
    def precision(self) -> np.ndarray:
        """(h * w,) float64: sum over the observations of the inverse square of their noise, which the confidence divides."""
        return (self.observations * (self.confidence / self.noise.astype(np.float64)) ** 2).ravel()

    @cached_property
    def looks_at(self) -> np.ndarray:
        """The camera's centre and the point half way into its picture (2, 3), in the world."""
        ahead = (0, 0, float(np.median(self.depth[self.usable]))) if self.usable.any() else (0, 0, 0)
        return transform(np.linalg.inv(self.cam_from_world), np.array([(0, 0, 0), ahead], np.float64))


@dataclass(frozen=True, eq=False)
class Points:
    """Points in the frame of one camera; arrays of one length."""

    position: np.ndarray  # (n, 3) float64
    normal: np.ndarray  # (n, 3) float64
    color: np.ndarray | None  # (n, 3)
    precision: np.ndarray  # (n,) float64
    confidence: np.ndarray  # (n,) float64
    views: np.ndarray  # (n,) number of maps that agree


@dataclass(frozen=True, eq=False)
class Cloud:
    """The merged points in world coordinates, and for each map (points, confirmed, contradicted)."""

    points: Points
    spacing: float
    counts: np.ndarray  # (m, 3) int64


def depth_noise(depth: np.ndarray, residuals: np.ndarray, *, inverse: bool) -> np.ndarray:
    """Noise (h, w) of one observation in depth, from the median residual (k,) of each view; it grows with the square of the
    depth where it is homogeneous in the inverse."""
    scale = MAD_TO_SIGMA * float(np.nanmedian(residuals)) if np.isfinite(residuals).any() else 0.0
    shape = np.square(depth / np.nanmedian(depth)) if inverse else np.ones_like(depth)
    return np.maximum(scale * shape, SMALLEST_NOISE * depth).astype(np.float32)


def merge(maps: Sequence[FusedMap], settings: Merge) -> Cloud:
    """One cloud of the maps. The grid is fixed to the first camera, so that the choice of the world does not matter.

    Raises NoSolution if nothing is confirmed by enough maps, ParameterError for a spacing too fine for the extent.
    """
    order = range(len(maps))
    found = threads.each(lambda i: confirmed(maps[i], neighbours(maps, i, settings.neighbours), settings), order)
    counts = np.array([count for _, count in found], np.int64)
    if not counts[:, 1].any():
        raise NoSolution(
            f"none of the {counts[:, 0].sum()} points is seen alike by {settings.agree} of the {len(maps) - 1} other maps: "
            "check that the maps overlap, or lower --agree or raise --tolerance"
        )
    spacing = settings.spacing or footprint(maps, [points for points, _ in found])
    first = maps[0].cam_from_world
    joined = _joined([_moved(points, first @ np.linalg.inv(m.cam_from_world)) for (points, _), m in zip(found, maps, strict=True)])
    return Cloud(_moved(on_grid(joined, spacing), np.linalg.inv(first)), spacing, counts)


def neighbours(maps: Sequence[FusedMap], index: int, most: int) -> list[FusedMap]:
    """The other maps whose cameras are near this one and look at a place near to its."""
    apart = [float(np.linalg.norm(m.looks_at - maps[index].looks_at, axis=1).sum()) for m in maps]
    nearest = np.argsort(apart, kind="stable")
    return [maps[i] for i in nearest[nearest != index][:most]]


def confirmed(own: FusedMap, others: Sequence[FusedMap], settings: Merge) -> tuple[Points, tuple[int, int, int]]:
    """The points of a map that enough others confirm, and no fewer than look through them; how many there were, are, and
    were contradicted."""
    pixels = np.flatnonzero(own.usable)
    points, normals = own.points[pixels], own.normals.reshape(-1, 3)[pixels].astype(np.float64)
    precision, confidence = own.precision[pixels], own.confidence.ravel()[pixels].astype(np.float64)
    total = precision[:, None] * points
    agreed, against = np.zeros(len(pixels), np.uint16), np.zeros(len(pixels), np.uint16)
    for other in others:
        who, where, pixel, through = sight(own, other, points, normals, settings)
        total[who] += other.precision[pixel, None] * where
        precision[who] += other.precision[pixel]
        confidence[who] += other.confidence.ravel()[pixel]
        agreed[who] += 1
        against[through] += 1
    enough, contradicted = agreed >= settings.agree, against > agreed
    keep = enough & ~contradicted
    color = None if own.image is None else own.image.reshape(-1, 3)[pixels[keep]]
    mean = total[keep] / precision[keep, None]
    kept = Points(mean, normals[keep], color, precision[keep], confidence[keep], agreed[keep] + 1)
    return kept, (len(pixels), int(keep.sum()), int(contradicted.sum()))


def sight(
    own: FusedMap, other: FusedMap, points: np.ndarray, normals: np.ndarray, settings: Merge
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """What another map says about points (n, 3) with normals (n, 3) in the frame of a camera.

    Indices (a,) of the points it confirms, where it sees them (a, 3), in which of its pixels (a,); indices (b,) of those it
    looks through. Its surface is taken as a plane at each pixel, so that rounding to pixels costs no depth on slanted walls.
    """
    motion = other.cam_from_world @ np.linalg.inv(own.cam_from_world)
    moved = transform(motion, points)
    index, pixel = _landing(other, moved)
    seen, facing = moved[index], normals[index] @ motion[:3, :3].T
    plane = other.normals.reshape(-1, 3)[pixel].astype(np.float64)
    rays, at = seen / seen[:, 2:], other.points[pixel]
    along = _dot(plane, rays)
    slanted = np.abs(along) > GRAZING * np.linalg.norm(rays, axis=1)
    depth = np.where(slanted, _dot(plane, at) / np.where(slanted, along, 1), at[:, 2])
    limit = np.maximum(settings.tolerance * other.noise.ravel()[pixel], settings.relative * at[:, 2])
    apart = seen[:, 2] - depth
    agrees = (np.abs(apart) <= limit) & (_dot(plane, facing) >= np.cos(np.radians(settings.angle)))
    where = transform(np.linalg.inv(motion), depth[agrees, None] * rays[agrees])
    return index[agrees], where, pixel[agrees], index[apart < -limit]


def _landing(view: FusedMap, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Indices of the points (n, 3), in the view's frame, that fall on a usable pixel, and those flat pixels."""
    h, w = view.depth.shape
    place = np.rint(project(points, view.intrinsics))
    index = np.flatnonzero(((place >= 0) & (place < (w, h))).all(axis=1))  # NaN, behind the camera, is not inside
    column, row = place[index].astype(np.intp).T
    hit = view.usable[row, column]
    return index[hit], (row * w + column)[hit]


def footprint(maps: Sequence[FusedMap], found: Sequence[Points]) -> float:
    """Median side of a pixel on the surface, were it seen from the front."""
    sides = [points.position[:, 2] / np.sqrt(m.intrinsics[0, 0] * m.intrinsics[1, 1]) for m, points in zip(maps, found, strict=True)]
    return float(np.median(np.concatenate(sides)))


def on_grid(points: Points, spacing: float) -> Points:
    """One point a cell: means weighted by precision of position, normal, colour; mean of the confidences, most of the views.

    Each point holds the confidences of all maps that agree on it already, so that they are not summed once more here.
    """
    cells = np.floor(points.position / spacing)
    cells -= cells.min(axis=0)
    if cells.max() >= CELLS:
        raise ParameterError(f"merge.spacing: {spacing:g} divides the cloud into more than {CELLS} cells along an axis; give more")
    key = cells.astype(np.int64) @ np.array([CELLS * CELLS, CELLS, 1])
    order = np.argsort(key, kind="stable")
    starts = np.flatnonzero(np.diff(key[order], prepend=-1))
    weight = points.precision[order]
    total = np.add.reduceat(weight, starts)

    def mean(values: np.ndarray) -> np.ndarray:
        weighted = (values[order].T * weight).T
        return (np.add.reduceat(weighted, starts, axis=0).T / total).T

    normal = mean(points.normal)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    normal = np.where(length > GRAZING, normal / np.maximum(length, GRAZING), points.normal[order][starts])
    color = None if points.color is None else np.rint(mean(points.color.astype(np.float64))).astype(np.uint8)
    views = np.maximum.reduceat(points.views[order], starts)
    return Points(mean(points.position), normal, color, total, mean(points.confidence), views)


def _moved(points: Points, motion: np.ndarray) -> Points:
    position, normal = transform(motion, points.position), points.normal @ motion[:3, :3].T
    return Points(position, normal, points.color, points.precision, points.confidence, points.views)


def _joined(parts: Sequence[Points]) -> Points:
    """All points; colours only if all have them."""

    def all_of(name: str) -> np.ndarray:
        return np.concatenate([getattr(part, name) for part in parts])

    color = all_of("color") if all(part.color is not None for part in parts) else None
    return Points(all_of("position"), all_of("normal"), color, all_of("precision"), all_of("confidence"), all_of("views"))


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("ni,ni->n", a, b)
