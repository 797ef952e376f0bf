"""Which area of interest each point of regard lies in, and what that says of attention: dwell, visits, transitions."""

from __future__ import annotations

import numpy as np

from ipcli.measurements.recording import Areas

NONE = -1
GAP = 0.15  # seconds away that do not end a visit, or three samples where those are longer

Arrays = dict[str, np.ndarray]


def distances(points: np.ndarray, areas: Areas) -> np.ndarray:
    """Metres (n, a) from points (n, 3) to each area, 0 inside a box; NaN for an unknown point."""
    from scipy.spatial import cKDTree

    found = np.full((len(points), len(areas.names)), np.nan)
    known = np.isfinite(points).all(axis=1)
    at = points[known]
    for i, (low, high) in areas.boxes.items():
        found[known, i] = np.linalg.norm(np.maximum(np.maximum(low - at, at - high), 0.0), axis=1)
    for i, corners in areas.polygons.items():
        found[known, i] = _from_polygon(at, corners)
    for i, cloud in areas.clouds.items():
        found[known, i] = cKDTree(cloud).query(at)[0]
    return found


def _from_polygon(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Distances (n,) from a plane polygon: from its plane above its inside, else from its nearest edge."""
    after = np.roll(corners, -1, axis=0)
    middle = corners.mean(axis=0)
    axes = np.linalg.svd(corners - middle)[2]
    flat, plane = (points - middle) @ axes[:2].T, (points - middle) @ axes[2]
    start, end = (corners - middle) @ axes[:2].T, (after - middle) @ axes[:2].T
    y = flat[:, 1:]
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = start[:, 0] + (y - start[:, 1]) * (end[:, 0] - start[:, 0]) / (end[:, 1] - start[:, 1])
    crosses = ((start[:, 1] > y) != (end[:, 1] > y)) & (flat[:, :1] < crossing)
    inside = crosses.sum(axis=1) % 2 == 1
    edge = after - corners
    length = np.maximum(np.square(edge).sum(axis=1), 1e-18)
    share = np.clip(np.einsum("nei,ei->ne", points[:, None] - corners, edge) / length, 0.0, 1.0)
    off = np.linalg.norm(points[:, None] - corners - share[..., None] * edge, axis=2).min(axis=1)
    return np.where(inside, np.abs(plane), off)


def area_of(points: np.ndarray, areas: Areas, margin: float) -> np.ndarray:
    """The nearest area (n,) within `margin` metres of each point; NONE without."""
    off = np.where(np.isnan(far := distances(points, areas)), np.inf, far)
    nearest = off.argmin(axis=1)
    return np.where(off[np.arange(len(off)), nearest] <= margin, nearest, NONE)


def attention(times: np.ndarray, points: np.ndarray, fixation: np.ndarray, areas: Areas, margin: float) -> Arrays:
    """Fields `aoi/...` of an experiment: for each area dwell (s), its share of all known gaze, visits, fixations, first
    look (s after the first sample, NaN never), and transitions (a, a) between areas.

    `fixation` (n,): the fixation of each sample, -1 none. A sample lasts until the next one, at most three median gaps.
    A visit is a run of samples in one area; up to `GAP` s elsewhere or without a point of regard (a blink, a step over
    the rim) do not end it. A transition leads from a visit to the next one of another area.
    """
    mine = area_of(points, areas, margin)
    known = np.isfinite(points).all(axis=1)
    gap = float(np.median(np.diff(times))) if len(times) > 1 else 0.0
    lasts = np.minimum(np.diff(times, append=times[-1:] + gap), 3 * gap)
    visits = _visits(times, mine, max(GAP, 3 * gap))
    count = len(areas.names)
    moves = np.zeros((count, count), np.int64)
    for a, b in zip(visits, visits[1:], strict=False):
        if a != b:
            moves[a, b] += 1
    looks = [np.flatnonzero(mine == i) for i in range(count)]
    total = float(lasts[known].sum())
    dwell = np.array([lasts[look].sum() for look in looks])
    return {
        "aoi/names": np.array(areas.names, dtype=np.str_).reshape(-1),
        "aoi/of_sample": mine.astype(np.int64),
        "aoi/dwell": dwell,
        "aoi/share": dwell / total if total > 0 else np.full(count, np.nan),
        "aoi/visits": np.bincount(np.array(visits, int), minlength=count).astype(np.int64),
        "aoi/fixations": np.array([_fixations(fixation, mine, i) for i in range(count)], np.int64),
        "aoi/first": np.array([times[look[0]] - times[0] if len(look) else np.nan for look in looks]),
        "aoi/transitions": moves,
    }


def _visits(times: np.ndarray, mine: np.ndarray, gap: float) -> list[int]:
    """The area of each visit in order: runs of samples in one area, with at most `gap` s between two of them."""
    areas: list[int] = []
    last = -np.inf
    for sample in np.flatnonzero(mine != NONE):
        if not areas or areas[-1] != mine[sample] or times[sample] - last > gap:
            areas.append(int(mine[sample]))
        last = times[sample]
    return areas


def _fixations(fixation: np.ndarray, mine: np.ndarray, area: int) -> int:
    """Fixations most of whose samples with an area lie in this one."""
    numbers = np.unique(fixation[(mine == area) & (fixation >= 0)])
    return sum(int(2 * (mine[fixation == number] == area).sum() > (fixation == number).sum()) for number in numbers)
