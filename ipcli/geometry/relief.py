"""Height fields as meshes: the visible front, and a closed relief with walls and a back plate that a printer takes."""

from __future__ import annotations

import numpy as np


def front(height: np.ndarray, pixel: float = 1.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices (n, 3), faces (m, 3) int32 facing the viewer and the flat pixel index (n,) of each vertex.

    `height` (h, w) in pixels, NaN where there is no surface; x right, y up, z to the viewer; `pixel` is the side of a
    pixel.
    """
    known = np.isfinite(height)
    h, w = height.shape
    number = np.full((h, w), -1, np.int32)
    number[known] = np.arange(known.sum(), dtype=np.int32)
    rows, columns = np.nonzero(known)
    vertices = np.stack([columns - (w - 1) / 2, (h - 1) / 2 - rows, height[known]], axis=-1) * pixel
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    faces = [np.stack([a, d, c], axis=-1), np.stack([a, c, b], axis=-1)]
    flat = [part.reshape(-1, 3) for part in faces]
    return vertices, np.concatenate([part[(part >= 0).all(axis=1)] for part in flat]), np.flatnonzero(known)


def closed(height: np.ndarray, pixel: float = 1.0, plate: float = 0.05) -> tuple[np.ndarray, np.ndarray]:
    """A watertight mesh: the front over the cells whose corners are all known, walls along its edge, and a flat back.

    The back lies `plate` longest sides below the lowest point of the front. Where cells touch in a single corner the
    pixels are left out until none do, so that every edge has two faces.
    """
    cells = _sound_cells(np.isfinite(height))
    if not cells.any():
        return np.zeros((0, 3)), np.zeros((0, 3), np.int32)
    used = np.zeros(height.shape, bool)
    for rows, columns in (
        (slice(None, -1), slice(None, -1)),
        (slice(None, -1), slice(1, None)),
        (slice(1, None), slice(None, -1)),
        (slice(1, None), slice(1, None)),
    ):
        used[rows, columns] |= cells
    vertices, _, _ = front(np.where(used, height, np.nan), pixel)
    number = np.full(height.shape, -1, np.int64)
    number[used] = np.arange(used.sum())
    a, b, c, d = (corner[cells] for corner in (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]))
    top = np.concatenate([np.stack([a, d, c], axis=-1), np.stack([a, c, b], axis=-1)])
    count = len(vertices)
    edges = np.concatenate([top[:, [0, 1]], top[:, [1, 2]], top[:, [2, 0]]])
    back_and_forth = {tuple(edge) for edge in edges.tolist()}
    rim = np.array([edge for edge in edges.tolist() if (edge[1], edge[0]) not in back_and_forth])
    u, v = rim.T
    walls = np.concatenate([np.stack([v, u, u + count], axis=-1), np.stack([v, u + count, v + count], axis=-1)])
    below = vertices.copy()
    below[:, 2] = vertices[:, 2].min() - plate * pixel * max(height.shape)
    faces = np.concatenate([top, top[:, ::-1] + count, walls]).astype(np.int32)
    return np.concatenate([vertices, below]), faces


def _sound_cells(known: np.ndarray) -> np.ndarray:
    """Cells (h - 1, w - 1) with four known corners, less those that meet another one in nothing but a corner."""
    cells = known[:-1, :-1] & known[:-1, 1:] & known[1:, :-1] & known[1:, 1:]
    while True:
        a, b, c, d = cells[:-1, :-1], cells[:-1, 1:], cells[1:, :-1], cells[1:, 1:]
        falling, rising = a & d & ~b & ~c, b & c & ~a & ~d
        if not (falling | rising).any():
            return cells
        cells[1:, 1:] &= ~falling
        cells[1:, :-1] &= ~rising
