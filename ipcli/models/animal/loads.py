"""The external force that lifts a mask into a surface: (6.4) as printed, and the forms that round better.

F is the distance to the rim (6.1) and h the distance to the nearest point of the medial axis plus its radius (6.2); the
minimum in (6.2b) is over the argument. As printed, F / h is smallest at the rim and gives a flatter rim than a constant
load does, against the text; h / F grows there and gives an almost circular section. A load that does not know the size
lifts the membrane as the square of the radius: `steep` divides by the medial radius.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ipcli.models.animal.parameters import Inflation

LEAST_F = 0.5  # pixels: h / F is not looked at nearer to the rim


@dataclass(frozen=True, eq=False)
class Medial:
    """What a mask (h, w) knows of its medial axis, in pixels."""

    rim: np.ndarray  # F: distance to the rim
    through: np.ndarray  # h: distance to the nearest point of the axis + the radius there
    radius: np.ndarray  # radius at that point
    convex: np.ndarray  # bool: the rim is convex at its nearest point


def medial(mask: np.ndarray) -> Medial:
    """Distances (6.1), (6.2) of all pixels of a mask, extended by the nearest to those outside."""
    from scipy.ndimage import distance_transform_edt
    from skimage.morphology import medial_axis

    padded = np.pad(mask, 2)
    axis, distance = medial_axis(padded, return_distance=True, rng=0)
    to_axis, nearest = distance_transform_edt(~axis, return_indices=True)
    radius = distance[tuple(nearest)]
    fields = (distance, to_axis + radius, radius, convexity(padded))
    rim, through, radius, convex = (field[2:-2, 2:-2] for field in fields)
    return Medial(rim, through, radius, convex)


def convexity(mask: np.ndarray) -> np.ndarray:
    """Whether the rim is convex at the rim pixel nearest to each pixel (h, w) bool: delta_1 of (6.4).

    Convex is where less than half of a small disc around a rim pixel lies in the mask.
    """
    from scipy.ndimage import binary_erosion, distance_transform_edt, gaussian_filter

    rim = mask & ~binary_erosion(mask)
    share = gaussian_filter(mask.astype(np.float64), 3.0)
    nearest = distance_transform_edt(~rim, return_distances=False, return_indices=True)
    return share[tuple(nearest)] < 0.5


def load(mask: np.ndarray, params: Inflation) -> Callable[[np.ndarray], np.ndarray]:
    """The load G at points (2, ...) of (column, row), for a stretching of 1, in pixels."""
    if params.load == "sqrt-poisson":
        return lambda x: np.full(x.shape[1:], 2.0)
    if params.load == "constant":
        return lambda x: np.full(x.shape[1:], params.gain)
    about = medial(mask)
    concave = params.gain if params.concave_gain is None else params.concave_gain
    gamma = np.where(about.convex, params.gain, concave)
    if params.load == "printed":
        values = gamma * about.rim / np.maximum(about.through, LEAST_F)
    else:
        values = gamma * about.through / np.maximum(about.rim, LEAST_F) / np.maximum(about.radius, LEAST_F)
    return _sampled(values)


def _sampled(values: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    from scipy.ndimage import map_coordinates

    def at(x: np.ndarray) -> np.ndarray:
        return map_coordinates(values, (x[1].ravel(), x[0].ravel()), order=1, mode="nearest").reshape(x.shape[1:])

    return at
