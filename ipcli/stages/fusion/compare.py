"""compare: the error measures of fused maps, or of trials, of several scenes and methods -> one table."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ipcli.errors import FormatError, ParameterError
from ipcli.io.files import atomic, h5
from ipcli.params import Run
from ipcli.report.fusion.fusion_trials import row_names
from ipcli.stages.fusion.parameters import CompareFusion
from ipcli.stages.kit.artefact import Job, Outcome, make
from ipcli.stages.kit.pages import page
from ipcli.stages.kit.summary import Figure, of_result

BEST_BY = ("RMSE", "N-MAE rad")


def run(files: Sequence[Path], output: Path, params: CompareFusion, run: Run) -> Outcome:
    """Write the table and beside it a page (.html) and all figures (.csv, .json).

    A scene is the name of a file up to its first dot. Raises FormatError for a file without measures and ParameterError
    when two files of a scene give the same method, or other figures for the same baseline.
    """
    beside = {
        **page(output, "fusion-comparison"),
        output.with_suffix(".csv"): write_csv,
        output.with_suffix(".json"): write_json,
    }
    build = partial(comparison_arrays, files)
    return make(Job(output, "fusion-comparison", "compare", params, tuple(files), beside, look=build), build, run)


@of_result
def summary(output: Path) -> dict[str, Any]:
    """How many scenes there are, and the methods whose mean over them is least by RMSE and by N-MAE."""
    found = h5.read(output, "fusion-comparison").arrays
    methods, columns = ([str(name) for name in found[field]] for field in ("methods", "columns"))
    return {"scenes": len(found["scenes"])} | best_methods(methods, columns, found["values"].mean(axis=0))


def best_methods(methods: Sequence[str], columns: Sequence[str], values: np.ndarray) -> dict[str, Figure]:
    """The method with the least of each of BEST_BY, of values (m, c); none of a measure that no method has."""
    found = {}
    for name in BEST_BY:
        column = values[:, columns.index(name)] if name in columns else np.full(len(methods), np.nan)
        if np.isfinite(column).any():
            m = int(np.nanargmin(column))
            value = {"method": methods[m], "value": float(column[m])}
            found[f"best_by_{name.split()[0].lower().replace('-', '_')}"] = Figure(
                value, f"{methods[m]}, {column[m]:.4g}"
            )
    return found


def comparison_arrays(files: Sequence[Path]) -> dict[str, np.ndarray]:
    """The arrays of the `fusion-comparison` artefact; scenes and methods in the order of the files."""
    columns: list[str] = []
    cells: dict[tuple[str, str], np.ndarray] = {}
    for path in files:
        columns, rows = read_measures(path, columns)
        scene = path.name.split(".")[0]
        for method, values in rows.items():
            known = cells.setdefault((scene, method), values)
            if known is not values and not np.array_equal(known, values, equal_nan=True):
                raise ParameterError(
                    f"{path}: another file of scene '{scene}' has other figures for '{method}'. Compare one at a time"
                )
    scenes, methods = (list(dict.fromkeys(names)) for names in zip(*cells, strict=True))
    nothing = np.full(len(columns), np.nan)
    table = np.array([[cells.get((scene, method), nothing) for method in methods] for scene in scenes])
    return {"scenes": np.array(scenes), "methods": np.array(methods), "columns": np.array(columns), "values": table}


def read_measures(path: Path, columns: list[str]) -> tuple[list[str], dict[str, np.ndarray]]:
    """Columns, and the figures of each method, of a fused map or of trials; the columns must be those given, if any."""
    read = _measures_of_trials if h5.peek(path).kind == "fusion-trials" else _measures_of_map
    found, rows = read(path)
    if columns and found != columns:
        raise FormatError(path, "has other measures than the files before it", expected=columns, got=found)
    return found, rows


def _measures_of_map(path: Path) -> tuple[list[str], dict[str, np.ndarray]]:
    wanted = ("metrics", "metric_rows", "metric_columns", "method")
    artefact = h5.read(path, "fused-depth", only=lambda name: name in wanted)
    arrays, lam = artefact.arrays, artefact.provenance["params"]["fusion"]["lam"]
    if "metrics" not in arrays:
        raise FormatError(path, "holds no error measures", fix="Fuse views whose reference has a truth")
    own = (
        str(arrays["method"]) if lam is None else f"{arrays['method']}, λ = {lam:g}"
    )  # the automatic λ is part of the method
    names = (str(name).replace("fused", own) for name in arrays["metric_rows"])
    return [str(name) for name in arrays["metric_columns"]], dict(zip(names, arrays["metrics"], strict=True))


def _measures_of_trials(path: Path) -> tuple[list[str], dict[str, np.ndarray]]:
    arrays = h5.read(path, "fusion-trials", only=lambda name: name in ("methods", "rules", "columns", "values")).arrays
    return [str(name) for name in arrays["columns"]], dict(zip(row_names(arrays), arrays["values"], strict=True))


def write_csv(path: Path, arrays: Mapping[str, np.ndarray], provenance: Mapping[str, Any]) -> None:
    """Write the table as CSV, a line for each scene and method."""
    text = io.StringIO()
    lines = csv.writer(text, lineterminator="\n")
    lines.writerow(["scene", "method", *arrays["columns"]])
    for scene, table in zip(arrays["scenes"], arrays["values"], strict=True):
        lines.writerows([scene, method, *row] for method, row in zip(arrays["methods"], table.tolist(), strict=True))
    atomic.write_text(path, text.getvalue())


def write_json(path: Path, arrays: Mapping[str, np.ndarray], provenance: Mapping[str, Any]) -> None:
    """Write the table as JSON, an object for each scene and method; null where undefined."""
    rows = []
    for scene, table in zip(arrays["scenes"], arrays["values"].tolist(), strict=True):
        for method, values in zip(arrays["methods"], table, strict=True):
            known = (value if math.isfinite(value) else None for value in values)
            rows.append(
                {"scene": str(scene), "method": str(method)}
                | dict(zip(map(str, arrays["columns"]), known, strict=True))
            )
    atomic.write_text(
        path, json.dumps({"digest": provenance.get("digest"), "rows": rows}, indent=1, ensure_ascii=False) + "\n"
    )
