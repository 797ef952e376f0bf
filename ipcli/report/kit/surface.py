"""Depth maps as surfaces: shading under two lights, and the view from a camera that is turned aside."""

from __future__ import annotations

from math import cos, radians, sin

import numpy as np

from ipcli.geometry.cameras import back_project, rays
from ipcli.report.kit.pictures import Scale, palette, thin

KEY = np.array(
    [-0.48, -0.72, -0.5]
)  # direction to the soft key light, from the upper left behind the camera (y down, z forward)
BACKGROUND = (36, 38, 43)  # RGB behind a turned surface
YAW, PITCH = -28.0, 14.0  # degrees from which the turned camera looks
POINTS = 180_000  # more are thinned before splatting
STEEPEST = 6.0  # tangent of the angle to the optical axis beyond which a surface counts as a depth edge
SHADE = Scale(0.0, 1.0, "clay")


def shade(normals: np.ndarray, intrinsics: np.ndarray) -> np.ndarray:
    """Brightness (h, w) in [0, 1] under a headlight and a soft key light; NaN where there is no normal."""
    towards = -rays(normals.shape[:2], intrinsics).astype(np.float32)
    with np.errstate(invalid="ignore"):
        head = np.clip(_dot(normals, towards) / np.sqrt(_dot(towards, towards)), 0, 1)
        key = 0.5 + 0.5 * (normals @ (KEY / np.linalg.norm(KEY)).astype(np.float32))  # half Lambert: no hard terminator
        lit = 0.06 + 0.44 * head + 0.5 * key**2
    return np.where(_dot(normals, normals) > 0.25, lit, np.nan)  # zero vectors stand for no normal, too


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("...i,...i", a, b)


def oblique(
    depth: np.ndarray, intrinsics: np.ndarray, light: np.ndarray, image: np.ndarray | None = None
) -> np.ndarray:
    """The surface from a turned camera (rows, columns, 3) uint8 RGB: points splatted through a z-buffer, framed to fit.

    ``light`` (h, w) is the shading of the pixels; ``image`` (h, w, 3) colours them, clay does without. Far outliers are
    left out, so that they do not shrink the rest, and so are the points that hang between two surfaces.
    """
    widest = max(1, int(depth.shape[1] * min(1.0, (POINTS / depth.size) ** 0.5)))
    small, light = thin(depth, widest), thin(light, widest)
    camera = np.diag([small.shape[1] / depth.shape[1], small.shape[0] / depth.shape[0], 1.0]) @ intrinsics
    points = back_project(small, camera).astype(np.float32)
    colours = _colours(light, None if image is None else thin(image, widest))
    known = np.isfinite(small) & np.isfinite(light) & ~_grazing(small, camera)
    canvas = _canvas(small.shape)
    if not known.any():
        return np.full((*canvas, 3), BACKGROUND, np.uint8)
    return turned(points[known], colours[known], canvas)


def turned(points: np.ndarray, colours: np.ndarray, canvas: tuple[int, int]) -> np.ndarray:
    """Points (n, 3) float32 in a camera frame in their colours (n, 3), seen from the turned camera; far outliers left
    out.
    """
    low, high = np.percentile(points[::7, 2], (0.5, 99.5))
    margin = 0.3 * (high - low)
    inside = (points[:, 2] >= low - margin) & (points[:, 2] <= high + margin)
    return _splat(_turn(points[inside]), colours[inside], canvas)


def cloud(points: np.ndarray, normals: np.ndarray, colours: np.ndarray | None, canvas: tuple[int, int]) -> np.ndarray:
    """Points (n, 3) with normals (n, 3) in a camera frame, lit from that camera and seen from the turned one.

    Points behind the camera and more than make a picture are left out; clay without colours (n, 3).
    """
    ahead = np.flatnonzero(points[:, 2] > 0)
    if not ahead.size:
        return np.full((*canvas, 3), BACKGROUND, np.uint8)
    shown = ahead[:: -(-ahead.size // POINTS)]
    points, normals = points[shown].astype(np.float32), normals[shown]
    light = np.abs(_dot(normals, points)) / np.linalg.norm(points, axis=1)
    return turned(points, _colours(light, None if colours is None else colours[shown]), canvas)


def _grazing(depth: np.ndarray, intrinsics: np.ndarray) -> np.ndarray:
    """Pixels (h, w) from which the surface to the next one is seen under less than 9 degrees: depth edges."""
    steep = np.zeros(depth.shape, bool)
    for axis, focal in ((0, intrinsics[1, 1]), (1, intrinsics[0, 0])):
        jump = np.abs(np.diff(depth, axis=axis)) * float(focal) > STEEPEST * np.delete(depth, -1, axis=axis)
        steep |= np.pad(jump, [(0, 1) if side == axis else (0, 0) for side in (0, 1)])
    return steep


def _canvas(shape: tuple[int, ...]) -> tuple[int, int]:
    """Rows and columns of the picture: a little coarser than the map, for dense points, and never a thin band."""
    columns = max(16, int(0.85 * shape[1]))
    return max(12, int(max(0.85 * shape[0], columns / 2.4))), columns


def _colours(light: np.ndarray, image: np.ndarray | None) -> np.ndarray:
    if image is None:
        return palette("clay")[SHADE.indices(np.atleast_2d(light)).reshape(light.shape)]
    return (image * (0.5 + 0.6 * np.nan_to_num(light)[..., None])).clip(0, 255).astype(np.uint8)


def _turn(points: np.ndarray) -> np.ndarray:
    """Points (n, 3) seen from a camera as far from their median point, turned about it by YAW and PITCH."""
    pivot = np.median(points[::7], axis=0).astype(np.float32)
    (cy, sy), (cp, sp) = ((cos(radians(angle)), sin(radians(angle))) for angle in (YAW, PITCH))
    yaw = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    pitch = np.array([[1, 0, 0], [0, cp, -sp], [0, sp, cp]])
    turned = np.einsum(
        "nj,ij->ni", points - pivot, (pitch @ yaw).astype(np.float32)
    )  # a threaded product would cost more than it saves
    turned[:, 2] += np.linalg.norm(pivot)
    return turned


def _splat(points: np.ndarray, colours: np.ndarray, canvas: tuple[int, int]) -> np.ndarray:
    """The nearest point of each pixel in its colour, after one pass that closes the gaps between points."""
    pixels = _frame(points, canvas)
    seen = (points[:, 2] > 0) & (pixels >= 0).all(axis=1) & (pixels < canvas[::-1]).all(axis=1)
    pixels, z = pixels[seen].astype(np.intp), points[seen, 2].astype(np.float32)
    far_first = np.argsort(-z, kind="stable")
    nearest = np.full(canvas, -1)
    nearest.reshape(-1)[(pixels[:, 1] * canvas[1] + pixels[:, 0])[far_first]] = (
        far_first  # the last one written stays: the nearest
    )
    nearest = _close(nearest, np.append(z, np.inf))
    return np.vstack([colours[seen], [BACKGROUND]]).astype(np.uint8)[nearest]


def _frame(points: np.ndarray, canvas: tuple[int, int]) -> np.ndarray:
    """Pixels (n, 2) as (column, row) under the pinhole that fits nearly all points into the canvas."""
    with np.errstate(divide="ignore", invalid="ignore"):
        image = points[:, :2] / points[:, 2:]
    low, high = np.percentile(image[points[:, 2] > 0][::7], (0.3, 99.7), axis=0)
    size = np.array(canvas[::-1])
    focal = 0.94 * np.min(size / np.maximum(high - low, 1e-9))
    return (image - (low + high) / 2) * focal + size / 2


def _close(nearest: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Give pixels that are empty, or through which something far behind shines, the nearest point of their eight
    neighbours.
    """
    padded = np.pad(nearest, 1, constant_values=-1)
    depth = z[padded]
    rows, columns = nearest.shape
    best, best_depth = (
        nearest.copy(),
        depth[1:-1, 1:-1] * 0.97,
    )  # a neighbour must be nearer by 3 % to show through a gap
    for row, column in ((0, 1), (1, 0), (1, 2), (2, 1), (0, 0), (0, 2), (2, 0), (2, 2)):
        window = np.s_[row : row + rows, column : column + columns]
        closer = depth[window] < best_depth
        best[closer], best_depth[closer] = padded[window][closer], depth[window][closer]
    return best
