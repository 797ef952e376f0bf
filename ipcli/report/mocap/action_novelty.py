"""The page of an `action-novelty`: how often none of these is said of actions that were left out, and of the others."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ipcli.report.kit import curves
from ipcli.report.kit import provenance as origin
from ipcli.report.kit.numbers import DASH, number, percent
from ipcli.report.kit.page import Markup, element, section, table
from ipcli.report.kit.page import page as document

CURVES = {"curve": "all scores", "surprise_curve": "surprise alone"}


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
    lost, caught, area = (_mean(arrays[name]) for name in ("lost", "caught", "area"))
    return (
        f"{_share(caught)} of the clips of an action that was not learnt were told as none, and {_share(lost)} of "
        f"the others were lost to it; area under the curve {_figure(area)}. Each action in turn was left out of all "
        f"that is learnt, and nobody who is asked about was learnt from ({arrays['people']}). Means over the actions."
    )


def _mean(values: np.ndarray) -> float:
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else float("nan")


def _curve(arrays: Mapping[str, np.ndarray]) -> Markup:
    lost, caught = (100 * _mean(arrays[name]) for name in ("lost", "caught"))
    series = []
    for field, name in CURVES.items():
        ring = (lost, caught) if field == "curve" and np.isfinite(lost + caught) else None
        dashed = field != "curve"
        series.append(curves.Series(name, 100 * arrays["levels"], 100 * arrays[field], dashed=dashed, ring=ring))
    drawn = curves.plot(
        series, "Unknown caught against known lost", "known lost, %", "unknown caught, %", from_zero=True
    )
    lead = (
        "Every threshold is a point of a curve: the share of the clips of learnt actions that are called none, and the "
        "share of those of the action left out that are. The ring is where decision.reject put it: a greater one loses "
        "fewer and catches fewer."
    )
    return section("Caught against lost", element("div", drawn, class_="beside"), lead=lead)


def _by_action(arrays: Mapping[str, np.ndarray]) -> Markup:
    rows = []
    for n, name in enumerate(arrays["left_out"]):
        mine = arrays["query_left_out"] == n
        count = int((mine & (arrays["truth"] == name)).sum())
        figures = (
            _share(arrays["caught"][n]),
            _share(arrays["lost"][n]),
            _figure(arrays["area"][n]),
            _figure(arrays["surprise_area"][n]),
        )
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
    missed = arrays["truth"] == arrays["left_out"][arrays["query_left_out"]]
    missed &= arrays["novelty"] <= arrays["threshold"]
    rows = []
    for name in arrays["left_out"]:
        taken, count = np.unique(arrays["best"][missed & (arrays["truth"] == name)], return_counts=True)
        order = np.argsort(-count, kind="stable")
        rows.append((str(name), int(count.sum()), ", ".join(f"{taken[i]} {count[i]}" for i in order)))
    return section("Not caught", table(("Left out", "Clips", "Taken for"), [row for row in rows if row[1]]))
