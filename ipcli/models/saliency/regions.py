"""Coherent regions (3.11): what lies within a distance of a point of regard, on the surface and in the pictures."""

from __future__ import annotations

import numpy as np

from ipcli.measurements.recording import Camera
from ipcli.measurements.subsequences import seen_at

CELL = 4  # pixels of a picture to a cell of its map
REACH = 3.0  # cells: farther from any node's image a cell is unknown


def within(points: np.ndarray, centres: np.ndarray, radius: float) -> np.ndarray:
    """Whether each point (n, 3) is nearer than `radius` to any of the centres (m, 3)."""
    from scipy.spatial import cKDTree

    if not len(centres):
        return np.zeros(len(points), bool)
    return np.asarray(np.isfinite(cKDTree(centres).query(points, distance_upper_bound=radius)[0]))


def labels(points: np.ndarray, regards: np.ndarray, all_regards: np.ndarray, radius: float) -> np.ndarray:
    """(n,) int8: 1 in a coherent region of these regards, -1 where nobody ever looked, 0 looked at some other time."""
    attended, ever = within(points, regards, radius), within(points, all_regards, radius)
    return np.where(attended, 1, np.where(ever, 0, -1)).astype(np.int8)


def cells_of(camera: Camera) -> tuple[int, int]:
    """Rows and columns of a picture's map."""
    return -(-camera.size[1] // CELL), -(-camera.size[0] // CELL)


def nodes_in_picture(camera: Camera, cam_from_world: np.ndarray, points: np.ndarray) -> np.ndarray:
    """For each cell of a picture's map the node (n, 3) of the surface it shows; -1 where there is none near."""
    from scipy.spatial import cKDTree

    rows, columns = cells_of(camera)
    pixels = seen_at(camera, cam_from_world, points)
    seen = np.flatnonzero(np.isfinite(pixels[:, 0]))
    if not len(seen):
        return np.full((rows, columns), -1)
    at = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1).reshape(-1, 2) * CELL + (CELL - 1) / 2
    distance, nearest = cKDTree(pixels[seen]).query(at, distance_upper_bound=REACH * CELL)
    known = np.isfinite(distance)
    return np.where(known, seen[np.where(known, nearest, 0)], -1).reshape(rows, columns)


def shown(values: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """Values (n,) of nodes as the map (rows, columns) of a picture; NaN where it shows no node."""
    return np.where(nodes >= 0, values[np.maximum(nodes, 0)], np.nan).astype(np.float32)
