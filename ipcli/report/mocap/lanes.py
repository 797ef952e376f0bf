"""Segments of a long take on a time axis: a lane a class, what was recognised as bars, the truth as an outline."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from ipcli.report.kit.numbers import number, ticks
from ipcli.report.kit.page import Markup, element

LANE, BAR = 24, 12  # pixels
LETTER = 6.6  # pixels an average letter is wide
WIDTH = 1080


class Segment(NamedTuple):
    """From `start` to `end` seconds; how sure of it, from 0 to 1."""

    start: float
    end: float
    name: str
    share: float = 1.0


def lanes(found: Sequence[Segment], truth: Sequence[Segment], names: Sequence[str], title: str) -> Markup:
    """A lane for each of ``names``; the surer, the darker the bar."""
    left = 14 + LETTER * max(map(len, names), default=0)
    end = max((segment.end for segment in (*found, *truth)), default=1.0) or 1.0
    scale = (WIDTH - left - 24) / end
    place = {name: 28 + LANE * index for index, name in enumerate(names)}
    bottom = 28 + LANE * len(names)
    parts = [element("text", title, class_="title", x=0, y=14)]
    for value in ticks(0.0, end, 10):
        x = left + scale * value
        parts += [element("path", class_="grid", d=f"M{x:.1f} 24V{bottom}")]
        parts += [element("text", number(value, 6), class_="tick", x=f"{x:.1f}", y=bottom + 17, text_anchor="middle")]
    parts += [
        element(
            "text", "seconds", class_="label", x=f"{left + scale * end / 2:.1f}", y=bottom + 36, text_anchor="middle"
        )
    ]
    parts += [
        element("text", name, class_="tick", x=left - 8, y=y + LANE / 2, dy="0.35em", text_anchor="end")
        for name, y in place.items()
    ]
    parts += [_bar(one, left, scale, place[one.name], "true", 3) for one in truth if one.name in place]
    parts += [_bar(one, left, scale, place[one.name], "hit", (LANE - BAR) // 2) for one in found if one.name in place]
    view = f"0 0 {WIDTH} {bottom + 42}"
    return element("svg", *parts, class_="plot wide", viewBox=view, role="img", aria_label=title)


def _bar(segment: Segment, left: float, scale: float, y: float, kind: str, inset: int) -> Markup:
    words = f"{segment.name}, {number(segment.start, 4)} s to {number(segment.end, 4)} s"
    return element(
        "rect",
        element("title", words if kind == "true" else f"{words}, {100 * segment.share:.0f} %"),
        class_=kind,
        x=f"{left + scale * segment.start:.1f}",
        width=f"{max(scale * (segment.end - segment.start), 1.0):.1f}",
        y=f"{y + inset:.1f}",
        height=LANE - 2 * inset,
        rx=2,
        fill_opacity=f"{0.25 + 0.75 * segment.share:.2f}" if kind == "hit" else None,
    )
