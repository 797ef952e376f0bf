"""The surface that a depth map is: its normals and its triangles."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ipcli import threads
from ipcli.geometry.cameras import rays
from ipcli.kernels import surface as kernels


def normals(depth: np.ndarray, intrinsics: np.ndarray) -> np.ndarray:
    """Unit normals (h, w, 3) float32 in the camera frame, facing the camera, of a depth map (h, w); NaN where
    undefined.

    From central differences of the points; one-sided at the border, beside a gap, and where one side is more than twice
    as long as the other, so that normals do not smear over an edge.
    """
    out = np.empty((*depth.shape, 3), np.float32)
    inverse = np.linalg.inv(intrinsics)
    threads.each(lambda rows: kernels.normals(out, depth, inverse, *rows), threads.blocks(depth.shape[0]))
    return out


def normals_of_slopes(depth: np.ndarray, slopes: np.ndarray, intrinsics: np.ndarray) -> np.ndarray:
    """Unit normals (h, w, 3) float32 in the camera frame, facing the camera, of a depth map (h, w) whose slopes are
    known apart.

    slopes (2, h, w) are the derivatives of the depth along columns and rows, in units of depth per pixel.
    """
    directions, inverse = rays(depth.shape, intrinsics), np.linalg.inv(intrinsics)
    along_u, along_v = (
        slope[..., None] * directions + depth[..., None] * inverse[:, axis]
        for axis, slope in enumerate(slopes.astype(np.float64))
    )
    n = np.cross(along_v, along_u)
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    return (n * -np.sign((n * directions).sum(axis=-1, keepdims=True))).astype(np.float32)


def triangulate(depth: np.ndarray, keep: np.ndarray, jump: float = 0.05) -> tuple[np.ndarray, np.ndarray]:
    """Triangles of the pixel grid over a depth map: pixel indices (n,) of the vertices and faces (m, 3) into them.

    Vertices are the pixels of `keep` (h, w). A quad is left open where its depths differ by more than the share `jump`:
    an occlusion boundary, not a surface. Faces turn counter-clockwise as seen from the camera.
    """
    grid = PixelGrid.of(depth, keep, jump)
    return np.flatnonzero(keep), np.concatenate(list(grid.faces()))


BAND = 256  # rows of a grid that are made into triangles at once


@dataclass(frozen=True, eq=False)
class PixelGrid:
    """The triangles of `triangulate`, made a band of rows at a time: those of a large map take several times its
    memory.
    """

    depth: np.ndarray  # (h, w)
    number: np.ndarray  # (h, w) int32, of the vertex at a pixel, -1 where there is none
    jump: float

    @classmethod
    def of(cls, depth: np.ndarray, keep: np.ndarray, jump: float = 0.05) -> PixelGrid:
        """Of the pixels of `keep` (h, w) of a depth map (h, w)."""
        number = np.full(keep.shape, -1, np.int32)
        number[keep] = np.arange(np.count_nonzero(keep), dtype=np.int32)
        return cls(depth, number, jump)

    def bands(self) -> list[slice]:
        """The rows, in bands."""
        height = len(self.depth)
        return [slice(top, min(top + BAND, height)) for top in range(0, height, BAND)]

    def count(self) -> int:
        """How many triangles there are."""
        return 2 * sum(len(corners) for corners in map(self._quads, self.bands()))

    def faces(self) -> Iterator[np.ndarray]:
        """Triangles (m, 3) into the vertices: first one of each quad, band by band, then the other."""
        for corners in ((0, 3, 2), (0, 2, 1)):
            for rows in self.bands():
                yield self._quads(rows)[:, corners]

    def _quads(self, rows: slice) -> np.ndarray:
        """Vertices (m, 4), clockwise from the upper left, of the quads whose upper row is one of these."""

        def corners(image: np.ndarray) -> np.ndarray:
            part = image[rows.start : rows.stop + 1]
            return np.stack([part[:-1, :-1], part[:-1, 1:], part[1:, 1:], part[1:, :-1]])

        z, number = corners(self.depth), corners(self.number)
        with np.errstate(invalid="ignore"):
            whole = (z.max(axis=0) <= (1 + self.jump) * z.min(axis=0)) & (number.min(axis=0) >= 0)
        return number[:, whole].T
