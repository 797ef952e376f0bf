"""Map, head path and points of regard from two sides, as SVG."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ipcli.report.kit.numbers import nice_step, with_unit
from ipcli.report.kit.page import Markup, element

SIZE = (520, 420)  # pixels of a drawing
POINTS = 1800  # most of the map that are drawn
REGARDS = 400


def from_above(a: Mapping[str, np.ndarray]) -> Markup:
    """x to the right, z upwards."""
    return _drawing(a, 0, 2, 1.0, "From above", "x to the right, z up the page")


def from_the_side(a: Mapping[str, np.ndarray]) -> Markup:
    """z to the right, y (which points down) downwards."""
    return _drawing(a, 2, 1, -1.0, "From the side", "z to the right, y down the page")


def _drawing(a: Mapping[str, np.ndarray], across: int, up: int, sign: float, caption: str, note: str) -> Markup:
    path = a["world_from_rig"][:, :3, 3]
    regards = a["por/points"][a["por/outcome"] == "hit"] if "por/points" in a else np.empty((0, 3))
    flat = {
        name: _flat(points, across, up, sign)
        for name, points in (("map", a["map/points"]), ("path", path), ("por", regards))
    }
    known = flat["path"][np.isfinite(flat["path"]).all(axis=1)]
    bulk = np.concatenate([known, *(np.percentile(flat[n], (3, 97), axis=0) for n in ("map", "por") if len(flat[n]))])
    low, high = bulk.min(axis=0), bulk.max(axis=0)
    pad = 0.06 * max(float((high - low).max()), 1e-3)
    scale = min(SIZE[0] / (high[0] - low[0] + 2 * pad), SIZE[1] / (high[1] - low[1] + 2 * pad))
    corner = np.array([low[0] - pad, high[1] + pad])
    place = {name: (points - corner) * [scale, -scale] for name, points in flat.items()}
    drawn = [
        *_dots(place["map"], POINTS, 0.9, "#8a8f99"),
        *_dots(place["por"], REGARDS, 2.2, "#d63a3a"),
        *_line(place["path"]),
        *_ruler(scale),
    ]
    label = f"{caption}: {note}"
    svg = element("svg", *drawn, class_="plot", viewBox=f"0 0 {SIZE[0]} {SIZE[1]}", role="img", aria_label=label)
    return element("figure", svg, element("figcaption", element("b", caption), element("span", note)))


def _flat(points: np.ndarray, across: int, up: int, sign: float) -> np.ndarray:
    return points[:, [across, up]] * [1.0, sign]


def _dots(places: np.ndarray, most: int, radius: float, colour: str) -> list[Markup]:
    inside = places[((places >= 0) & (places <= SIZE)).all(axis=1)]
    chosen = inside[:: max(1, -(-len(inside) // most))]
    return [element("circle", cx=f"{x:.1f}", cy=f"{y:.1f}", r=radius, fill=colour) for x, y in chosen]


def _line(places: np.ndarray) -> list[Markup]:
    """The path; lost frames break it. A ring where it begins."""
    words, down = [], False
    for x, y in places:
        known = bool(np.isfinite(x + y))
        if known:
            words.append(f"{'L' if down else 'M'}{x:.1f} {y:.1f}")
        down = known
    start = places[np.isfinite(places).all(axis=1)][0]
    ring = element(
        "circle", cx=f"{start[0]:.1f}", cy=f"{start[1]:.1f}", r=5, fill="none", stroke="#2a5bd7", stroke_width=1.5
    )
    return [element("path", d="".join(words), fill="none", stroke="#2a5bd7", stroke_width=1.8), ring]


def _ruler(scale: float) -> list[Markup]:
    step = nice_step(SIZE[0] / scale, 5)
    length, y = step * scale, SIZE[1] - 10
    return [
        element("path", d=f"M12 {y}h{length:.1f}", class_="base"),
        element("text", with_unit(step, "m"), x=f"{16 + length:.1f}", y=y, dy="0.35em", class_="tick"),
    ]
