"""Observations looked up at the place where a first fused map says that a view sees a pixel's surface.

Forward projection (4.34) moves every point by its own noise: sideways, so that it lands in a wrong pixel, and into the
company of others, of which the nearest wins. Views that are far apart next to their noise so blur the map and pull it
towards the camera. Here the surface of the first map is projected into each view instead. It is the pixel looked up
there, not its noise, that decides where an observation belongs, and what the pixel says beyond the depth expected is
what the map has to move by.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ipcli import threads
from ipcli.geometry.surface import normals
from ipcli.kernels import reproject as kernels
from ipcli.measurements.views import View, relative
from ipcli.models.fusion.observations import Units
from ipcli.models.fusion.reprojection import Layers

GATE = 4.0  # noise scales: further from the map, a pixel looked up shows another surface, or the map is wrong there
GRAZING = 0.1  # least cosine between a ray with z = 1 and a normal for which the tangent plane is trusted
LARGEST_SHIFT = 0.05  # share of the depth by which the tangent plane may differ within half a pixel


def reassociate(
    depth: np.ndarray, views: Sequence[View], reference: View, forward: Layers, units: Units, *, in_place: bool = False
) -> Layers:
    """Layers (K, h, w) by the surface of a first fused map `depth` (h, w), in place of those of forward projection.

    Where what was looked up is more than GATE noise scales away from the map, or nothing was, the forward projected
    observation stays: it does not rest on the map, and so holds against a map that is wrong, as beside an occlusion. In
    place, the forward projected layers are lost.
    """
    facing = normals(depth, reference.intrinsics)
    layers = forward if in_place else forward.copy()

    def one(k: int) -> None:
        seen, confidence = look_up(views[k], reference, depth, facing, units)
        near = np.isfinite(seen)
        np.copyto(layers.depth[k], seen, where=near)
        if layers.confidence is not None:
            np.copyto(layers.confidence[k], np.float32(1) if confidence is None else confidence, where=near)

    threads.each(one, range(len(views)))
    return layers


def look_up(
    view: View, reference: View, depth: np.ndarray, facing: np.ndarray, units: Units
) -> tuple[np.ndarray, np.ndarray | None]:
    """What a view says of the depth of each pixel of the map (h, w), +inf where nothing, and its given confidence.

    With z the depth expected in the pixel d_k that the surface falls on, of the tangent plane of the map there (so that
    the half pixel to its centre does not count), and q either depth or inverse depth, whichever has homogeneous noise,
    the observation is q(x) + (q(d_k) - q(z)) dq(x) / dq(z), the derivative at a fixed ray of the reference camera. The
    tangent plane is not believed where it is seen at a grazing angle or moves the depth by too much.
    """
    observed, source = np.empty(depth.shape, np.float32), np.zeros(depth.shape, np.intp)
    inverses = np.stack([np.linalg.inv(reference.intrinsics), np.linalg.inv(view.intrinsics)])
    motion, reach = np.ascontiguousarray(relative(view, reference)), GATE * units.scale
    kernels.look_up(
        observed,
        source,
        depth,
        facing,
        view.depth,
        inverses,
        motion,
        view.intrinsics,
        units.inverse,
        reach,
        GRAZING,
        LARGEST_SHIFT,
    )
    return observed, None if view.confidence is None else view.confidence.ravel()[source]
