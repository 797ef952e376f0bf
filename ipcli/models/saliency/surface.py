"""The surface of a subsequence (3.10) in the frame of its reference camera, and its curvatures (3.12) to (3.15).

Over pixels the plate is inverse depth: single valued for all that one camera sees, and exact for planes, of which
inverse depth is affine. Over the plane it is Z(X, Y) as printed, which folds where a wall is seen edge on.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipcli.errors import ParameterError
from ipcli.inverse.regularize import thin_plate
from ipcli.models.saliency.scene_parameters import SurfaceFit

WIDEST = 1.5  # tangent of the angle from the axis: beyond it a surface over pixels is of no use
TRIM = 0.5  # percent of the points at each end that do not widen the domain
FEWEST = 16  # points that a surface rests on
SPARSE = 6.0  # cells: a node farther from any point is unknown


@dataclass(frozen=True, eq=False)
class PlateSurface:
    """Nodes of a fitted surface, (rows, columns) each, in the frame of the reference camera."""

    points: np.ndarray  # (rows, columns, 3) metres
    normals: np.ndarray  # (rows, columns, 3) unit vectors
    gaussian: np.ndarray  # K_G of (3.14), 1 / m^2
    mean: np.ndarray  # K_M of (3.15), 1 / m
    known: np.ndarray  # bool: near enough to points of the cloud
    error: float  # root mean square residual of the inner 90 % of the points, metres along the ray


def fit(cloud: np.ndarray, p: SurfaceFit) -> PlateSurface:
    """The plate nearest to points (n, 3) in the camera's frame. ParameterError where too few are before the camera."""
    cloud = cloud[np.isfinite(cloud).all(axis=1)]
    cloud = cloud[cloud[:, 2] > p.nearest]
    if len(cloud) < FEWEST:
        raise ParameterError(f"{len(cloud)} points of the map before the camera: a surface needs {FEWEST}")
    over_pixels = p.over == "pixels"
    flat = cloud[:, :2] / cloud[:, 2:] if over_pixels else cloud[:, :2]
    value = 1 / cloud[:, 2] if over_pixels else cloud[:, 2]
    if over_pixels:
        ahead = (np.abs(flat) < WIDEST).all(axis=1)
        flat, value = flat[ahead], value[ahead]
        if len(value) < FEWEST:
            raise ParameterError(f"{len(value)} points in sight: a surface needs {FEWEST}")
    low, high = np.percentile(flat, TRIM, axis=0), np.percentile(flat, 100 - TRIM, axis=0)
    side = np.maximum(high - low, 1e-6)
    step = float(np.sqrt(side.prod() / p.nodes))
    shape = (max(int(side[1] / step) + 1, 3), max(int(side[0] / step) + 1, 3))
    at = (flat - low) / step
    inside = ((at >= 0) & (at <= np.array([shape[1] - 1, shape[0] - 1]))).all(axis=1)
    at, value = at[inside], value[inside]
    # eta is of a domain of side 1 and per point: the plate is as stiff for few points as for many, on any grid
    stiffness = p.eta * len(at) * (max(shape) - 1) ** 2
    nodes = thin_plate.fit(at, value, shape, stiffness, rounds=p.robust_rounds)
    floor = 0.5 * float(value.min()) if over_pixels else -np.inf
    nodes = np.maximum(nodes, floor)
    columns, rows = np.meshgrid(np.arange(shape[1]), np.arange(shape[0]))
    u, v = low[0] + step * columns, low[1] + step * rows
    partials = _over_pixels if over_pixels else _over_plane
    points, derivatives = partials(u, v, nodes, _derivatives(nodes, step))
    normals, gaussian, mean = curvatures(*derivatives)
    off = value - thin_plate.sampling(at, shape) @ nodes.ravel()
    off = off / value**2 if over_pixels else off
    inner = np.sort(np.abs(off))[: max(int(0.9 * len(off)), 1)]
    return PlateSurface(points, normals, gaussian, mean, _near(at, shape), float(np.sqrt(np.mean(inner**2))))


def _derivatives(nodes: np.ndarray, step: float) -> tuple[np.ndarray, ...]:
    """S_X, S_Y, S_XX, S_XY, S_YY at the nodes: of the bicubic spline through them."""
    from scipy.interpolate import RectBivariateSpline

    y, x = (step * np.arange(length) for length in nodes.shape)
    degree = min(3, *(length - 1 for length in nodes.shape))
    spline = RectBivariateSpline(y, x, nodes, kx=degree, ky=degree)
    return tuple(spline(y, x, dx=dy, dy=dx) for dx, dy in ((1, 0), (0, 1), (2, 0), (1, 1), (0, 2)))


def _over_plane(u: np.ndarray, v: np.ndarray, z: np.ndarray, d: tuple[np.ndarray, ...]):
    """Points (X, Y, S(X, Y)) and their first and second derivatives."""
    zu, zv, zuu, zuv, zvv = d
    one, zero = np.ones_like(z), np.zeros_like(z)
    vectors = [(one, zero, zu), (zero, one, zv), (zero, zero, zuu), (zero, zero, zuv), (zero, zero, zvv)]
    return np.stack([u, v, z], axis=-1), tuple(np.stack(vector, axis=-1) for vector in vectors)


def _over_pixels(u: np.ndarray, v: np.ndarray, w: np.ndarray, d: tuple[np.ndarray, ...]):
    """Points (u, v, 1) / w and their first and second derivatives."""
    wu, wv, wuu, wuv, wvv = d
    z = 1 / w
    zu, zv = -wu * z**2, -wv * z**2
    zuu, zvv = 2 * wu**2 * z**3 - wuu * z**2, 2 * wv**2 * z**3 - wvv * z**2
    zuv = 2 * wu * wv * z**3 - wuv * z**2
    vectors = [
        (z + u * zu, v * zu, zu),
        (u * zv, z + v * zv, zv),
        (2 * zu + u * zuu, v * zuu, zuu),
        (zv + u * zuv, zu + v * zuv, zuv),
        (u * zvv, 2 * zv + v * zvv, zvv),
    ]
    return np.stack([u * z, v * z, z], axis=-1), tuple(np.stack(vector, axis=-1) for vector in vectors)


def curvatures(
    du: np.ndarray, dv: np.ndarray, duu: np.ndarray, duv: np.ndarray, dvv: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unit normals (3.12), Gaussian (3.14) and mean curvature (3.15) from derivatives (..., 3) of a surface."""
    cross = np.cross(du, dv)
    normals = cross / np.maximum(np.linalg.norm(cross, axis=-1, keepdims=True), 1e-300)
    first, mixed, second = ((a * b).sum(axis=-1) for a, b in ((du, du), (du, dv), (dv, dv)))
    uu, uv, vv = ((bend * normals).sum(axis=-1) for bend in (duu, duv, dvv))
    determinant = np.maximum(first * second - mixed**2, 1e-300)
    mean = (first * vv - 2 * mixed * uv + second * uu) / (2 * determinant)
    return normals, (uu * vv - uv**2) / determinant, mean


def _near(at: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Which nodes have a point within SPARSE cells."""
    from scipy.ndimage import distance_transform_edt

    empty = np.ones(shape, bool)
    cells = np.rint(at).astype(int)
    empty[cells[:, 1], cells[:, 0]] = False
    return distance_transform_edt(empty) <= SPARSE
