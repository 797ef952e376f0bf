"""The frame of the world: that of named landmarks in place of the first picture's."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ipcli.errors import NoSolution
from ipcli.geometry import lens
from ipcli.geometry.alignment import Fit, align
from ipcli.measurements.recording import Landmarks

LEAST = 3  # landmarks
FLAT = 1e-3  # share of their extent by which they must leave a line
POINTS = ("map/points", "por/points", "por/origins", "fixations/points", "subsequences/points")
SPREADS = ("por/covariance", "fixations/covariance")

Arrays = dict[str, np.ndarray]


def laid_on(a: Arrays, landmarks: Landmarks, *, with_scale: bool) -> Arrays:
    """The experiment in the landmarks' frame, with fields `landmarks/...`. NoSolution for fewer than three seen, or all
    on one line.

    A landmark is where its marks' rays meet (two frames at least), else the median of the points of regard whose label
    is its name.
    """
    found = np.stack([_seen(a, landmarks, i) for i in range(len(landmarks.names))])
    known = np.isfinite(found).all(axis=1)
    if known.sum() < LEAST:
        names = [name for name, seen in zip(landmarks.names, known, strict=True) if not seen]
        raise NoSolution(
            f"only {known.sum()} of {len(known)} landmarks are seen, at least {LEAST} are needed; not seen: "
            f"{', '.join(names[:5])}. Mark them in two frames or more (frame, u [px], v [px]), or label the gaze"
        )
    for points in (found[known], landmarks.places[known]):
        extent = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
        if extent[1] < FLAT * extent[0] or extent[0] == 0:
            raise NoSolution("all landmarks of --world lie on one line: nothing holds the turn around it. Add another")
    fit = align(found, landmarks.places, with_scale=with_scale)
    return moved(a, fit) | {
        "landmarks/names": np.array(landmarks.names, dtype=np.str_).reshape(-1),
        "landmarks/places": landmarks.places,
        "landmarks/found": fit.scale * found @ fit.rotation.T + fit.translation,
        "landmarks/scale": np.float64(fit.scale),
    }


def moved(a: Mapping[str, np.ndarray], fit: Fit) -> Arrays:
    """The experiment in another world. What is in the head's own frame grows with the scale alone."""
    s, turn, shift = fit.scale, fit.rotation, fit.translation
    out = dict(a)
    for name in POINTS:
        if name in a:
            out[name] = s * a[name] @ turn.T + shift
    for name in SPREADS:
        if name in a:
            out[name] = s**2 * turn @ a[name] @ turn.T
    if "por/directions" in a:
        out["por/directions"] = a["por/directions"] @ turn.T
    for name in ("world_from_rig", "online"):
        out[name] = a[name].copy()
        out[name][:, :3, :3] = turn @ a[name][:, :3, :3]
        out[name][:, :3, 3] = s * a[name][:, :3, 3] @ turn.T + shift
    units = np.array([1.0, 1.0, 1.0, s, s, s])
    out["covariance"] = units[:, None] * a["covariance"] * units
    out["observer"] = s * a["observer"]
    out["subsequences/extent"] = s * a["subsequences/extent"]
    out["rig/cam_from_rig"] = a["rig/cam_from_rig"].copy()
    out["rig/cam_from_rig"][:, :3, 3] *= s
    return out


def _seen(a: Mapping[str, np.ndarray], landmarks: Landmarks, i: int) -> np.ndarray:
    """Where the run sees a landmark (3,), NaN where it does not."""
    marks = [(_frame(a, frame), u, v) for of, frame, u, v in landmarks.marks if of == i]
    marks = [mark for mark in marks if mark[0] >= 0 and not a["lost"][mark[0]]]
    if len(marks) > 1:
        return _meeting(a, marks)
    if "gaze/labels" in a:
        hit = (a["gaze/labels"] == landmarks.names[i]) & (a["por/outcome"] == "hit")
        if hit.any():
            return np.median(a["por/points"][hit], axis=0)
    return np.full(3, np.nan)


def _frame(a: Mapping[str, np.ndarray], name: str) -> int:
    """The frame of a name, or of the number that a table made of it (00012 and 12); -1 none."""
    names = [str(one) for one in a["names"]]
    if name in names:
        return names.index(name)
    numbers = [float(one) if one.isdecimal() else np.nan for one in names]
    wanted = float(name) if name.isdecimal() else np.nan
    return numbers.index(wanted) if wanted in numbers else -1


def _meeting(a: Mapping[str, np.ndarray], marks: list[tuple[int, float, float]]) -> np.ndarray:
    """The point (3,) nearest to the rays of marked pixels; NaN for rays that are all but parallel."""
    k = a["rig/intrinsics"][0]
    coefficients = a["rig/distortion"][0]
    coefficients = coefficients[np.isfinite(coefficients)]
    flat = lens.undistort(
        str(a["rig/models"][0]), coefficients, lens.normalised_of(np.array([mark[1:] for mark in marks]), k)
    )
    poses = a["world_from_rig"][[mark[0] for mark in marks]]
    rays = np.einsum("nij,nj->ni", poses[:, :3, :3], np.column_stack([flat, np.ones(len(flat))]))
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    across = np.eye(3) - rays[:, :, None] * rays[:, None]
    total = across.sum(axis=0)
    if np.linalg.eigvalsh(total)[0] < 1e-5:
        return np.full(3, np.nan)
    return np.linalg.solve(total, np.einsum("nij,nj->i", across, poses[:, :3, 3]))
