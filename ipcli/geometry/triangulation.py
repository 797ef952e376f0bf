"""A triangulation of a mask: smoothed contour, even points on it, a hexagonal lattice inside, Delaunay's triangles."""

from __future__ import annotations

import numpy as np

LEAST_AREA = 0.02  # of a triangle, in squared spacings: thinner ones on the rim are slivers
FROM_RIM = 0.6  # of a spacing between lattice and rim


def triangulate_mask(mask: np.ndarray, spacing: float, smoothing: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 2) as (column, row) in pixels and triangles (m, 3), counter-clockwise, over the largest blob of a
    mask (h, w) bool; the holes of the blob are filled.

    `spacing` is the side of the triangles and `smoothing` the deviation of the Gaussian that takes the staircase off
    the contour, both in pixels. Raises ValueError when nothing is left to triangulate.
    """
    from scipy.spatial import Delaunay

    rim = resample(contour(mask, smoothing), spacing)
    lattice = hexagonal(rim.min(axis=0), rim.max(axis=0), spacing)
    lattice = lattice[inside(rim, lattice)]
    lattice = lattice[is_farther(rim, lattice, FROM_RIM * spacing)]
    points = np.concatenate([rim, lattice])
    if len(rim) < 3:
        raise ValueError("the mask is too small for triangles of this size")
    triangles = Delaunay(points).simplices.astype(np.int64)
    area = signed_area(points, triangles)
    middles = points[triangles].mean(axis=1)
    whole = inside(rim, middles) & (np.abs(area) > LEAST_AREA * spacing**2)
    triangles, area = triangles[whole], area[whole]
    triangles[area < 0] = triangles[area < 0][:, ::-1]
    return _used(points, triangles)


def contour(mask: np.ndarray, smoothing: float = 1.0) -> np.ndarray:
    """The longest outer contour of a mask (h, w) bool as points (n, 2) of (column, row), closed without a repeat."""
    from scipy.ndimage import gaussian_filter
    from skimage.measure import find_contours

    reach = 2 + int(np.ceil(3 * smoothing))
    smooth = gaussian_filter(np.pad(mask.astype(np.float64), reach), smoothing)
    found = find_contours(smooth, 0.5)
    if not found:
        raise ValueError("the mask is empty, or smaller than its smoothing")
    longest = max(found, key=lambda c: abs(_enclosed(c)))
    return longest[:-1, ::-1] - reach


def resample(closed: np.ndarray, spacing: float) -> np.ndarray:
    """Points (n, 2) at even distance along a closed polygon (k, 2), as near to `spacing` as its length allows."""
    around = np.concatenate([closed, closed[:1]])
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(around, axis=0), axis=1))])
    count = max(3, round(along[-1] / spacing))
    at = np.arange(count) * along[-1] / count
    return np.stack([np.interp(at, along, around[:, axis]) for axis in range(2)], axis=1)


def hexagonal(low: np.ndarray, high: np.ndarray, spacing: float) -> np.ndarray:
    """Points (n, 2) of a hexagonal lattice over a box."""
    rows = np.arange(low[1], high[1] + spacing, spacing * np.sqrt(0.75))
    columns = np.arange(low[0], high[0] + spacing, spacing)
    u = columns[None, :] + np.where(np.arange(len(rows)) % 2, spacing / 2, 0.0)[:, None]
    return np.stack([u, np.broadcast_to(rows[:, None], u.shape)], axis=-1).reshape(-1, 2)


def inside(polygon: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Which points (n, 2) lie within a closed polygon (k, 2)."""
    from skimage.measure import points_in_poly

    return points_in_poly(points, polygon)


def distance_to(polygon: np.ndarray, points: np.ndarray, chunk: int = 4096) -> np.ndarray:
    """Distance (n,) of points (n, 2) to the nearest point on the sides of a closed polygon (k, 2)."""
    start, side = polygon, np.roll(polygon, -1, axis=0) - polygon
    length = np.maximum((side**2).sum(axis=1), 1e-300)
    distances = np.empty(len(points))
    for first in range(0, len(points), chunk):
        away = points[first : first + chunk, None] - start  # (c, k, 2)
        share = np.clip((away * side).sum(axis=-1) / length, 0, 1)
        rest = away - share[..., None] * side
        distances[first : first + chunk] = np.sqrt((rest**2).sum(axis=-1).min(axis=1))
    return distances


def is_farther(polygon: np.ndarray, points: np.ndarray, least: float) -> np.ndarray:
    """Which points (n, 2) are farther than `least` from the sides of a closed polygon (k, 2)."""
    from scipy.spatial import cKDTree

    longest = float(np.linalg.norm(np.roll(polygon, -1, axis=0) - polygon, axis=1).max())
    farther = cKDTree(polygon).query(points)[0] > least + longest  # from its corners: that is beyond doubt
    farther[~farther] = distance_to(polygon, points[~farther]) > least
    return farther


def signed_area(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Area (m,) of triangles (m, 3) of points (n, 2), negative where they turn clockwise."""
    a, b, c = (points[triangles[:, corner]] for corner in range(3))
    return 0.5 * ((b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0]))


def rim_of(triangles: np.ndarray) -> np.ndarray:
    """Edges (k, 2) that belong to one triangle only, in the direction in which it turns."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    _, first, count = np.unique(np.sort(edges, axis=1), axis=0, return_index=True, return_counts=True)
    return edges[first[count == 1]]


def reflect(points: np.ndarray, triangles: np.ndarray, heights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The closed surface of a height field: vertices (k, 3) and faces (2 m, 3), the field joined with its mirror image
    in z = 0 along the rim, whose heights count as 0. Faces look outwards.
    """
    on_rim = np.zeros(len(points), bool)
    on_rim[rim_of(triangles)] = True
    height = np.where(on_rim, 0.0, heights)
    inner = np.flatnonzero(~on_rim)
    below = np.arange(len(points))
    below[inner] = len(points) + np.arange(len(inner))
    top = np.column_stack([points, height])
    bottom = np.column_stack([points[inner], -height[inner]])
    return np.concatenate([top, bottom]), np.concatenate([triangles, below[triangles][:, ::-1]])


def _enclosed(closed: np.ndarray) -> float:
    u, v = closed.T
    return 0.5 * float((u * np.roll(v, -1) - v * np.roll(u, -1)).sum())


def _used(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Without the points that no triangle has."""
    used, packed = np.unique(triangles, return_inverse=True)
    if not len(triangles):
        raise ValueError("the mask is too small for triangles of this size")
    return points[used], packed.reshape(-1, 3)
