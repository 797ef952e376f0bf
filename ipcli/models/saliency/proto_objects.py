"""Proto-objects: maxima of the membranes' energy on a surface, their patches, and how long they last."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

SMOOTHING = 2.0  # cells of the grid that the energy is averaged over before it is climbed


@dataclass(frozen=True, eq=False)
class ProtoObject:
    """A patch of the surface that the energy points at."""

    node: int  # among the nodes of the table
    energy: float
    patch: np.ndarray  # bool (n,): nodes within the radius


def summits(field: np.ndarray) -> np.ndarray:
    """The node (rows * columns,) that steepest ascent over neighbours leads to from each; -1 where unknown (NaN)."""
    rows, columns = field.shape
    padded = np.pad(np.where(np.isnan(field), -np.inf, field), 1, constant_values=-np.inf)
    number = np.pad(np.arange(rows * columns).reshape(rows, columns), 1)
    best, target = padded[1:-1, 1:-1].copy(), number[1:-1, 1:-1].copy()
    for dy in range(3):
        for dx in range(3):
            part = (slice(dy, dy + rows), slice(dx, dx + columns))
            higher = padded[part] > best
            best[higher], target[higher] = padded[part][higher], number[part][higher]
    up = target.ravel()
    while not (up[up] == up).all():
        up = up[up]
    return np.where(np.isnan(field).ravel(), -1, up)


def smoothed(values: np.ndarray, place: np.ndarray, grid: tuple[int, int]) -> np.ndarray:
    """Values (n,) at places of a grid as a smooth field (rows, columns); NaN where there is none."""
    from scipy.ndimage import gaussian_filter

    total, weight = np.zeros(grid), np.zeros(grid)
    total.flat[place], weight.flat[place] = values, 1.0
    with np.errstate(invalid="ignore", divide="ignore"):
        field = gaussian_filter(total, SMOOTHING) / gaussian_filter(weight, SMOOTHING)
    return np.where(weight > 0, field, np.nan)


def find(
    energy: np.ndarray, points: np.ndarray, place: np.ndarray, grid: tuple[int, int], radius: float, most: int
) -> list[ProtoObject]:
    """The highest maxima of the energy (n,) at points (n, 3), at least two radii apart, highest first."""
    field = smoothed(energy, place, grid)
    number = np.full(field.size, -1)
    number[place] = np.arange(len(place))
    tops = number[np.unique(summits(field)[place])]
    heights = field.ravel()[place]
    found: list[ProtoObject] = []
    for top in tops[np.argsort(-heights[tops], kind="stable")]:
        if len(found) == most or not heights[top] > 0:
            break
        if all(np.linalg.norm(points[top] - points[other.node]) >= 2 * radius for other in found):
            patch = np.linalg.norm(points - points[top], axis=1) < radius
            found.append(ProtoObject(int(top), float(heights[top]), patch))
    return found


def lasting(points: np.ndarray, subsequences: np.ndarray, radius: float) -> np.ndarray:
    """The track of each proto-object (n,): one that lies within a radius of an earlier track's first joins it."""
    tracks = np.full(len(points), -1)
    firsts: list[np.ndarray] = []
    for k in np.argsort(subsequences, kind="stable"):
        near = [t for t, place in enumerate(firsts) if np.linalg.norm(points[k] - place) < radius]
        if near:
            tracks[k] = min(near, key=lambda t: float(np.linalg.norm(points[k] - firsts[t])))
        else:
            tracks[k] = len(firsts)
            firsts.append(points[k])
    return tracks
