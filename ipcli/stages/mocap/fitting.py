"""Learning the mixtures of all cells wherever the executor runs them, so that a run that was killed goes on."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np

from ipcli.executor import map_items
from ipcli.inverse.bayes.mixture import Fitted
from ipcli.models.mocap.parameters import Learning
from ipcli.models.mocap.training import fit_cell
from ipcli.params import Run
from ipcli.progress import Progress
from ipcli.stages.kit.checkpoint import Checkpoint

POINTS = "points"


def fit_cells(
    points: Mapping[str, np.ndarray], settings: Learning, run: Run, work: Checkpoint, progress: Progress
) -> dict[str, Fitted]:
    """Learn the mixture of each cell by its coordinates (n, d). Raises ItemsFailed when some could not be learnt."""
    for name, x in points.items():  # a file each: a cell then reads its own alone
        work.save(f"{name}.{POINTS}", {POINTS: x})
    one = partial(_fit_cell, settings=settings, seed=run.seed, work=work)
    map_items(one, list(points), run.executor, progress)
    found = {name: Fitted.of_arrays(_saved(work, f"{name}.done")) for name in points}
    progress(1.0, "writing")
    return found


def _fit_cell(name: str, *, settings: Learning, seed: int, work: Checkpoint) -> None:
    """Learn one cell and save it, from where its chains were last seen."""
    if work.load(f"{name}.done") is not None:
        return
    state, watch = work.load(f"{name}.chains"), partial(work.save, f"{name}.chains")
    found = fit_cell(name, _saved(work, f"{name}.{POINTS}")[POINTS], settings, seed, state=state, watch=watch)
    work.save(f"{name}.done", found.arrays())


def _saved(work: Checkpoint, name: str) -> dict[str, np.ndarray]:
    arrays = work.load(name)
    if arrays is None:
        raise FileNotFoundError(f"{work.folder}: '{name}' is gone. Run again, and leave that folder alone meanwhile")
    return arrays
