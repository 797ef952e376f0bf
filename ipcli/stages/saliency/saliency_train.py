"""saliency-train: recorded fixations -> what tells the places that are looked at from the rest."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ipcli.io.files import h5
from ipcli.models.saliency import validation, vertex_model
from ipcli.params import Run
from ipcli.progress import Progress, portion, silent
from ipcli.stages.kit.artefact import Job, Outcome, make
from ipcli.stages.kit.pages import page
from ipcli.stages.kit.summary import of_result
from ipcli.stages.saliency import sets
from ipcli.stages.saliency.parameters import SaliencyTrain

KIND = "saliency-model"


def run(paths: Sequence[Path], output: Path, params: SaliencyTrain, run: Run, progress: Progress = silent) -> Outcome:
    """Write the model and beside it a page (.html)."""
    places = tuple(paths)
    job = Job(
        output, KIND, "saliency-train", params, sets.inputs(places), page(output, KIND), partial(sets.read, places)
    )
    return make(job, lambda: learnt(places, params, run, progress), run)


def learnt(places: tuple[Path, ...], params: SaliencyTrain, run: Run, progress: Progress) -> dict[str, np.ndarray]:
    """The arrays of the `saliency-model` artefact."""
    known = sets.read(places)
    tell = portion(progress, 0.0, 0.8)
    if known.surfaces:
        surfaces = sets.surface_cases(known.surfaces, run.executor, tell)
        predictor, subject = vertex_model.learnt(surfaces, params.learning, run.seed), "surfaces"
        count = sum(int(one.looked_at.sum()) for one in surfaces)
    else:
        cases = sets.cases(known.pictures, run.executor, tell)
        predictor, subject = validation.learnt_from(cases, params.learning, run.seed), "pictures"
        count = sum(len(one.fixations) for one in cases)
    facts = {"subject": np.array(subject), "items": np.array(known.names), "fixations": np.array(count, np.int64)}
    return predictor.arrays() | facts


@of_result
def summary(output: Path) -> dict[str, Any]:
    """The few figures a person wants of a model."""
    arrays = h5.read(output, KIND, lambda name: not name.startswith("trees/")).arrays
    counted = "labelled vertices" if arrays["subject"] == "surfaces" else "fixations"
    return {
        "learnt from": f"{len(arrays['items'])} {arrays['subject']}, {int(arrays['fixations'])} {counted}",
        "features": len(arrays["features"]),
    }
