"""Regular grids of voxels seen by orthographic cameras: silhouettes and depths carried into the volume and back."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipcli.geometry.orthographic import Orthographic

FAR = np.float32(1e6)  # depth where a ray meets nothing, in voxels


@dataclass(frozen=True, eq=False)
class VoxelGrid:
    """Points origin + spacing * (i, j, k) for i < shape[0] and so on, in world units."""

    origin: np.ndarray
    spacing: float
    shape: tuple[int, int, int]

    @classmethod
    def around(cls, low: np.ndarray, high: np.ndarray, spacing: float, margin: int = 4) -> VoxelGrid:
        """The grid over a box with some voxels to spare on each side."""
        count = np.ceil((high - low) / spacing).astype(int) + 2 * margin + 1
        nx, ny, nz = (int(n) for n in count)
        return cls(low - margin * spacing, spacing, (nx, ny, nz))

    def points(self) -> np.ndarray:
        """All points (nx, ny, nz, 3)."""
        axes = [self.origin[a] + self.spacing * np.arange(n) for a, n in enumerate(self.shape)]
        return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)

    def plane(self, row: np.ndarray, offset: float = 0.0) -> np.ndarray:
        """row . X + offset (nx, ny, nz) of all points X, without ever holding the points."""
        x, y, z = (row[a] * (self.origin[a] + self.spacing * np.arange(n)) for a, n in enumerate(self.shape))
        return x[:, None, None] + y[None, :, None] + (z + offset)[None, None, :]


def signed_distance(mask: np.ndarray) -> np.ndarray:
    """Distance (h, w) float32 in pixels to the rim of a mask, negative inside; the rim runs between the pixels.

    Smooth masks give steps of half a pixel at most; beyond the image counts as outside. An empty mask is far.
    """
    from scipy.ndimage import distance_transform_edt

    if not mask.any():
        return np.full(mask.shape, max(mask.shape), np.float32)
    padded = np.pad(mask, 1)
    outside, within = distance_transform_edt(~padded), distance_transform_edt(padded)
    return (np.where(padded, 0.5 - within, outside - 0.5))[1:-1, 1:-1].astype(np.float32)


@dataclass(frozen=True, eq=False)
class Sight:
    """How a camera sees a grid: for each point its (column, row) in the image, its depth in voxels, and the number of
    its ray: points whose pixels fall into the same cell, as wide as a voxel, share one.
    """

    columns: np.ndarray  # (nx, ny, nz) float32
    rows: np.ndarray
    depth: np.ndarray
    ray: np.ndarray  # (nx, ny, nz) int32
    cells: tuple[int, int]  # rays down and across
    pixels: float  # a voxel is that many pixels wide

    @classmethod
    def of(cls, grid: VoxelGrid, camera: Orthographic) -> Sight:
        """That of this camera."""
        columns = grid.plane(camera.scale * camera.rotation[0], camera.shift[0]).astype(np.float32)
        rows = grid.plane(camera.scale * camera.rotation[1], camera.shift[1]).astype(np.float32)
        depth = (grid.plane(camera.rotation[2]) / grid.spacing).astype(np.float32)
        pixels = camera.scale * grid.spacing
        across = np.round((columns - columns.min()) / pixels).astype(np.int32)
        down = np.round((rows - rows.min()) / pixels).astype(np.int32)
        cells = (int(down.max()) + 1, int(across.max()) + 1)
        return cls(columns, rows, depth, down * np.int32(cells[1]) + across, cells, pixels)

    def sample(self, image: np.ndarray, outside: float) -> np.ndarray:
        """An image (h, w) of floats at all points, interpolated; `outside` beyond its border."""
        from scipy.ndimage import map_coordinates

        first = tuple(slice(None) if varies else slice(1) for varies in self._varying())
        at = (self.rows[first], self.columns[first])
        values = map_coordinates(image, at, order=1, mode="constant", cval=outside, output=np.float32)
        return np.broadcast_to(values, self.rows.shape).copy()

    def _varying(self) -> list[bool]:
        """For each axis of the grid, whether the pixel changes along it: not along that of a named view."""
        corner = [np.moveaxis(c, axis, 0)[:, 0, 0] for c in (self.rows, self.columns) for axis in range(3)]
        moves = [bool((line != line[0]).any()) for line in corner]
        return [moves[axis] or moves[axis + 3] for axis in range(3)]

    def nearest(self, labels: np.ndarray) -> np.ndarray:
        """An image (h, w) of integers at all points, 0 beyond its border."""
        row, column = np.rint(self.rows).astype(np.int32), np.rint(self.columns).astype(np.int32)
        known = (row >= 0) & (row < labels.shape[0]) & (column >= 0) & (column < labels.shape[1])
        return np.where(known, labels[np.where(known, row, 0), np.where(known, column, 0)], 0)

    def least(self, field: np.ndarray, where: np.ndarray | None = None) -> np.ndarray:
        """The least value (cells) of a field (nx, ny, nz) along each ray, among the points `where`; FAR of none."""
        least = np.full(self.cells[0] * self.cells[1], FAR, np.float32)
        ray, values = (self.ray.ravel(), field.ravel()) if where is None else (self.ray[where], field[where])
        np.minimum.at(least, ray, values.astype(np.float32, copy=False))
        return least

    def silhouette_distance(self, mask: np.ndarray) -> np.ndarray:
        """Distance in voxels to the silhouette's rim at all points, negative inside the cone (here: cylinder)."""
        return self.sample(signed_distance(mask) / np.float32(self.pixels), float(max(mask.shape)) / self.pixels)


def hull(sights: list[Sight], masks: list[np.ndarray]) -> np.ndarray:
    """The field (nx, ny, nz) in voxels of the visual hull: the intersection of the silhouettes' cylinders."""
    fields = (sight.silhouette_distance(mask) for sight, mask in zip(sights, masks, strict=True))
    result = next(fields)
    for field in fields:
        result = np.maximum(result, field)
    return result
