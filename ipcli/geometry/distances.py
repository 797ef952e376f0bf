"""How far two closed surfaces are apart: distances both ways, and the volume that only one of them has."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipcli.geometry import meshes

SAMPLES = 20_000  # points on each surface
VOXELS = 64  # along the longest side, for volumes


@dataclass(frozen=True)
class Apart:
    """Distances over the diagonal of the truth: the mean of both mean distances, the root of both mean squares, and
    the 95 % and the largest of both; and the share of the united volume that only one body has.
    """

    mean: float
    rms: float
    p95: float
    most: float
    outside: float


def apart(found: tuple[np.ndarray, np.ndarray], truth: tuple[np.ndarray, np.ndarray], seed: int = 0) -> Apart:
    """How far the mesh `found` (vertices (n, 3), faces (m, 3)) is from the mesh `truth`."""
    diagonal = float(np.linalg.norm(np.ptp(truth[0], axis=0)))
    there, back = (one_way(a, b, seed) / diagonal for a, b in ((found, truth), (truth, found)))
    return Apart(
        float(there.mean() + back.mean()) / 2,
        float(np.sqrt((np.mean(there**2) + np.mean(back**2)) / 2)),
        float(max(np.percentile(there, 95), np.percentile(back, 95))),
        float(max(there.max(), back.max())),
        1 - overlap(found, truth),
    )


def one_way(start: tuple[np.ndarray, np.ndarray], goal: tuple[np.ndarray, np.ndarray], seed: int = 0) -> np.ndarray:
    """Distances (SAMPLES,) from points spread evenly over one mesh to the nearest point of another."""
    import trimesh

    body = trimesh.Trimesh(start[0], start[1], process=False)
    points, _ = trimesh.sample.sample_surface(body, SAMPLES, seed=seed)
    return to_surface(points, goal)


def to_surface(points: np.ndarray, goal: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """Distances (n,) of points (n, 3) to the nearest point of a mesh."""
    import igl

    vertices, faces = np.ascontiguousarray(goal[0], np.float64), np.ascontiguousarray(goal[1], np.int64)
    squared = igl.point_mesh_squared_distance(np.ascontiguousarray(points, np.float64), vertices, faces)[0]
    return np.sqrt(np.maximum(squared, 0))


def overlap(first: tuple[np.ndarray, np.ndarray], second: tuple[np.ndarray, np.ndarray]) -> float:
    """Intersection over union of two bodies, counted in voxels by their winding numbers."""
    both = np.concatenate([first[0], second[0]])
    low, high = both.min(axis=0), both.max(axis=0)
    side = float((high - low).max()) / VOXELS
    axes = [np.arange(low[a] + side / 2, high[a], side) for a in range(3)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    inside = [meshes.contains(*body, points) for body in (first, second)]
    return float((inside[0] & inside[1]).sum() / max(int((inside[0] | inside[1]).sum()), 1))
