"""What a page shows as SVG or PNG and `figures` as PDF: charts of lines, and panels of values."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipcli.report.kit.curves import Series, plot
from ipcli.report.kit.page import Markup, figure
from ipcli.report.kit.pictures import Scale, draw

SMALL = 128  # pixels a side, up to which single ones are meant to be seen


@dataclass(frozen=True)
class Chart:
    """Lines on two axes, the vertical one from 0."""

    title: str
    x_label: str
    y_label: str
    lines: tuple[Series, ...]
    log_x: bool = False

    def svg(self) -> Markup:
        """The chart as it stands on the page."""
        return plot(
            self.lines, self.title, self.x_label, self.y_label, log_x=self.log_x, from_zero=True, width=470, height=290
        )


@dataclass(frozen=True)
class Panel:
    """A picture to be drawn: values (h, w) on a scale of colours."""

    caption: str
    values: np.ndarray
    scale: Scale

    def figure(self) -> Markup:
        """The picture as it stands on the page."""
        return figure(draw(self.values, self.scale, 420), self.caption, crisp=self.values.shape[1] <= SMALL)
