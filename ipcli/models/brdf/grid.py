"""Height fields on the pixels of a mask: slopes on 2 x 2 cells, second differences, normals, inflation of a
silhouette.

Heights are towards the viewer, in pixels; x runs right along the columns, y UP against the rows. Unknowns are the
pixels of the mask in order of rows.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True, eq=False)
class Grid:
    """The pixels of a mask and the sparse difference operators on them."""

    mask: np.ndarray  # (h, w) bool
    corners: np.ndarray  # (c, 4) pixels of each cell: top left, top right, bottom left, bottom right
    slope_x: Any  # (c, n) sparse: p = z_x on the cells
    slope_y: Any  # (c, n)
    bend: tuple[Any, Any, Any]  # (n, n): z_xx, z_yy, sqrt(2) z_xy at each pixel; zero where a neighbour is missing

    @property
    def size(self) -> int:
        """Number of pixels."""
        return int(self.mask.sum())

    def image(self, values: np.ndarray, empty: float = np.nan) -> np.ndarray:
        """Values (n, ...) of the pixels as an image (h, w, ...)."""
        image = np.full((*self.mask.shape, *values.shape[1:]), empty)
        image[self.mask] = values
        return image

    def on_cells(self, values: np.ndarray) -> np.ndarray:
        """Mean (c, ...) over the corners of each cell of values (n, ...) at the pixels."""
        return values[self.corners].mean(axis=1)

    def to_pixels(self, values: np.ndarray) -> np.ndarray:
        """Mean (n, ...) over the cells around each pixel of values (c, ...); NaN at pixels of no cell."""
        flat, at = values.reshape(len(values), -1), self.corners.ravel()
        count = np.bincount(at, minlength=self.size).astype(float)
        total = np.stack([np.bincount(at, np.repeat(column, 4), minlength=self.size) for column in flat.T], axis=-1)
        with np.errstate(invalid="ignore", divide="ignore"):
            return (total / count[:, None]).reshape(self.size, *values.shape[1:])


def grid(mask: np.ndarray) -> Grid:
    """The grid of a mask (h, w) bool."""
    number = np.full(mask.shape, -1)
    number[mask] = np.arange(mask.sum())
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]
    whole = np.stack([a, b, c, d]).min(axis=0) >= 0
    corners = np.stack([a[whole], b[whole], c[whole], d[whole]], axis=-1)
    n = int(mask.sum())
    slope_x = _stencil(corners, np.array([-0.5, 0.5, -0.5, 0.5]), n)
    slope_y = _stencil(corners, np.array([0.5, 0.5, -0.5, -0.5]), n)
    return Grid(mask, corners, slope_x, slope_y, (_second(number, 1, n), _second(number, 0, n), _mixed(corners, n)))


def _stencil(
    columns: np.ndarray, weights: np.ndarray, n: int, rows: np.ndarray | None = None, height: int | None = None
) -> Any:
    from scipy.sparse import csr_matrix

    rows = np.arange(len(columns)) if rows is None else rows
    data = np.broadcast_to(weights, columns.shape).ravel()
    return csr_matrix((data, (np.repeat(rows, columns.shape[1]), columns.ravel())), shape=(height or len(columns), n))


def _second(number: np.ndarray, axis: int, n: int) -> Any:
    turned = np.moveaxis(number, axis, 0)
    a, b, c = turned[:-2], turned[1:-1], turned[2:]
    whole = np.minimum(np.minimum(a, b), c) >= 0
    columns = np.stack([a[whole], b[whole], c[whole]], axis=-1)
    return _stencil(columns, np.array([1.0, -2.0, 1.0]), n, rows=b[whole], height=n)


def _mixed(corners: np.ndarray, n: int) -> Any:
    return _stencil(corners, np.sqrt(2) * np.array([-1.0, 1.0, 1.0, -1.0]), n, rows=corners[:, 0], height=n)


def normals_of_slopes(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Unit normals (..., 3) towards the viewer of slopes z_x, z_y."""
    m = np.stack([-p, -q, np.ones_like(p)], axis=-1)
    return m / np.linalg.norm(m, axis=-1, keepdims=True)


def normals(height: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Unit normals (h, w, 3) of heights (h, w) in a mask; NaN outside.

    Each is that of the plane that fits the 3 x 3 pixels about it, weighed 1 2 1; with no neighbour missing this is
    Sobel's operator. A pixel without enough neighbours faces the viewer.
    """
    from scipy.ndimage import correlate

    rows, columns = np.indices(mask.shape)
    weights = np.outer([1, 2, 1], [1, 2, 1]).astype(float)
    x, y = np.array([[-1.0, 0, 1]] * 3), np.array([[1.0] * 3, [0.0] * 3, [-1.0] * 3])
    w = mask.astype(float)
    z = np.where(mask, height, 0.0)

    def moment(kernel: np.ndarray, image: np.ndarray) -> np.ndarray:
        return correlate(image, kernel * weights, mode="constant")

    one = np.ones((3, 3))
    s, sx, sy = (moment(kernel, w) for kernel in (one, x, y))
    sxx, syy, sxy = (moment(kernel, w) for kernel in (x * x, y * y, x * y))
    sz, sxz, syz = (moment(kernel, z) for kernel in (one, x, y))
    s = np.maximum(s, 1e-9)
    cxx, cyy, cxy = sxx - sx * sx / s, syy - sy * sy / s, sxy - sx * sy / s
    cxz, cyz = sxz - sx * sz / s, syz - sy * sz / s
    determinant = cxx * cyy - cxy**2
    sound = determinant > 1e-6
    determinant = np.where(sound, determinant, 1.0)
    p = np.where(sound, (cyy * cxz - cxy * cyz) / determinant, 0.0)
    q = np.where(sound, (cxx * cyz - cxy * cxz) / determinant, 0.0)
    return np.where(mask[..., None], normals_of_slopes(p, q), np.nan)


def inflate(mask: np.ndarray) -> np.ndarray:
    """Height (h, w) of a balloon of this silhouette: z = 2 sqrt(u), -Laplace u = 1, u = 0 outside; a disc gives a
    hemisphere.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.linalg import splu

    number = np.full(mask.shape, -1)
    number[mask] = np.arange(mask.sum())
    padded = np.pad(number, 1, constant_values=-1)
    centre = number[mask]
    neighbours = [
        padded[1 + dr : padded.shape[0] - 1 + dr, 1 + dc : padded.shape[1] - 1 + dc][mask] for dr, dc in _FOUR
    ]
    rows = np.concatenate([centre, *(centre[near >= 0] for near in neighbours)])
    columns = np.concatenate([centre, *(near[near >= 0] for near in neighbours)])
    data = np.concatenate([np.full(centre.size, 4.0), np.full(rows.size - centre.size, -1.0)])
    laplacian = coo_matrix((data, (rows, columns)), shape=(centre.size,) * 2).tocsc()
    u = splu(laplacian, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}).solve(np.ones(centre.size))
    height = np.zeros(mask.shape)
    height[mask] = 2 * np.sqrt(np.maximum(u, 0))
    return height


_FOUR = ((-1, 0), (1, 0), (0, -1), (0, 1))
