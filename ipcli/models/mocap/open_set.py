"""How well known is told from unknown: what any threshold of novelty catches of the unknown and loses of the known."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

LEVELS = np.linspace(0.0, 1.0, 201)  # shares of known clips lost, at which curves are given


def figures(arrays: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The figures of the `action-novelty` artefact, by its answers: for each action left out what is lost and caught at
    the threshold and the area under the curve, and the mean curve; by all scores and by surprise alone.
    """
    parts = {score: _known_and_unknown(arrays, score) for score in ("novelty", "surprise")}
    above = [[_share_above(part, arrays["threshold"]) for part in both] for both in parts["novelty"]]
    lost, caught = np.array(above).reshape(-1, 2).T
    return {
        "lost": lost,
        "caught": caught,
        "area": np.array([area(*both) for both in parts["novelty"]]),
        "surprise_area": np.array([area(*both) for both in parts["surprise"]]),
        "levels": LEVELS,
        "curve": mean_curve(parts["novelty"]),
        "surprise_curve": mean_curve(parts["surprise"]),
    }


def area(known: np.ndarray, unknown: np.ndarray) -> float:
    """Chance that one of the unknown scores is higher than one of the known, ties half; NaN without either."""
    if not len(known) or not len(unknown):
        return float("nan")
    order = np.sort(known)
    below, upto = (np.searchsorted(order, unknown, side) for side in ("left", "right"))
    return float((below + upto).mean() / 2 / len(known))


def mean_curve(parts: list[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """Share of the unknown scores caught where LEVELS of the known are lost, the mean over pairs of known and unknown
    scores; NaN without a pair that has both.
    """
    found = []
    for known, unknown in parts:
        if len(known) and len(unknown):
            limits = np.append(np.sort(known)[::-1], -np.inf)
            found.append((unknown > limits[np.floor(LEVELS * len(known)).astype(int)][:, None]).mean(axis=1))
    return np.mean(found, axis=0) if found else np.full(len(LEVELS), np.nan)


def _share_above(scores: np.ndarray, limit: float | np.ndarray) -> float:
    return float((scores > limit).mean()) if len(scores) else float("nan")


def _known_and_unknown(arrays: Mapping[str, np.ndarray], score: str) -> list[tuple[np.ndarray, np.ndarray]]:
    """Scores of the known and of the unknown clips for each action left out; without a frame: as novel as can be."""
    scores = np.where(np.isfinite(arrays[score]), arrays[score], np.inf)
    found = []
    for left, name in enumerate(arrays["left_out"]):
        mine, strange = arrays["query_left_out"] == left, arrays["truth"] == name
        found.append((scores[mine & ~strange], scores[mine & strange]))
    return found
