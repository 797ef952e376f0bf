"""Fused depth maps of several cameras as one cloud: what enough of them agree on, averaged.

A pixel of one map is a point; another map confirms it, looks through it, or has something before it and cannot tell.
What is confirmed moves to the mean of the surfaces that confirm it, and the points within a cell of a grid become one.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ipcli import threads
from ipcli.errors import NoSolution
from ipcli.geometry.cameras import back_project, transform
from ipcli.kernels import agreement
from ipcli.models.fusion.cells import Cells, SurfacePoints
from ipcli.models.fusion.observations import MAD_TO_SIGMA, SMALLEST_NOISE
from ipcli.models.fusion.parameters import Merge

GRAZING = 0.1  # cosine between ray and normal below which a plane through a pixel says nothing about the next one


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
    def surface(self) -> np.ndarray:
        """The depth (h, w) of pixels that are points of a surface, NaN elsewhere."""
        usable = np.isfinite(self.normals).all(axis=-1) & (self.observations > 0) & (self.confidence > 0)
        return np.where(usable, self.depth, np.float32(np.nan))

    def precision(self) -> np.ndarray:
        """(h, w) float64: sum over the observations of the inverse square of their noise, which the confidence
        divides.
        """
        return self.observations * (self.confidence / self.noise.astype(np.float64)) ** 2


@dataclass(frozen=True, eq=False)
class Glance:
    """What has to be known of every map before the first is merged."""

    cam_from_world: np.ndarray
    looks_at: np.ndarray  # (2, 3) the camera's centre and the point half way into its picture, in the world
    side: float  # median side of a pixel on the surface, were it seen from the front; NaN without a surface

    @classmethod
    def at(cls, own: FusedMap) -> Glance:
        """Of a map."""
        depth = own.surface[np.isfinite(own.surface)]
        middle = float(np.median(depth)) if depth.size else np.nan
        looks_at = transform(np.linalg.inv(own.cam_from_world), np.array([(0, 0, 0), (0, 0, np.nan_to_num(middle))]))
        return cls(own.cam_from_world, looks_at, middle / float(np.sqrt(own.intrinsics[0, 0] * own.intrinsics[1, 1])))


@dataclass(frozen=True, eq=False)
class Cloud:
    """The merged points in world coordinates, and for each map (points, confirmed, contradicted) and how far away it
    sees the surface.
    """

    points: SurfacePoints
    spacing: float
    cam_from_world: np.ndarray  # (m, 4, 4) of the maps
    counts: np.ndarray  # (m, 3) int64
    depths: np.ndarray  # (m,) float64, the median depth of each; 0 without a surface


def depth_noise(depth: np.ndarray, residuals: np.ndarray, *, inverse: bool) -> np.ndarray:
    """Noise (h, w) of one observation in depth, from the median residual (k,) of each view; it grows with the square of
    the depth where it is homogeneous in the inverse.
    """
    scale = MAD_TO_SIGMA * float(np.nanmedian(residuals)) if np.isfinite(residuals).any() else 0.0
    shape = np.square(depth / np.nanmedian(depth)) if inverse else np.ones_like(depth)
    return np.maximum(scale * shape, SMALLEST_NOISE * depth).astype(np.float32)


def merge(maps: Sequence[FusedMap], settings: Merge, most: int | None = None) -> Cloud:
    """One cloud of the maps. The grid is fixed to the first camera, so that the choice of the world does not matter.

    A map is taken from the sequence whenever it is asked, so that one that reads them anew bounds the memory: a map and
    one that it asks a thread, and the points of the cloud.

    Raises NoSolution if nothing is confirmed by enough maps, ParameterError for a spacing too fine for the extent or
    for a cloud of `most` points.
    """
    if len(maps) <= settings.agree:
        raise NoSolution(
            f"{len(maps)} maps, and a point must be seen alike by {settings.agree} others: give more, or lower --agree"
        )
    order = range(len(maps))
    glances = threads.each(lambda i: Glance.at(maps[i]), order)
    sides = [glance.side for glance in glances if np.isfinite(glance.side)]
    spacing = settings.spacing or (float(np.median(sides)) if sides else 1.0)
    places, first = np.stack([glance.looks_at for glance in glances]), glances[0].cam_from_world

    def found(i: int) -> tuple[SurfacePoints, tuple[int, int, int]]:
        others = (maps[k] for k in neighbours(places, i, settings.neighbours))
        points, count = confirmed(maps[i], others, settings)
        return points.transform(first @ np.linalg.inv(glances[i].cam_from_world)), count

    cells, counts, at_once = Cells(spacing, most), [], threads.count()
    for start in range(0, len(maps), at_once):
        for points, count in threads.each(found, order[start : start + at_once]):
            cells.add(points)
            counts.append(count)
    if not any(kept for _, kept, _ in counts):
        raise NoSolution(
            f"none of the {sum(number for number, _, _ in counts)} points is seen alike by {settings.agree} of the "
            f"{len(maps) - 1} other maps: check that the maps overlap, or lower --agree or raise --tolerance"
        )
    poses = np.stack([glance.cam_from_world for glance in glances])
    depths = np.linalg.norm(places[:, 1] - places[:, 0], axis=1)
    return Cloud(cells.points().transform(np.linalg.inv(first)), spacing, poses, np.array(counts, np.int64), depths)


def neighbours(places: np.ndarray, index: int, most: int) -> list[int]:
    """The other maps whose cameras are near this one and look at a place near to its; places (m, 2, 3) are their
    `looks_at`.
    """
    apart = np.linalg.norm(places - places[index], axis=2).sum(axis=1)
    nearest = np.argsort(apart, kind="stable")
    return nearest[nearest != index][:most].tolist()


def confirmed(own: FusedMap, others: Iterable[FusedMap], settings: Merge) -> tuple[SurfacePoints, tuple[int, int, int]]:
    """The points of a map that enough others confirm, and no fewer than look through them, in its camera's frame; how
    many there were, are, and were contradicted.
    """
    depth, precision = own.surface, own.precision()
    sums = np.concatenate(
        [precision[..., None] * back_project(depth, own.intrinsics), precision[..., None], own.confidence[..., None]],
        axis=2,
    )
    votes = np.zeros((*depth.shape, 2), np.uint16)
    limits = (settings.tolerance, settings.relative, float(np.cos(np.radians(settings.angle))), GRAZING)
    rays, from_world = np.linalg.inv(own.intrinsics), np.linalg.inv(own.cam_from_world)
    for other in others:
        asked = (other.surface, other.normals, other.noise, other.confidence, other.observations)
        camera = (np.linalg.inv(other.intrinsics), other.intrinsics)
        agreement.ask(sums, votes, depth, own.normals, rays, other.cam_from_world @ from_world, *asked, *camera, limits)
    agreed, against = votes[..., 0], votes[..., 1]
    known, contradicted = np.isfinite(depth), against > agreed
    keep = known & (agreed >= settings.agree) & ~contradicted
    total = sums[keep]
    color = None if own.image is None else own.image[keep]
    points = SurfacePoints(
        total[:, :3] / total[:, 3:4],
        own.normals[keep].astype(np.float64),
        color,
        total[:, 3],
        total[:, 4],
        agreed[keep] + 1,
    )
    return points, (int(known.sum()), int(keep.sum()), int((known & contradicted).sum()))
