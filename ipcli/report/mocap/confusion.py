"""What was taken for what: the matrix of confusions (thesis figure 5.5) and the answers a class got (figure 5.3), as
SVG.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ipcli.report.kit.numbers import percent
from ipcli.report.kit.page import Markup, element

CELL = 40  # pixels of a cell
LETTER, TITLE_LETTER = 6.6, 8.2  # pixels an average letter of a label, of a title, is wide
BAR, PANEL = 12, 74  # width of a bar and height of a panel in pixels
LEAST = 0.005  # share of a row below which a cell stays blank


def matrix(counts: np.ndarray, rows: Sequence[str], columns: Sequence[str], title: str) -> Markup:
    """Rows (r,) are the truth, columns (c,) the answers; each cell is shaded and labelled by its share of the row, in
    percent.

    ``counts`` (r, c) are numbers of frames or clips. A class without any has an empty row.
    """
    total = counts.sum(axis=1, keepdims=True)
    shares = counts / np.where(total > 0, total, 1)
    left, top = 16 + LETTER * max(map(len, rows), default=0), 30 + 0.72 * LETTER * max(map(len, columns), default=0)
    parts = [element("text", title, class_="title", x=0, y=14)]
    parts += [_above(name, left + (c + 0.5) * CELL, top - 8) for c, name in enumerate(columns)]
    for r, name in enumerate(rows):
        y = top + r * CELL
        parts += [element("text", name, class_="tick", x=left - 8, y=y + CELL / 2, dy="0.35em", text_anchor="end")]
        parts += [
            _cell(shares[r, c], int(counts[r, c]), left + c * CELL, y, name == other) for c, other in enumerate(columns)
        ]
    right = left + len(columns) * CELL
    parts += [
        element("text", f"n = {int(total[r, 0])}", class_="tick", x=right + 8, y=top + (r + 0.5) * CELL, dy="0.35em")
        for r in range(len(rows))
    ]
    lean = 0.72 * LETTER * len(columns[-1]) if len(columns) else 0
    width, height = right + max(64.0, lean), top + len(rows) * CELL + 4
    return element(
        "svg",
        *parts,
        class_="plot matrix",
        viewBox=f"0 0 {width:.0f} {height:.0f}",
        style=f"max-width:{width:.0f}px",
        role="img",
        aria_label=title,
    )


def _above(name: str, x: float, y: float) -> Markup:
    return element("text", name, class_="tick", transform=f"translate({x:.1f} {y:.1f}) rotate(-45)")


def _cell(share: float, count: int, x: float, y: float, right: bool) -> Markup:
    """Blank but for its border where nearly nothing is; what a reader hovers over tells the count."""
    kind = "hit" if right else "miss"
    box = element("rect", x=f"{x:.1f}", y=f"{y:.1f}", width=CELL - 2, height=CELL - 2, rx=2, class_="cell")
    if share < LEAST:
        return box
    fill = element(
        "rect",
        x=f"{x:.1f}",
        y=f"{y:.1f}",
        width=CELL - 2,
        height=CELL - 2,
        rx=2,
        class_=kind,
        fill_opacity=f"{0.12 + 0.88 * share:.2f}",
    )
    text = "100" if share == 1 else f"{min(100 * share, 99.9):.3g}" if share > 0.99 else f"{100 * share:.0f}"
    label = element(
        "text",
        text,
        class_="inside strong" if share > 0.55 else "inside",
        x=x + CELL / 2 - 1,
        y=y + CELL / 2 - 1,
        dy="0.35em",
    )
    return element("g", element("title", f"{count}, {percent(share)}"), box, fill, label)


def histogram(counts: np.ndarray, names: Sequence[str], truth: str) -> Markup:
    """A panel of figure 5.3: how often each class was the answer where ``truth`` was right; its own bar stands out.

    Bars are numbered from 1 in the order of the names.
    """
    total = max(int(counts.sum()), 1)
    width = max(BAR * 1.5 * len(names) + 8, TITLE_LETTER * len(truth) + 8)
    parts = [element("text", truth, class_="title", x=0, y=13)]
    for index, (count, name) in enumerate(zip(counts, names, strict=True)):
        x, tall = 4 + 1.5 * BAR * index, PANEL * count / total
        bar = element(
            "rect",
            x=f"{x:.1f}",
            y=f"{22 + PANEL - tall:.1f}",
            width=BAR,
            height=f"{tall:.1f}",
            class_="hit" if name == truth else "miss",
        )
        number = element("text", index + 1, class_="tick", x=f"{x + BAR / 2:.1f}", y=PANEL + 36, text_anchor="middle")
        parts += [element("g", element("title", f"{name}: {int(count)}, {percent(count / total)}"), bar, number)]
    parts += [element("path", class_="base", d=f"M0 {22 + PANEL}H{width:.0f}")]
    return element(
        "svg",
        *parts,
        class_="plot panel",
        viewBox=f"0 0 {width:.0f} {PANEL + 42}",
        style=f"max-width:{width:.0f}px",
        role="img",
        aria_label=truth,
    )
