"""What stands where the views support nothing: holes that no view sees, and pixels whose views the map does not follow.

The regulariser in-paints both smoothly, from all sides. A hole that is wide is mostly what something nearer hides: what
stands there is the background, and the KITTI benchmark fills it so, along the rows. Here too, unless that lies so far
behind what was in-painted that the row has met something else altogether.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ipcli.geometry.surface import normals
from ipcli.inverse.regularize.fidelity import Observations

ROWS = 256  # that are filled at once
SEEN, UNSEEN, UNBELIEVED = 0, 1, 2  # codes of `filled`: an observation supports the map, none is there, or none does


def support(x: np.ndarray, data: Observations, believed: float) -> np.ndarray:
    """SEEN, UNSEEN or UNBELIEVED (h, w) uint8, of an image x (h, w) and its observations, both in noise scales: SEEN
    where one lies within `believed`.
    """
    nearest = np.full_like(x, np.inf)
    for layer in np.moveaxis(data.stack, 1, 0):
        np.fmin(nearest, np.abs(x - layer), out=nearest)
    return np.where(data.count == 0, UNSEEN, np.where(nearest <= believed, SEEN, UNBELIEVED)).astype(np.uint8)


def fill_holes(depth: np.ndarray, filled: np.ndarray, reach: float, *, inverse: bool) -> np.ndarray:
    """A regularised depth map (h, w) with the background where it has no `support` (h, w).

    Both are compared in depth, or in its inverse if `inverse`; a background more than `reach` behind is not taken. What
    is SEEN stays as it is, and so does NaN.
    """
    nearness = 1 / depth if inverse else -depth  # smaller is farther
    hole = filled != SEEN
    painted, nearness[hole] = nearness[hole], np.nan
    behind = interpolate_background(nearness)[hole]
    background = 1 / behind if inverse else -behind
    out = depth.astype(np.float32)
    out[hole] = np.where(painted - behind <= reach, background, depth[hole])
    return out


def normals_of_filled(own: np.ndarray, depth: np.ndarray, filled: np.ndarray, intrinsics: np.ndarray) -> np.ndarray:
    """Normals (h, w, 3): those of the map itself, and where it was filled those of the depth (h, w) there."""
    if (filled == SEEN).all():
        return own
    found = normals(depth, intrinsics)
    np.copyto(found, own, where=(filled == SEEN)[..., None])
    return found


def interpolate_background(disparity: np.ndarray) -> np.ndarray:
    """Fill the NaN of a disparity map (h, w) as the KITTI development kit does: the smaller neighbour along the row,
    the only one at its ends, then the nearest value along the column. NaN stays only if there is no value at all.
    """
    filled = _fill_rows(disparity, np.fmin)
    return _fill_rows(filled.T, lambda before, after: np.where(np.isfinite(before), before, after)).T


def _fill_rows(image: np.ndarray, choose: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> np.ndarray:
    """Each row by itself; some at a time, since the indices take several times the memory of a large map."""
    out = np.empty_like(image)
    for top in range(0, len(image), ROWS):
        out[top : top + ROWS] = _filled(image[top : top + ROWS], choose)
    return out


def _filled(image: np.ndarray, choose: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> np.ndarray:
    valid = np.isfinite(image)
    column = np.broadcast_to(np.arange(image.shape[1]), image.shape)
    last = np.maximum.accumulate(np.where(valid, column, -1), axis=1)
    following = np.minimum.accumulate(np.where(valid, column, image.shape[1])[:, ::-1], axis=1)[:, ::-1]
    row = np.arange(image.shape[0])[:, None]
    before = np.where(last >= 0, image[row, np.maximum(last, 0)], np.nan)
    after = np.where(following < image.shape[1], image[row, np.minimum(following, image.shape[1] - 1)], np.nan)
    return np.where(valid, image, choose(before, after))
