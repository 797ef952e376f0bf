"""import-views: depth maps of any known layout -> one `views` artefact, with noise added if wanted."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ipcli.errors import ParameterError
from ipcli.geometry.sensor import parse_noise
from ipcli.io.views import artefact
from ipcli.measurements.names import position, window
from ipcli.measurements.views import View
from ipcli.models.fusion.synthetic import add_noise
from ipcli.params import Run
from ipcli.progress import Progress, silent
from ipcli.rng import stream
from ipcli.stages.fusion.parameters import ImportViews
from ipcli.stages.fusion.sources import open_source, source_files
from ipcli.stages.kit.artefact import Job, Outcome, make


def run(
    source: Path,
    output: Path,
    params: ImportViews,
    run: Run,
    progress: Progress = silent,
) -> Outcome:
    """Write the artefact. The depth that noise is added to stays as ``truth``, unless there is a truth already."""
    views = open_source(source, params.source)
    names = select_names(views.names, params)
    noise = parse_noise(params.noise) if params.noise else ("gauss", 0.0)
    baseline_focal = views.baseline_focal if views.measured == "disparity" else None
    if views.measured == "disparity" and baseline_focal is None and (params.noise or params.outliers):
        raise ParameterError(f"{source}: noise of disparities needs --baseline-focal, to turn depth into disparity")

    def load(name: str) -> View:
        view = views.load(name)
        if not params.noise and not params.outliers:
            return view
        return add_noise(view, stream(run.seed, "import-views", name), noise, params.outliers, baseline_focal)

    def build() -> dict[str, np.ndarray]:
        taken = []
        for count, name in enumerate(names, start=1):
            taken.append(load(name))
            progress(count / len(names), name)
        return artefact.views_arrays(
            taken, unit=views.unit, measured=views.measured, baseline_focal=views.baseline_focal
        )

    return make(Job(output, "views", "import-views", params, source_files(views, names)), build, run)


def select_names(names: tuple[str, ...], params: ImportViews) -> tuple[str, ...]:
    """The names asked for, in the order of the sequence; ParameterError for a name that is not there."""
    if params.views is not None and (params.reference or params.window):
        raise ParameterError("--views and --reference with --window exclude each other: give one of them")
    if (params.reference is None) != (params.window is None):
        raise ParameterError("--reference and --window belong together: give both or neither")
    if params.views is not None:
        wanted = {position(names, name.strip()) for name in params.views.split(",")}
        return tuple(names[index] for index in sorted(wanted))
    return window(names, params.reference, params.window) if params.reference and params.window else names
