"""Line plots as SVG, in the colours of the page, light or dark."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, floor, log10

import numpy as np

from ipcli.report.kit.numbers import log_ticks, number, power_of_ten, ticks
from ipcli.report.kit.page import Markup, element

LEFT, RIGHT, TOP, BOTTOM = 58, 14, 46, 42  # pixels around the plotting area
NAME_WIDTH, NAME_LETTERS = 84, 13  # pixels that a name on the axis may take, and letters
COLOURS = 6  # after which they come again, the lines dotted
LEGEND_LETTER = 6.4  # pixels an average letter of the legend is wide


@dataclass(frozen=True)
class Series:
    """A named line; ``dashed`` for what is only there to compare with, ``dots`` where points are few and count,
    ``ring`` for a point (x, y) to mark, on the line or off it.
    """

    name: str
    x: np.ndarray
    y: np.ndarray
    dashed: bool = False
    dots: bool = False
    ring: tuple[float, float] | None = None


@dataclass(frozen=True)
class Axis:
    """One axis: its label, its limits, whether it is logarithmic, and its length in pixels."""

    label: str
    low: float
    high: float
    log: bool
    length: float

    def position(self, values: np.ndarray | float) -> np.ndarray:
        """Pixels from the start of the axis; NaN where a logarithmic axis has no place for a value."""
        values = np.asarray(values, dtype=float)
        if not self.log:
            return (values - self.low) / (self.high - self.low) * self.length
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.log(np.where(values > 0, values, np.nan) / self.low) / np.log(self.high / self.low) * self.length

    def ticks(self) -> list[float]:
        count = max(2, int(self.length / (70 if self.length > 260 else 34)))
        return log_ticks(self.low, self.high, count) if self.log else ticks(self.low, self.high, count)


def plot(
    series: Sequence[Series],
    title: str,
    x_label: str,
    y_label: str,
    *,
    log_x: bool = False,
    log_y: bool = False,
    from_zero: bool = False,
    width: int = 560,
    height: int = 300,
    x_names: Sequence[str] = (),
) -> Markup:
    """A plot of lines with ticks, labels and a legend. A point without a place on the axes breaks its line. `x_names`
    stand at 1, 2, 3, ... in place of the numbers.
    """
    rings = np.array([line.ring for line in series if line.ring]).reshape(-1, 2)
    x = _axis([*(line.x for line in series), rings[:, 0]], x_label, log_x, False, width - LEFT - RIGHT, rounded=False)
    y = _axis(
        [*(line.y for line in series), rings[:, 1]], y_label, log_y, from_zero, height - TOP - BOTTOM, rounded=True
    )
    area = element(
        "g",
        *_grid(x, y, x_names),
        *(_line(line, index, x, y) for index, line in enumerate(series)),
        transform=f"translate({LEFT} {TOP})",
    )
    heading = element("text", title, class_="title", x=LEFT, y=16)
    legend = _legend(series, width) if len(series) > 1 else ""
    return element(
        "svg", heading, legend, area, class_="plot", viewBox=f"0 0 {width} {height}", role="img", aria_label=title
    )


def _axis(arrays: Sequence[np.ndarray], label: str, log: bool, zero: bool, length: float, *, rounded: bool) -> Axis:
    values = np.concatenate([np.ravel(array) for array in arrays]) if arrays else np.empty(0)
    values = values[np.isfinite(values) & ((values > 0) if log else True)]
    low, high = (float(values.min()), float(values.max())) if values.size else (1.0, 10.0)
    low = min(low, 0.0) if zero and not log else low
    if high <= low:
        low, high = (low / 2, high * 2) if log else (low - (abs(low) or 1) / 2, high + (abs(high) or 1) / 2)
    if rounded and log:
        low, high = _half_decades(low, high)
    elif rounded:
        margin = 0.04 * (high - low)
        low, high = (low if zero and low == 0 else low - margin), high + margin
    return Axis(label, low, high, log, length)


def _half_decades(low: float, high: float) -> tuple[float, float]:
    return 10 ** (floor(2 * log10(low) + 1e-9) / 2), 10 ** (ceil(2 * log10(high) - 1e-9) / 2)


def _grid(x: Axis, y: Axis, x_names: Sequence[str] = ()) -> list[Markup]:
    """Tick lines with their numbers, the two axis labels, and the base line."""
    parts, power = [], 0 if y.log else power_of_ten(y.ticks())
    every = -(-len(x_names) * NAME_WIDTH // int(x.length)) or 1  # so many-th names have room
    named = {n + 1.0: _cut(name) for n, name in enumerate(x_names) if n % every == 0}
    for value, text in (named or {value: number(value, 6) for value in x.ticks()}).items():
        at = _short(x.position(value))
        parts += [element("path", class_="grid", d=f"M{at} 0V{y.length}")]
        parts += [element("text", text, class_="tick", x=at, y=y.length + 17, text_anchor="middle")]
    for value in y.ticks():
        at = _short(y.length - y.position(value))
        parts += [element("path", class_="grid", d=f"M0 {at}H{x.length}")]
        parts += [
            element("text", number(value / 10.0**power, 6), class_="tick", x=-8, y=at, dy="0.35em", text_anchor="end")
        ]
    parts += [element("path", class_="base", d=f"M0 {y.length}H{x.length}")]
    parts += [element("text", x.label, class_="label", x=x.length / 2, y=y.length + 36, text_anchor="middle")]
    label = y.label + (f", {number(10.0**power, 1).removeprefix('1×')}" if power else "")
    turned = f"translate({12 - LEFT} {y.length / 2}) rotate(-90)"
    return parts + [element("text", label, class_="label", transform=turned, text_anchor="middle")]


def _cut(name: str) -> str:
    return name if len(name) <= NAME_LETTERS else f"{name[: NAME_LETTERS - 1]}…"


def _line(line: Series, index: int, x: Axis, y: Axis) -> Markup:
    points = np.stack([x.position(line.x), y.length - y.position(line.y)], axis=1)
    path, pen_down = [], False
    for point in points:
        drawn = bool(np.isfinite(point).all())
        if drawn:
            path.append(f"{'L' if pen_down else 'M'}{_short(point[0])} {_short(point[1])}")
        pen_down = drawn
    kind = _kind(line, index)
    marks = [
        element("circle", class_=f"dot s{index % COLOURS}", cx=_short(px), cy=_short(py), r=2.6)
        for px, py in points
        if line.dots and np.isfinite(px + py)
    ]
    if line.ring:
        px, py = _short(x.position(line.ring[0])), _short(y.length - y.position(line.ring[1]))
        marks.append(element("circle", class_=f"line s{index % COLOURS}", cx=px, cy=py, r=6))
    return element("g", element("path", class_=kind, d="".join(path)), *marks)


def _kind(line: Series, index: int) -> str:
    """The classes of a line: colours come again after the sixth, but then the lines are dotted, then dash-dotted."""
    again = ("", " again", " third")[min(index // COLOURS, 2)]
    return f"line s{index % COLOURS}" + (" dashed" if line.dashed else again)


def _legend(series: Sequence[Series], width: float) -> Markup:
    """Names with a stroke of their lines; what does not fit into the first row goes to a second one."""
    lengths = [24 + LEGEND_LETTER * len(line.name) + 18 for line in series]
    at, y = float(LEFT), 32 if LEFT + sum(lengths) <= width else 28
    parts = []
    for index, (line, length) in enumerate(zip(series, lengths, strict=True)):
        if at > LEFT and at + length - 18 > width:
            at, y = float(LEFT), y + 13
        kind = _kind(line, index)
        parts += [element("path", class_=kind, d=f"M{_short(at)} {y}h18")]
        parts += [element("text", line.name, class_="tick", x=_short(at + 24), y=y, dy="0.35em")]
        at += length
    return element("g", *parts)


def _short(value: float | np.ndarray) -> str:
    """A coordinate with at most one decimal: pixels need no more."""
    return f"{float(value):.1f}".removesuffix(".0")
