"""The page of an `action-novelty`: how often none of these is said of actions that were left out, and of the others."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ipcli.report.kit import curves
from ipcli.report.kit import provenance as origin
from ipcli.report.kit.numbers import DASH, number, percent
from ipcli.report.kit.page import Markup, element, section, table
from ipcli.report.kit.page import page as document

LEVELS = np.linspace(0.0, 1.0, 201)  # shares of known clips lost, at which curves are given
NAMES = {"novelty": "all scores", "surprise": "surprise alone"}


def page(arrays: Mapping[str, np.ndarray], provenance: Mapping[str, object], *, widest: int = 0) -> str:
    """The HTML of an `action-novelty` artefact; its figures are drawn, so there is nothing for ``widest`` to bound."""
    return document(
        f"Unknown actions: {len(arrays['left_out'])} actions, each left out in turn",
        "ipcli mocap-evaluate",
        _verdict(arrays),
        _curve(arrays),
        _by_action(arrays),
        _taken_for(arrays),
        origin.origin(provenance),
    )


def _verdict(arrays: Mapping[str, np.ndarray]) -> str:
    lost, caught = _mean(shares(arrays))
    area = float(_mean(areas(arrays)))
    return (
        f"{percent(caught)} of the clips of an action that was not learnt were told as none, and {percent(lost)} of "
        f"the others were lost to it; area under the curve {_figure(area)}. Each action in turn was left out of all "
        f"that is learnt, and nobody who is asked about was learnt from ({arrays['people']}). Means over the actions."
    )


def _mean(values: np.ndarray) -> np.ndarray:
    known = values[np.isfinite(values).reshape(len(values), -1).all(axis=1)]
    return known.mean(axis=0) if len(known) else np.full(values.shape[1:], np.nan)


def _curve(arrays: Mapping[str, np.ndarray]) -> Markup:
    series = []
    for score, name in NAMES.items():
        lost, caught = _mean(shares(arrays, score))
        ring = (100 * float(lost), 100 * float(caught)) if score == "novelty" and np.isfinite(lost + caught) else None
        line = curve(arrays, score)
        series.append(curves.Series(name, 100 * LEVELS, 100 * line, dashed=score == "surprise", ring=ring))
    drawn = curves.plot(
        series, "Unknown caught against known lost", "known lost, %", "unknown caught, %", from_zero=True
    )
    lead = (
        "Every threshold is a point of a curve: the share of the clips of learnt actions that are called none, and the "
        "share of those of the action left out that are. The ring is the default (decision.reject moves it: 0.99 "
        "loses fewer and catches fewer)."
    )
    return section("Caught against lost", element("div", drawn, class_="beside"), lead=lead)


def _by_action(arrays: Mapping[str, np.ndarray]) -> Markup:
    area, plain, told = areas(arrays), areas(arrays, "surprise"), shares(arrays)
    rows = []
    for n, name in enumerate(arrays["left_out"]):
        mine = arrays["query_left_out"] == n
        count = int((mine & (arrays["truth"] == name)).sum())
        figures = (_share(told[n, 1]), _share(told[n, 0]), _figure(area[n]), _figure(plain[n]))
        rows.append((str(name), count, *figures))
    columns = ("Left out", "Clips", "Caught", "Others lost", "Area", "Area by surprise")
    lead = "The area is the chance that a clip of the action is more novel than one of the others; 0.5 is guessing."
    return section("Actions", table(columns, rows), lead=lead)


def _share(value: float) -> str:
    return percent(float(value)) if np.isfinite(value) else DASH


def _figure(value: float) -> str:
    return number(float(value)) if np.isfinite(value) else DASH


def _taken_for(arrays: Mapping[str, np.ndarray]) -> Markup:
    """What the actions left out are taken for, where they are not caught."""
    limit = arrays["threshold"][arrays["query_left_out"]]
    missed = (arrays["truth"] == arrays["left_out"][arrays["query_left_out"]]) & (arrays["novelty"] <= limit)
    rows = []
    for name in arrays["left_out"]:
        taken, count = np.unique(arrays["best"][missed & (arrays["truth"] == name)], return_counts=True)
        order = np.argsort(-count, kind="stable")
        rows.append((str(name), int(count.sum()), ", ".join(f"{taken[i]} {count[i]}" for i in order)))
    return section("Not caught", table(("Left out", "Clips", "Taken for"), [row for row in rows if row[1]]))


def areas(arrays: Mapping[str, np.ndarray], score: str = "novelty") -> np.ndarray:
    """Chance (s,) that a clip of the action left out has a higher score than a clip of another; NaN without either."""
    return np.array([area(*_parts(arrays, score, left)) for left in range(len(arrays["left_out"]))])


def area(known: np.ndarray, unknown: np.ndarray) -> float:
    """Chance that one of the unknown scores is higher than one of the known, ties half; NaN without either."""
    if not len(known) or not len(unknown):
        return float("nan")
    order = np.sort(known)
    below, upto = (np.searchsorted(order, unknown, side) for side in ("left", "right"))
    return float((below + upto).mean() / 2 / len(known))


def shares(arrays: Mapping[str, np.ndarray], score: str = "novelty") -> np.ndarray:
    """Share (s, 2) of the known clips lost and of the unknown caught, at the default, for each action left out."""
    limits = arrays["threshold" if score == "novelty" else "surprise_threshold"]
    each = [_parts(arrays, score, left) for left in range(len(arrays["left_out"]))]
    return np.array(
        [
            [(part > limit).mean() if len(part) else np.nan for part in both]
            for both, limit in zip(each, limits, strict=True)
        ]
    )


def curve(arrays: Mapping[str, np.ndarray], score: str = "novelty") -> np.ndarray:
    """Share of the unknown caught where LEVELS of the known are lost, the mean over the actions left out."""
    found = []
    for left in range(len(arrays["left_out"])):
        known, unknown = _parts(arrays, score, left)
        if len(known) and len(unknown):
            limits = np.append(np.sort(known)[::-1], -np.inf)
            found.append((unknown > limits[np.floor(LEVELS * len(known)).astype(int)][:, None]).mean(axis=1))
    return np.mean(found, axis=0) if found else np.full(len(LEVELS), np.nan)


def _parts(arrays: Mapping[str, np.ndarray], score: str, left: int) -> tuple[np.ndarray, np.ndarray]:
    """Scores of the known and of the unknown clips when an action is left out; without a frame: as novel as can be."""
    mine = arrays["query_left_out"] == left
    scores = np.where(np.isfinite(arrays[score]), arrays[score], np.inf)
    strange = arrays["truth"] == arrays["left_out"][left]
    return scores[mine & ~strange], scores[mine & strange]
