"""tune-fusion: scenes with known truth -> the errors of every method over a grid of lambda, and the best of each."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ipcli.errors import ParameterError
from ipcli.executor import map_items
from ipcli.io.files import h5
from ipcli.models.fusion.parameters import select_variants
from ipcli.models.fusion.scenes import best_lambdas, sweep_lambdas
from ipcli.params import Run
from ipcli.progress import Progress, silent
from ipcli.stages.fusion.parameters import TuneFusion
from ipcli.stages.fusion.sources import open_scene, open_truth
from ipcli.stages.kit.artefact import Job, Outcome, make
from ipcli.stages.kit.pages import page
from ipcli.stages.kit.summary import of_result


def run(files: Sequence[Path], output: Path, params: TuneFusion, run: Run, progress: Progress = silent) -> Outcome:
    """Write the `fusion-tuning` artefact and beside it a page (.html). Raises ItemsFailed when some scenes failed."""
    if len(set(params.lambdas)) != len(params.lambdas) or params.fusion.lam is not None:
        raise ParameterError("give every lambda once, by --lambdas")
    if not any(variant.is_regularised for variant in select_variants(params.methods, params.fusion)):
        raise ParameterError("none of these methods has a lambda to tune")
    beside = page(output, "fusion-tuning")
    job = Job(output, "fusion-tuning", "tune-fusion", params, tuple(files), beside, partial(_look, files, params))
    return make(job, lambda: tuning_arrays(files, params, run.executor, progress), run)


@of_result
def summary(output: Path) -> dict[str, Any]:
    """The best lambda of each method, and by which measure."""
    found = h5.read(output, "fusion-tuning", only=lambda name: name in ("scenes", "methods", "best", "measure")).arrays
    best = dict(zip(found["methods"].tolist(), found["best"].tolist(), strict=True))
    return {"scenes": len(found["scenes"]), "measure": str(found["measure"]), "best_lambda": best}


def tuning_arrays(
    files: Sequence[Path], params: TuneFusion, executor: str, progress: Progress
) -> dict[str, np.ndarray]:
    """The arrays of the artefact; methods without regularisation are left out, there being nothing to tune."""
    swept = map_items(partial(sweep_scene, params=params), [str(path) for path in files], executor, progress)
    columns, lambdas = next(iter(swept.values()))["columns"], np.array(sorted(params.lambdas))
    stacked = {
        key: np.stack([one[key] for one in swept.values()]) for key in ("values", "automatic", "automatic_lambda")
    }
    variants = select_variants(params.methods, params.fusion)
    return stacked | {
        "scenes": np.array([path.name.split(".")[0] for path in files]),
        "methods": np.array([variant.label for variant in variants if variant.is_regularised]),
        "lambdas": lambdas,
        "columns": columns,
        "measure": np.array(params.measure),
        "best": best_lambdas(stacked["values"], columns, params.measure, lambdas),
    }


def _look(files: Sequence[Path], params: TuneFusion) -> None:
    for file in files:
        open_truth(file, params.reference)


def sweep_scene(file: str, *, params: TuneFusion) -> dict[str, np.ndarray]:
    """The errors of every method at every lambda on the scene in a file, as `sweep_lambdas` gives them."""
    scene = open_scene(Path(file), params.reference, params.domain)
    variants = select_variants(params.methods, params.fusion)
    return sweep_lambdas(scene, variants, params.fusion, sorted(params.lambdas))


def read_best_lambdas(path: Path) -> dict[str, float]:
    """The best lambda of each method label in a `fusion-tuning` artefact."""
    arrays = h5.read(path, "fusion-tuning", only=lambda name: name in ("methods", "best")).arrays
    return dict(zip(map(str, arrays["methods"]), map(float, arrays["best"]), strict=True))
