"""The figures of an experiment as PDF and PNG, for papers and slides, drawn by matplotlib from what the page shows."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from experiments.kit.charts import Chart, Panel
from ipcli.io.files import atomic
from ipcli.report.kit.pictures import palette

INCH = 2.6  # of a panel
METADATA = {
    "pdf": {"CreationDate": None, "Producer": None, "Creator": None},
    "png": {"Software": None},
}  # the same bytes every time


def charts(folder: Path, name: str, shown: Sequence[Chart]) -> None:
    """Plots side by side, two a row, one legend for all of them."""
    figure, axes = _grid(-(-len(shown) // min(len(shown), 2)), min(len(shown), 2), 1.9 * INCH, 1.3 * INCH)
    for chart, axis in zip(shown, axes, strict=False):
        for line in chart.lines:
            axis.plot(
                line.x,
                line.y,
                "--" if line.dashed else "-",
                marker="o" if line.dots else None,
                ms=3,
                lw=1.2,
                label=line.name,
            )
        axis.set(
            title=chart.title,
            xlabel=chart.x_label,
            ylabel=chart.y_label,
            xscale="log" if chart.log_x else "linear",
            ylim=(0, None),
        )
        axis.grid(alpha=0.3)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=8)
    _save(figure, folder, name)


def pictures(folder: Path, name: str, rows: Sequence[Sequence[Panel]]) -> None:
    """A row of pictures for each scene, in the colours of the page."""
    widest = max(map(len, rows))
    height, width = rows[0][0].values.shape
    figure, axes = _grid(len(rows), widest, INCH, INCH * min(height / width, 1.2) + 0.25)
    for axis in axes:
        axis.axis("off")
    for r, row in enumerate(rows):
        for panel, axis in zip(row, axes[r * widest :], strict=False):
            axis.imshow(palette(panel.scale.palette)[panel.scale.indices(panel.values)], interpolation="nearest")
            axis.set_title(panel.caption, fontsize=8)
    _save(figure, folder, name)


def _grid(rows: int, columns: int, width: float, height: float):
    from matplotlib.figure import Figure

    figure = Figure((columns * width, rows * height + 0.4), layout="constrained")
    return figure, np.ravel(figure.subplots(rows, columns, squeeze=False))


def _save(figure, folder: Path, name: str) -> None:
    for suffix, metadata in METADATA.items():
        with atomic.replacing(folder / f"{name}.{suffix}") as temporary:
            figure.savefig(temporary, format=suffix, dpi=200, metadata=metadata)
