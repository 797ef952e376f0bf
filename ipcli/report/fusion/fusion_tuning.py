"""The page of a `tuning`: error against lambda for every method, the best lambda and the automatic one marked."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ipcli.measurements.accuracy import mean_over_scenes
from ipcli.report.kit import provenance as origin
from ipcli.report.kit.curves import Series, plot
from ipcli.report.kit.numbers import number
from ipcli.report.kit.page import Markup, element, section, table
from ipcli.report.kit.page import page as document

WITHIN = 1.1  # times the error at the best lambda is close enough for the automatic one


def page(arrays: Mapping[str, np.ndarray], provenance: Mapping[str, Any], *, widest: int = 0) -> str:
    """The HTML of a `tuning` artefact; it has no pictures for `widest` to bound."""
    methods, scenes = ([str(name) for name in arrays[field]] for field in ("methods", "scenes"))
    values, automatic = measured(arrays)
    ratios = automatic / values.min(axis=1)
    close = int((ratios <= WITHIN).sum())
    verdict = (
        f"The automatic λ comes within 10 % of the best λ of the grid for {close} of {len(methods)} methods, in "
        f"{arrays['measure']}."
    )
    several = f"{len(scenes)} scenes ({', '.join(scenes)})" if len(scenes) > 1 else f"the scene {scenes[0]}"
    lead = f"{arrays['measure']}, on average over {several}. Rings: the automatic λ."
    return document(
        "The weight λ of the data",
        "ipcli tune-fusion",
        verdict,
        section("Error against λ", element("div", *plots(arrays, values, automatic), class_="plots"), lead=lead),
        section(
            "The best and the automatic λ", best_table(arrays, values, automatic), lead=f"On average over {several}."
        ),
        origin.origin(provenance),
    )


def measured(arrays: Mapping[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Means over the scenes of the measure that was tuned: (m, n) over the grid, and (m,) at the automatic lambda."""
    columns = [str(name) for name in arrays["columns"]]
    chosen = columns.index(str(arrays["measure"]))
    values, automatic = (mean_over_scenes(arrays[field], columns)[..., chosen] for field in ("values", "automatic"))
    return values, automatic


def plots(arrays: Mapping[str, np.ndarray], values: np.ndarray, automatic: np.ndarray) -> list[Markup]:
    """A plot for each method, its algorithms as lines."""
    families: dict[str, list[int]] = {}
    for index, label in enumerate(map(str, arrays["methods"])):
        families.setdefault(label.partition(" (")[0], []).append(index)
    marks = np.exp(np.log(arrays["automatic_lambda"]).mean(axis=0))
    drawn = []
    for family, members in families.items():
        names = [str(arrays["methods"][m]).removeprefix(family).strip(" ()") or family for m in members]
        lines = [
            Series(name, arrays["lambdas"], values[m], dots=True, ring=(float(marks[m]), float(automatic[m])))
            for name, m in zip(names, members, strict=True)
        ]
        drawn.append(
            plot(lines, family, "λ", str(arrays["measure"]), log_x=True, from_zero=True, width=400, height=260)
        )
    return drawn


def best_table(arrays: Mapping[str, np.ndarray], values: np.ndarray, automatic: np.ndarray) -> Markup:
    """A row for each method; those whose best lambda lies at an end of the grid are marked."""
    rows, warn = [], {}
    for m, method in enumerate(map(str, arrays["methods"])):
        least, own = float(values[m].min()), arrays["automatic_lambda"][:, m]
        span = (
            number(float(own[0]))
            if np.ptp(own) < 1e-3 * own[0]
            else f"{number(float(own.min()))} to {number(float(own.max()))}"
        )
        best = float(arrays["best"][m])
        if best in (arrays["lambdas"][0], arrays["lambdas"][-1]):
            warn[m] = "the best λ lies at an end of the grid"
        rows.append(
            (
                method,
                number(best),
                number(least),
                span,
                number(float(automatic[m])),
                number(float(automatic[m]) / least, 3),
            )
        )
    columns = ("", "best λ", f"{arrays['measure']} there", "automatic λ", f"{arrays['measure']} there", "ratio")
    note = element(
        "p", "Marked rows: the best λ lies at an end of the grid, so a better one may lie beyond.", class_="lead"
    )
    return Markup(table(columns, rows, warn=warn) + (note if warn else ""))
