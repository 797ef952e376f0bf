"""evaluate-fusion: a scene with known truth -> the errors of every method, at the automatic lambda and at the tuned
one.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ipcli.errors import ParameterError
from ipcli.io.files import h5
from ipcli.models.fusion.assessment import AREAS, CURVES, sparsification
from ipcli.models.fusion.parameters import parse_variants, select_variants
from ipcli.models.fusion.scenes import INITIAL, Scene, run_trials
from ipcli.params import Run
from ipcli.progress import Progress, silent
from ipcli.stages.fusion.compare import best_methods
from ipcli.stages.fusion.parameters import EvaluateFusion
from ipcli.stages.fusion.sources import open_scene, open_truth
from ipcli.stages.fusion.tune_fusion import read_best_lambdas
from ipcli.stages.kit.artefact import Job, Outcome, make
from ipcli.stages.kit.pages import page
from ipcli.stages.kit.summary import of_result


def run(
    source: Path,
    output: Path,
    params: EvaluateFusion,
    run: Run,
    tuning: Path | None = None,
    progress: Progress = silent,
) -> Outcome:
    """Write the `fusion-trials` artefact and beside it a page (.html).

    A method that the artefact ``tuning`` of tune-fusion has is tried at its tuned lambda too.
    """
    if params.fusion.lam is not None:
        raise ParameterError("lambda is the automatic one or that of --tuning: leave out fusion.lam")
    tuned = read_best_lambdas(tuning) if tuning else {}
    inputs = (source, tuning) if tuning else (source,)

    def build() -> dict[str, np.ndarray]:
        return trial_arrays(open_scene(source, params.reference, params.domain), params, tuned, progress)

    look = partial(open_truth, source, params.reference)
    job = Job(output, "fusion-trials", "evaluate-fusion", params, inputs, page(output, "fusion-trials"), look)
    return make(job, build, run)


@of_result
def summary(output: Path) -> dict[str, Any]:
    """The methods that came out best by RMSE and by N-MAE."""
    found = h5.read(output, "fusion-trials", only=lambda name: name in ("methods", "rules", "columns", "values")).arrays
    names = [f"{method} ({rule})" for method, rule in zip(found["methods"], found["rules"], strict=True)]
    return best_methods(names, [str(name) for name in found["columns"]], found["values"])


def trial_arrays(
    scene: Scene, params: EvaluateFusion, tuned: Mapping[str, float], progress: Progress
) -> dict[str, np.ndarray]:
    """The arrays of the artefact: each trial's figures, its sparsification curves, and the maps that are kept."""
    trials = run_trials(scene, select_variants(params.methods, params.fusion), params.fusion, tuned, progress)
    maps = [trial.map for trial in trials]
    columns, values = scene.errors({f"{trial.label} {trial.rule}": trial.map for trial in trials})
    curves = [sparsification(one, maps, scene) for one in maps]
    kept = [trial for trial in trials if trial.rule != "tuned" and trial.label in kept_labels(params)]
    return {
        "methods": np.array([trial.label for trial in trials]),
        "rules": np.array([trial.rule for trial in trials]),
        "lambdas": np.array([trial.lam for trial in trials]),
        "columns": np.array([*columns, *AREAS]),
        "values": np.column_stack([values, np.array([areas for areas, _ in curves])]),
        **dict(zip(CURVES, np.stack([curve for _, curve in curves], axis=1), strict=True)),
        "maps": np.array([trial.label for trial in kept]),
        "depth": np.stack([trial.map.depth for trial in kept]),
        "confidence": np.stack([trial.map.confidence_or_zero for trial in kept]),
        "truth": scene.truth,
        "intrinsics": scene.reference.intrinsics,
        "unit": np.array(scene.unit),
    }


def kept_labels(params: EvaluateFusion) -> set[str]:
    """Labels of the trials whose maps are kept; the initial maps always are."""
    return {*INITIAL, *(variant.label for text in params.keep for variant in parse_variants(text))}
