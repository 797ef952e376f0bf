"""mocap-train: labelled clips -> the behaviours of every action in every group of joints (thesis 5.3, 5.4)."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ipcli.io.files import h5
from ipcli.models.mocap.motions import select
from ipcli.models.mocap.training import learn_behaviours
from ipcli.params import Run
from ipcli.progress import Progress, silent
from ipcli.stages.kit.artefact import Job, Outcome, make_resumable
from ipcli.stages.kit.checkpoint import Checkpoint
from ipcli.stages.kit.pages import page
from ipcli.stages.mocap.fitting import fit_cells
from ipcli.stages.mocap.parameters import MocapTrain
from ipcli.stages.mocap.reading import inputs, look, read


def figures(output: Path) -> dict[str, Any]:
    """The figures that a person wants of a model: what it learnt from, and how many behaviours it found."""
    found = h5.read(output, "behaviours").arrays
    return {
        "actions": len(found["actions"]),
        "people": len(found["actors"]),
        "clips": int(found["clips"].sum()),
        "frames": int(found["frames"].sum()),
        "behaviours": len(found["behaviour_action"]),
    }


def run(paths: Sequence[Path], output: Path, params: MocapTrain, run: Run, progress: Progress = silent) -> Outcome:
    """Write the model and beside it a report (.html). A run that was killed goes on where its chains were.

    Raises ParameterError for clips without labels or an action of hardly a frame, and what reading.read raises.
    """
    files = inputs(paths, params.groups)

    def build(work: Checkpoint) -> dict[str, np.ndarray]:
        known = select(read(paths, params.reading, params.groups), params.actors, params.actions)
        learning = params.learning
        return learn_behaviours(
            known, learning, params.decision, run.seed, lambda points: fit_cells(points, learning, run, work, progress)
        )

    first = partial(look, paths, params.reading.source, params.groups, params.actors)
    job = Job(output, "behaviours", "mocap-train", params, files, page(output, "behaviours"), first)
    return make_resumable(job, build, run)
