"""The page of `trials`: the errors of every method on one scene, the surfaces in light, and what the confidences are
worth.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ipcli.geometry.surface import normals
from ipcli.report.fusion.accuracy import best
from ipcli.report.kit import curves, pictures
from ipcli.report.kit import provenance as origin
from ipcli.report.kit.numbers import aligned, number
from ipcli.report.kit.page import Markup, bar, columns_for, element, figure, gallery, section, table
from ipcli.report.kit.page import page as document
from ipcli.report.kit.pictures import WIDEST, draw
from ipcli.report.kit.surface import SHADE, shade

SHOWN = 6  # lines of a plot that can still be told apart
MARGIN = 0.06  # of the scene's extent, around it


def page(arrays: Mapping[str, np.ndarray], provenance: Mapping[str, Any], *, widest: int = WIDEST) -> str:
    """The HTML of `trials` artefact."""
    views = (provenance.get("inputs") or [{}])[0].get("name", "a scene")
    return document(
        f"Methods of fusion on {str(views).split('.')[0]}",
        "ipcli evaluate-fusion",
        _verdict(arrays),
        section(
            "Errors", error_table(arrays), lead="All on the pixels that every map has; the best of each column in bold."
        ),
        section(
            "Surfaces",
            surfaces(arrays, widest),
            lead="Every map in the same light; below, its error, on the scale of the fused maps. Hatched: not known.",
        ),
        section("What the confidence is worth", sparsification(arrays), lead=SPARSIFICATION),
        origin.origin(provenance),
    )


SPARSIFICATION = (
    "Mean error of the pixels kept when the least trusted are dropped, in mean errors of all: the lower, the better "
    "it is known where the map "
    "errs. Dashed: the best order there is. The area between a curve and that one is the AUSE of the table."
)
ORDERS = {
    "kept_error_uncertainty": "by uncertainty",
    "kept_error": "by confidence",
    "kept_error_angle": "by angle of view",
}


def _verdict(arrays: Mapping[str, np.ndarray]) -> str:
    columns, labels = [str(name) for name in arrays["columns"]], row_names(arrays)
    errors = arrays["values"][:, columns.index("RMSE")]
    first = int(np.nanargmin(errors))
    median = float(errors[labels.index("median")])
    return (
        f"Least RMSE: {number(float(errors[first]))} by {labels[first]}; the median has {number(median)} (in "
        f"{arrays['unit']})"
    )


def row_names(arrays: Mapping[str, np.ndarray]) -> list[str]:
    """The rows as `compare` names them."""
    rows = zip(arrays["methods"], arrays["rules"], strict=True)
    return [f"{method}, tuned λ" if str(rule) == "tuned" else str(method) for method, rule in rows]


def error_table(arrays: Mapping[str, np.ndarray]) -> Markup:
    """A row for each method and lambda."""
    columns = [str(name) for name in arrays["columns"]]
    cells = [aligned(column) for column in arrays["values"].T]
    lambdas = [number(float(lam)) for lam in arrays["lambdas"]]
    rows = [(name, lambdas[r], *(column[r] for column in cells)) for r, name in enumerate(row_names(arrays))]
    bold = {(row, column + 1) for row, column in best(arrays["values"], columns)}
    return table(("", "λ", *columns), rows, bold=bold)


def surfaces(arrays: Mapping[str, np.ndarray], widest: int) -> Markup:
    """The kept maps and the truth in light, and the errors of the maps, cut to where the truth is known."""
    window, names = extent(arrays["truth"]), [str(name) for name in arrays["maps"]]
    errors = [np.abs(depth - arrays["truth"])[window] for depth in arrays["depth"]]
    scale = pictures.from_zero(errors[names.index("median") + 1 :] or errors, "magma", str(arrays["unit"]))
    lit = [
        lights(depth, arrays["truth"], arrays["intrinsics"])[window] for depth in (*arrays["depth"], arrays["truth"])
    ]
    widest = min(widest, 420)
    shown = [figure(draw(light, SHADE, widest), name) for light, name in zip(lit, [*names, "truth"], strict=True)]
    below = [figure(draw(error, scale, widest), f"{name}: error") for error, name in zip(errors, names, strict=True)]
    columns = columns_for(lit[0].shape[1] / lit[0].shape[0], len(shown), small=True)
    galleries = [gallery(*figures, columns=columns, small=True) for figures in (shown, below)]
    return Markup("".join(galleries) + element("div", bar(scale), class_="shared"))


def lights(depth: np.ndarray, truth: np.ndarray, intrinsics: np.ndarray) -> np.ndarray:
    """Brightness (h, w) of a depth map where the truth is known, NaN elsewhere."""
    return np.where(np.isfinite(truth), shade(normals(depth, intrinsics), intrinsics), np.nan)


def extent(truth: np.ndarray) -> tuple[slice, slice]:
    """Rows and columns of the bounding box of what is known, with a margin; everything if nothing is."""
    known, spans = np.isfinite(truth), []
    for axis in (1, 0):
        found = np.flatnonzero(known.any(axis=axis))
        low, high = (found[0], found[-1] + 1) if found.size else (0, known.shape[1 - axis])
        margin = round(MARGIN * (high - low))
        spans.append(slice(max(0, low - margin), high + margin))
    return spans[0], spans[1]


def sparsification(arrays: Mapping[str, np.ndarray]) -> Markup:
    """The curves of the kept methods at the automatic lambda."""
    shares = np.linspace(100 / arrays["kept_error"].shape[1], 100, arrays["kept_error"].shape[1])
    rows = [
        row
        for row, (name, rule) in enumerate(zip(arrays["methods"], arrays["rules"], strict=True))
        if str(rule) == "automatic"
        and str(name) in map(str, arrays["maps"])
        and np.isfinite(arrays["kept_error"][row]).all()
    ][:SHOWN]
    return element(
        "div", *(_sparsification(str(arrays["methods"][row]), arrays, row, shares) for row in rows), class_="plots"
    )


def _sparsification(name: str, arrays: Mapping[str, np.ndarray], row: int, shares: np.ndarray) -> Markup:
    lines = [
        *(curves.Series(order, shares, arrays[field][row]) for field, order in ORDERS.items() if field in arrays),
        curves.Series("best order", shares, arrays["least_error"][row], dashed=True),
    ]
    return curves.plot(
        lines, name, "share of pixels kept, %", "error, mean errors", from_zero=True, width=400, height=260
    )
