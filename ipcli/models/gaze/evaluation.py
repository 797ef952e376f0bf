"""How good a run is where the truth is known: paths against paths, points of regard against targets, regions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ipcli.geometry.alignment import Fit, align, path_extent

QUANTILES = {0.68: 3.506, 0.95: 7.815}  # of chi^2 with three degrees of freedom


@dataclass(frozen=True, eq=False)
class PathErrors:
    """Errors of a path against the truth, metres: rigid alignment, with scale, and of the poses as known online."""

    rigid: Fit
    similar: Fit
    online: Fit | None


def path_errors(world_from_rig: np.ndarray, truth: np.ndarray, online: np.ndarray | None = None) -> PathErrors:
    """Poses (k, 4, 4) against true ones."""
    a, b = world_from_rig[:, :3, 3], truth[:, :3, 3]
    return PathErrors(
        align(a, b, with_scale=False),
        align(a, b, with_scale=True),
        None if online is None else align(online[:, :3, 3], b, with_scale=False),
    )


def registration(world_from_rig: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """truth_from_world (4, 4) by the first frame whose pose is known in both: how the thesis registers a subject."""
    known = np.isfinite(world_from_rig).all(axis=(1, 2)) & np.isfinite(truth).all(axis=(1, 2))
    first = int(known.argmax())
    return truth[first] @ np.linalg.inv(world_from_rig[first])


def target_errors(
    points: np.ndarray, covariances: np.ndarray, targets: np.ndarray, truth_from_world: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Distances (n,) in metres of points from their true places (n, 3), and squared Mahalanobis distances (n,)."""
    turn = truth_from_world[:3, :3]
    off = points @ turn.T + truth_from_world[:3, 3] - targets
    spread = turn @ covariances @ turn.T
    known = np.isfinite(off).all(axis=1) & np.isfinite(spread).all(axis=(1, 2))
    square = np.full(len(off), np.nan)
    solved = np.linalg.solve(spread[known] + 1e-14 * np.eye(3), off[known][..., None])[..., 0]
    square[known] = np.einsum("ni,ni->n", off[known], solved)
    return np.where(known, np.linalg.norm(off, axis=1), np.nan), square


def coverage(squares: np.ndarray) -> dict[float, float]:
    """Share of true points inside the 68 % and the 95 % region."""
    known = squares[np.isfinite(squares)]
    return {level: float((known <= limit).mean()) for level, limit in QUANTILES.items()}


def keyframe_scores(found: np.ndarray, true: np.ndarray, slack: int) -> dict[str, float]:
    """Agreement (recall, as the thesis has it), precision and F1 of keyframes (frame numbers).

    Matched one to one within `slack` frames.
    """
    free = list(found)
    hits = 0
    for frame in true:
        near = [other for other in free if abs(other - frame) <= slack]
        if near:
            free.remove(min(near, key=lambda other: abs(other - frame)))
            hits += 1
    recall = hits / len(true) if len(true) else float("nan")
    precision = hits / len(found) if len(found) else float("nan")
    total = len(found) + len(true)
    return {"agreement": recall, "precision": precision, "f1": 2 * hits / total if total else float("nan")}


def summary(a: Mapping[str, np.ndarray]) -> dict[str, object]:
    """The figures of a `gaze-experiment` that a person wants to see first."""
    length, farthest = path_extent(a["world_from_rig"])
    found: dict[str, object] = {
        "frames": len(a["lost"]),
        "lost": int(a["lost"].sum()),
        "in the map": int(a["in_map"].sum()),
        "path length [m]": float(f"{length:.4g}"),
        "farthest from the start [m]": float(f"{farthest:.4g}"),
        "subsequences": int(a["keyframe"].sum()),
        "disparity offset [px]": round(float(a["offset"]), 3),
    }
    if "por/outcome" in a:
        hit = a["por/outcome"] == "hit"
        found |= {"gaze samples": len(hit), "points of regard": int(hit.sum())}
        if hit.any():
            sigma = np.sqrt(np.trace(a["por/covariance"][hit], axis1=1, axis2=2))
            found["median sigma [m]"] = round(float(np.median(sigma)), 4)
    else:
        found["points of regard"] = "none, as no gaze is used"
    if "truth" in a:
        errors = path_errors(a["world_from_rig"], a["truth"])
        found |= {
            "error of the path [m]": round(errors.rigid.rmse, 4),
            "with scale [m]": round(errors.similar.rmse, 4),
            "scale": round(errors.similar.scale, 4),
        }
    return found
