"""The page of a `comparison`: the mean of every measure over the scenes, and the scenes one by one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ipcli.report.fusion.accuracy import best
from ipcli.report.kit import curves
from ipcli.report.kit import provenance as origin
from ipcli.report.kit.numbers import aligned
from ipcli.report.kit.page import Markup, details, element, section, table
from ipcli.report.kit.page import page as document


def page(arrays: Mapping[str, np.ndarray], provenance: Mapping[str, Any], *, widest: int = 0) -> str:
    """The HTML of a `comparison` artefact; it has no pictures for `widest` to bound."""
    scenes, methods, columns = ([str(name) for name in arrays[field]] for field in ("scenes", "methods", "columns"))
    values = arrays["values"]
    return document(
        f"{len(methods)} methods on {len(scenes)} scene{'s' if len(scenes) > 1 else ''}",
        "ipcli compare",
        "The mean over the scenes of every measure of every method; lower is better, except for the density.",
        _means(methods, columns, values),
        _by_scene(scenes, methods, columns, values),
        origin.origin(provenance),
    )


def _means(methods: list[str], columns: list[str], values: np.ndarray) -> Markup:
    """Means and the spread over scenes; a method that was not run on all scenes is not comparable and gets no
    figures.
    """
    means, spread = values.mean(axis=0), values.std(axis=0)
    cells = [[f"{text}" for text in aligned(column)] for column in means.T]
    rows = [
        (name, *(_cell(cells[c][m], spread[m, c], len(values)) for c in range(len(columns))))
        for m, name in enumerate(methods)
    ]
    lead = "Best of each column in bold; behind each mean the standard deviation over the scenes."
    return section("Means over the scenes", table(("", *columns), rows, bold=best(means, columns)), lead=lead)


def _cell(mean: str, spread: float, count: int) -> Markup | str:
    if count == 1 or not np.isfinite(spread):
        return mean
    return element("span", mean, " ", element("small", f"± {spread:.2g}"))


def _by_scene(scenes: list[str], methods: list[str], columns: list[str], values: np.ndarray) -> Markup:
    """A plot and a folded table a measure."""
    order = np.arange(1, len(scenes) + 1, dtype=float)
    parts = []
    for c, column in enumerate(columns):
        lines = [
            curves.Series(name, order, values[:, m, c])
            for m, name in enumerate(methods)
            if np.isfinite(values[:, m, c]).any()
        ]
        if len(scenes) > 1 and lines:
            parts.append(curves.plot(lines, column, "scene", column, x_names=scenes))
        rows = list(zip(scenes, *(aligned(values[:, m, c]) for m in range(len(methods))), strict=True))
        parts.append(details(column, table(("scene", *methods), rows)))
    return section("Scene by scene", *parts, lead="Scenes in the order of the files.")
