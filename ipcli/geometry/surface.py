"""The surface that a depth map is: its normals and its triangles."""

from __future__ import annotations

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
    h, w = depth.shape
    pixels = np.flatnonzero(keep)
    number = np.full(h * w, -1, np.int32)
    number[pixels] = np.arange(pixels.size, dtype=np.int32)
    corner = number.reshape(h, w)
    a, b, c, d = corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]
    z = np.stack([depth[:-1, :-1], depth[:-1, 1:], depth[1:, 1:], depth[1:, :-1]])
    with np.errstate(invalid="ignore"):
        whole = (z.max(axis=0) <= (1 + jump) * z.min(axis=0)) & (np.stack([a, b, c, d]).min(axis=0) >= 0)
    a, b, c, d = (corners[whole] for corners in (a, b, c, d))
    faces = np.concatenate([np.stack([a, d, c], axis=-1), np.stack([a, c, b], axis=-1)])
    return pixels, faces
