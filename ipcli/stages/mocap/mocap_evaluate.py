"""mocap-evaluate: how often a model that learnt from a part of the clips names the others right."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ipcli.errors import ParameterError
from ipcli.io.files import h5
from ipcli.models.mocap.evaluation import evaluate, make_splits
from ipcli.models.mocap.left_out import evaluate_left_out
from ipcli.models.mocap.motions import number_actions, select
from ipcli.models.mocap.parameters import LEFT_OUT
from ipcli.params import Run
from ipcli.progress import Progress, silent
from ipcli.report.mocap.action_evaluation import accuracy
from ipcli.stages.kit.artefact import Job, Outcome, make_resumable
from ipcli.stages.kit.checkpoint import Checkpoint
from ipcli.stages.kit.pages import page
from ipcli.stages.mocap.fitting import fit_cells
from ipcli.stages.mocap.parameters import MocapEvaluate
from ipcli.stages.mocap.reading import inputs, look, read

KIND = "action-evaluation"
NOVELTY = "action-novelty"


def run(paths: Sequence[Path], output: Path, params: MocapEvaluate, run: Run, progress: Progress = silent) -> Outcome:
    """Write what was answered and beside it a page (.html). A run that was killed goes on where its chains were.

    Raises ParameterError for a split that leaves nothing on one side, and what reading.read raises.
    """
    files = inputs(paths, params.groups)
    kind, make = (NOVELTY, left_out_evaluation) if params.split == LEFT_OUT else (KIND, evaluation)
    people = (*params.actors, *(params.test if params.split in ("subjects", LEFT_OUT) else ()))
    first = partial(look, paths, params.reading.source, params.groups, people)
    job = Job(output, kind, "mocap-evaluate", params, files, page(output, kind), first)
    return make_resumable(job, lambda work: make(paths, params, run, work, progress), run)


def figures(output: Path) -> dict[str, Any]:
    """The figures that a person wants of an evaluation: shares named right, each the mean over the splits; of actions
    left out how many clips of them are caught and of the others lost, the mean over those actions.
    """
    if h5.peek(output).kind == NOVELTY:
        return _novelty_figures(h5.read(output, NOVELTY).arrays)
    found = h5.read(output, KIND).arrays
    shares = {
        name: round(float(np.mean(accuracy(found[field]))), 4)
        for name, field in (
            ("clips_right", "sequence_confusion"),
            ("frames_right", "frame_confusion"),
            ("clips_right_in_any_order", "pose_sequence_confusion"),
        )
    }
    return {"splits": len(found["splits"]), "actions": len(found["classes"])} | shares


def _novelty_figures(found: Mapping[str, np.ndarray]) -> dict[str, Any]:
    names = {"auc": "area", "unknown_caught": "caught", "known_lost": "lost", "auc_by_surprise": "surprise_area"}
    told = {name: round(float(np.nanmean(found[field])), 4) for name, field in names.items()}
    return {"actions": len(found["left_out"])} | told


def left_out_evaluation(
    paths: Sequence[Path], params: MocapEvaluate, run: Run, work: Checkpoint, progress: Progress
) -> dict[str, np.ndarray]:
    """The arrays of the `action-novelty` artefact. Raises ParameterError where there is nothing to leave out."""
    known = select(read(paths, params.reading, params.groups), params.actors, params.actions)
    people = "published" if params.only else "subjects"
    split, *more = make_splits(known, people, run.seed, test=params.test, only=params.only)
    if more:
        raise ParameterError(f"actions are left out of one split at a time, and --only names {len(more) + 1}. Name one")
    return evaluate_left_out(
        known,
        split,
        params.learning,
        params.decision,
        run.seed,
        lambda points: fit_cells(points, params.learning, run, work, progress),
    )


def evaluation(
    paths: Sequence[Path], params: MocapEvaluate, run: Run, work: Checkpoint, progress: Progress
) -> dict[str, np.ndarray]:
    """The arrays of the `action-evaluation` artefact. Raises ParameterError where there is nothing to tell apart."""
    known = select(read(paths, params.reading, params.groups), params.actors, params.actions)
    names = number_actions(known.labels)[0]
    if len(names) < 2:
        raise ParameterError(
            f"{paths[0]}: {len(names)} actions have labels; there is nothing to tell apart. Give clips of at least two"
        )
    found = evaluate(
        known,
        make_splits(known, params.split, run.seed, test=params.test, only=params.only, repeats=params.repeats),
        params.learning,
        params.decision,
        run.seed,
        unordered=params.unordered,
        draws=params.draws,
        fit=lambda points: fit_cells(points, params.learning, run, work, progress),
    )
    return found | {"split": np.array(params.split)}
