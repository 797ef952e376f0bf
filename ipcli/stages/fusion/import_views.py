"""import-views: depth maps of any known layout -> one `views` artefact, with noise added if wanted."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from ipcli.errors import ParameterError
from ipcli.params import Run, option
from ipcli.progress import Progress, silent
from ipcli.stages.fusion.sources import Source, open_source, source_files

if TYPE_CHECKING:
    import numpy as np

    from ipcli.measurements.views import View, Views
    from ipcli.stages.kit.artefact import Outcome


@dataclass(frozen=True)
class Params:
    """Which views, and what to do to them."""

    views: str | None = option(None, "Names of the views to take, with commas.", flag="--views")
    reference: str | None = option(None, "View in the middle of the window.", flag="--reference")
    window: int | None = option(None, "Number of views to take around the reference.", flag="--window", low=1)
    noise: str | None = option(
        None, "Noise to add: laplace:SCALE or gauss:SCALE, in the unit (px for disparities).", flag="--noise"
    )
    outliers: float = option(0.0, "Share of pixels to replace by a random depth.", flag="--outliers", low=0.0, high=1.0)
    source: Source = field(default_factory=Source)


def run(
    source: Path,
    output: Path,
    params: Params,
    run: Run,
    progress: Progress = silent,
) -> Outcome:
    """Write the artefact. The depth that noise is added to stays as ``truth``, unless there is a truth already."""
    from ipcli.geometry.sensor import parse_noise
    from ipcli.io.views import artefact
    from ipcli.stages.kit.artefact import Job, make

    sequence = open_source(source, params.source)
    names = chosen(sequence.names, params)
    noise = parse_noise(params.noise) if params.noise else None

    def build() -> dict[str, np.ndarray]:
        views = []
        for count, name in enumerate(names, start=1):
            views.append(_disturbed(sequence, sequence.load(name), noise, params.outliers, run.seed))
            progress(count / len(names), name)
        about = {"unit": sequence.unit, "measured": sequence.measured, "baseline_focal": sequence.baseline_focal}
        return artefact.views_arrays(views, **about)

    return make(Job(output, "views", "import-views", params, source_files(sequence, names)), build, run)


def chosen(names: tuple[str, ...], params: Params) -> tuple[str, ...]:
    """The names asked for, in the order of the sequence; ParameterError for a name that is not there."""
    from ipcli.measurements.names import position, window

    if params.views is not None and (params.reference or params.window):
        raise ParameterError("--views and --reference with --window exclude each other: give one of them")
    if (params.reference is None) != (params.window is None):
        raise ParameterError("--reference and --window belong together: give both or neither")
    if params.views is not None:
        wanted = {position(names, name.strip()) for name in params.views.split(",")}
        return tuple(names[index] for index in sorted(wanted))
    return window(names, params.reference, params.window) if params.reference else names


def _disturbed(sequence: Views, view: View, noise: tuple[str, float] | None, outliers: float, seed: int) -> View:
    if noise is None and not outliers:
        return view
    from ipcli.geometry.sensor import observe
    from ipcli.rng import stream

    rng = stream(seed, "import-views", view.name)
    truth = view.depth if view.truth is None else view.truth
    measured = observe(_swap(sequence, view.depth), rng, noise or ("gauss", 0.0), outliers)
    return replace(view, depth=_swap(sequence, measured), truth=truth)


def _swap(sequence: Views, values: np.ndarray) -> np.ndarray:
    """Depth to the measured quantity, or back: the same formula both ways."""
    if sequence.measured == "depth":
        return values
    return (sequence.baseline_focal / values).astype(values.dtype)
