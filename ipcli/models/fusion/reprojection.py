"""Depth maps of several cameras as observations of one reference camera, eq. (4.34)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ipcli import threads
from ipcli.kernels import reproject as kernels
from ipcli.measurements.views import View, relative


@dataclass(frozen=True, eq=False)
class Layers:
    """What each view says about each pixel of the reference camera."""

    depth: np.ndarray  # (K, h, w) float32, +inf = nothing
    confidence: np.ndarray | None  # (K, h, w) float32, the given confidence of the point that was seen

    def copy(self) -> Layers:
        """The same in other memory."""
        return Layers(self.depth.copy(), None if self.confidence is None else self.confidence.copy())


def reproject(view: View, reference: View) -> tuple[np.ndarray, np.ndarray | None]:
    """Depth (h, w) and given confidence (h, w) of a view, as seen from the reference camera; +inf where nothing lands.

    Every valid pixel goes to the pixel of the reference camera that it is nearest to, and there the nearest surface
    wins. A missing depth projects nowhere (in the thesis' code it became a false near point at the epipole).
    """
    shape = reference.depth.shape
    depth = np.full(shape, np.inf, np.float32)
    source = np.zeros(shape, np.intp)
    motion = relative(reference, view)
    if (
        view.depth.shape == shape
        and np.array_equal(motion, np.eye(4))
        and np.array_equal(view.intrinsics, reference.intrinsics)
    ):
        return np.where(view.depth > 0, view.depth, np.inf).astype(np.float32), view.confidence
    rotation, translation = np.ascontiguousarray(motion[:3, :3]), np.ascontiguousarray(motion[:3, 3])
    kernels.splat(
        depth, source, view.depth, np.linalg.inv(view.intrinsics), rotation, translation, reference.intrinsics
    )
    if view.confidence is None:
        return depth, None
    return depth, np.where(np.isfinite(depth), view.confidence.ravel()[source], 0).astype(np.float32)


def reproject_all(views: Sequence[View], reference: View) -> Layers:
    """All views in the reference camera; a view without given confidence counts as confidence 1 beside others that have
    one.
    """
    depth = np.empty((len(views), *reference.depth.shape), np.float32)

    def one(k: int) -> np.ndarray | None:
        depth[k], confidence = reproject(views[k], reference)
        return confidence

    given = threads.each(one, range(len(views)))
    if all(c is None for c in given):
        return Layers(depth, None)
    return Layers(
        depth,
        np.stack([np.isfinite(d).astype(np.float32) if c is None else c for d, c in zip(depth, given, strict=True)]),
    )
