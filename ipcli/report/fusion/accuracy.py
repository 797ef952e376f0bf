"""How far maps are from the truth: error maps on one scale, metrics, and what the confidence is worth."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ipcli.measurements.accuracy import sparsification_curve
from ipcli.report.kit import curves, pictures
from ipcli.report.kit.numbers import aligned, number, percent, with_unit
from ipcli.report.kit.page import Markup, bar, element, figure, gallery, section, table
from ipcli.report.kit.pictures import draw

CANDIDATES = {"reference": "Reference view", "mean": "Mean", "median": "Median", "depth": "Fused"}
HIGHER_IS_BETTER = ("density", "valid", "share", "within", "complete", "observed")  # words in the name of a metric


def error(arrays: Mapping[str, np.ndarray], name: str) -> np.ndarray:
    """Absolute error (h, w) of one of the maps; NaN where it or the truth is not known."""
    return np.abs(arrays[name] - arrays["truth"])


def maps(arrays: Mapping[str, np.ndarray], unit: str, widest: int) -> Markup:
    """The section of error maps, of the signed error of the fused map, and of the sparsification curve."""
    height, width = arrays["depth"].shape
    errors = {name: error(arrays, name) for name in CANDIDATES}
    scale = pictures.from_zero([errors["median"]], "magma", unit)
    shown = [
        figure(draw(error, scale, min(widest, 400)), CANDIDATES[name], _mean(error, unit))
        for name, error in errors.items()
    ]
    signed = arrays["depth"] - arrays["truth"]
    around = pictures.symmetric([signed], unit)
    side = figure(
        draw(signed, around, min(widest, 480)), "Fused minus truth", "blue: too near, red: too far", scale=around
    )
    columns = 4 if width < 1.9 * height else 2
    return section(
        "Against the truth",
        gallery(*shown, columns=columns),
        element("div", bar(scale), class_="shared"),
        element(
            "div",
            element("div", side, class_="half"),
            element("div", _sparsification(arrays["confidence"], errors["depth"], unit), *_ause(arrays), class_="half"),
            class_="plots",
        ),
        lead="Absolute error of each map on one scale, up to the 99th percentile of the median's.",
    )


def _mean(error: np.ndarray, unit: str) -> str:
    known = error[np.isfinite(error)]
    return (
        f"mean {with_unit(float(known.mean()), unit)} on {percent(known.size / error.size)} of the pixels"
        if known.size
        else "no pixel in common"
    )


def _sparsification(confidence: np.ndarray, error: np.ndarray, unit: str) -> Markup:
    """Mean error of what is left when the least confident pixels are dropped, beside the best order there is."""
    known = np.isfinite(error) & np.isfinite(confidence)
    thinning = max(1, np.count_nonzero(known) // 100_000)  # a curve of 60 points needs no more
    error, confidence = error[known][::thinning], confidence[known][::thinning]
    if not error.size:
        return element("p", "No pixel has both a confidence and a truth.", class_="lead")
    share, kept = sparsification_curve(error, -confidence)
    _, best = sparsification_curve(error, error)
    lines = [
        curves.Series("by confidence", share, kept),
        curves.Series("by the error itself", share, best, dashed=True),
        curves.Series("at random", share, np.full(len(share), error.mean()), dashed=True),
    ]
    return curves.plot(
        lines,
        "Is the confidence right? Error of the most confident pixels",
        "share of pixels kept, %",
        f"mean error, {unit}" if unit else "mean error",
        from_zero=True,
    )


def _ause(arrays: Mapping[str, np.ndarray]) -> list[Markup]:
    """The area between the curves, which the artefact holds, in words."""
    if "ause" not in arrays:
        return []
    own, angle = (number(float(arrays[name]), 2) for name in ("ause", "ause_angle"))
    words = (
        f"Area between the first two curves, over all observed pixels and in mean errors: {own}; by the angle of view "
        f"(4.35): {angle}."
    )
    return [element("p", words, class_="lead")]


def metrics(a: Mapping[str, np.ndarray]) -> Markup:
    """The section with the table of error measures that the artefact holds."""
    values, columns = a["metrics"], [str(name) for name in a["metric_columns"]]
    rows = list(zip(map(str, a["metric_rows"]), *(aligned(column) for column in values.T), strict=True))
    return section(
        "Metrics", table(("", *columns), rows, bold=best(values, columns)), lead="The best of each column in bold."
    )


def best(values: np.ndarray, columns: list[str]) -> set[tuple[int, int]]:
    """Table cells (row, column) of the best value of each metric, ties included; column 0 holds the names."""
    signs = np.array([-1 if any(word in name.lower() for word in HIGHER_IS_BETTER) else 1 for name in columns])
    signed = np.where(np.isfinite(values), values * signs, np.inf)
    winners = (signed == signed.min(axis=0, initial=np.inf)) & np.isfinite(signed)
    return {(int(row), int(column) + 1) for row, column in np.argwhere(winners)}
