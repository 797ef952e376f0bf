"""A page of curves, error against setting, from one comparison a setting: `python curves.py PAGE.html FOLDER/noise-0.2/table.h5 ...`.

The folder of a table is called SWEEP-VALUE. Every sweep gets a plot for each measure; its lines are the methods, the geometric
mean over the scenes as in the figures 4.3 and 4.5 of the thesis.
"""

import sys
from collections import defaultdict
from pathlib import Path

import numpy as np

from ipcli.io import atomic, h5
from ipcli.report.curves import Series, plot
from ipcli.report.page import element, page, section

MEASURES = ("RMSE", "Z-MAE", "N-MAE rad", "D-avg px")


def points(paths: list[Path]) -> dict[str, dict[str, dict[str, list[tuple[float, float]]]]]:
    """sweep -> measure -> method -> (value, error), sorted by value."""
    found = defaultdict(lambda: defaultdict(lambda: defaultdict(list)))
    for path in paths:
        sweep, _, value = path.parent.name.rpartition("-")
        table = h5.read(path, "comparison").arrays
        for m, method in enumerate(map(str, table["methods"])):
            if method.endswith("in-painted") or method == "reference":
                continue
            for measure in MEASURES:
                errors = table["values"][:, m, list(table["columns"]).index(measure)]
                found[sweep][measure][method.split(",")[0]].append((float(value), float(np.exp(np.log(errors).mean()))))
    return found


def sweep_section(sweep: str, measures: dict) -> object:
    """The plots of a sweep."""
    plots = []
    for measure, methods in measures.items():
        lines = [Series(name, *np.array(sorted(values)).T, dots=True) for name, values in methods.items()]
        plots.append(plot(lines, measure, sweep, measure, from_zero=True, width=420, height=270))
    return section(sweep.capitalize(), element("div", *plots, class_="plots"))


if __name__ == "__main__":
    found = points([Path(argument) for argument in sys.argv[2:]])
    parts = [sweep_section(sweep, measures) for sweep, measures in found.items()]
    lead = "Geometric mean over the scenes of the error of each method; lower is better."
    atomic.write_text(Path(sys.argv[1]), page("Error against setting", "experiments/curves.py", lead, *parts))
