"""mocap-classify: the action of clips, of unordered frames of them, or along long takes (thesis 5.10, 5.11)."""

from __future__ import annotations

import csv
import io
import logging
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ipcli.errors import NoSolution, ParameterError
from ipcli.io.files import atomic, h5
from ipcli.io.files.h5 import Artefact
from ipcli.models.mocap import behaviours, queries, recognition
from ipcli.models.mocap.fold_models import FoldModels
from ipcli.models.mocap.motions import NONE, Motions, of_people
from ipcli.models.mocap.parameters import Features
from ipcli.models.mocap.queries import Queries, Refusal
from ipcli.params import Run, resolve
from ipcli.progress import Progress, silent
from ipcli.stages.kit.artefact import Job, Outcome, make
from ipcli.stages.kit.pages import page
from ipcli.stages.kit.summary import Figure, of_result
from ipcli.stages.mocap.parameters import MocapClassify
from ipcli.stages.mocap.reading import look, read

KIND = "action-recognition"
QUERIES = {"clip": "clips", "unordered": "queries", "window": "windows"}  # what each kind of query is called
SEGMENT = ("clip", "time", "answer", "best", "posterior", "novelty")
HEADS = {"start": "start_s", "end": "end_s", "answer": "action"}  # columns of the table that say their unit or more
FORMATS = {"start": ".3f", "end": ".3f", "posterior_of_best": ".4f", "novelty": ".4g"}
log = logging.getLogger(__name__)


def run(
    model: Path,
    paths: Sequence[Path],
    output: Path,
    params: MocapClassify,
    run: Run,
    progress: Progress = silent,
) -> Outcome:
    """Write the answers and beside them a page (.html) and a table (.csv): of segments with --window, else of the
    queries.

    Raises ParameterError for --window together with --unordered or of no length, FormatError for clips of another
    skeleton than the model's, NoSolution when no frame of any clip shows a group of joints whole.
    """
    if params.window is not None and params.unordered:
        raise ParameterError("--window and --unordered exclude each other: a window has all its frames")
    if params.window == 0:
        raise ParameterError(
            "--window 0: a window has a length, such as 1 s. Leave the option out to ask about whole clips"
        )
    beside = page(output, KIND) | {output.with_suffix(".csv"): write_csv}
    first = partial(_look, model, paths, params)
    job = Job(output, KIND, "mocap-classify", params, (model, *paths), beside, first)
    return make(job, lambda: recognition_arrays(model, paths, params, run.seed, progress), run)


def _look(model: Path, paths: Sequence[Path], params: MocapClassify) -> None:
    h5.read(model, "behaviours", only=lambda name: False)
    look(paths, params.reading.source, None, params.actors)


def answers(output: Path) -> list[dict[str, Any]]:
    """The answers in an artefact, ready for JSON: of the segments of windows, else of the queries."""
    return _answers(h5.read(output, KIND).arrays)


def _answers(found: Mapping[str, np.ndarray]) -> list[dict[str, Any]]:
    """A row an answer, by column. `best` is the likeliest of the actions, also where the answer is none."""
    if "segment_clip" in found:
        clips, times, given, best, share, novelty = (found[f"segment_{name}"] for name in SEGMENT)
        rest = {}
    else:
        clips, times, given, novelty = (found[name] for name in ("clips", "times", "answers", "novelty"))
        best, share = found["actions"][found["posterior"].argmax(axis=1)], found["posterior"].max(axis=1)
        rest = {"frames": found["frames"]}
        rest |= {name: found[kept] for name, kept in (("actor", "actors"), ("label", "truth")) if kept in found}
    columns = {"clip": clips, "start": times[:, 0], "end": times[:, 1], "answer": given}
    columns |= {"best": best, "posterior_of_best": share, "novelty": novelty, **rest}
    return [
        dict(zip(columns, row, strict=True))
        for row in zip(*(column.tolist() for column in columns.values()), strict=True)
    ]


@of_result
def summary(output: Path) -> dict[str, Any]:
    """How often each answer was given and, where there are labels, how many are right: `none` is of a label that the
    model has not learnt.
    """
    found = h5.read(output, KIND).arrays
    kind = str(found["queries"])
    names, counts = np.unique(found["answers"], return_counts=True)
    facts: dict[str, Any] = {
        QUERIES[kind]: len(found["answers"]),
        "answered": dict(zip(names.tolist(), counts.tolist(), strict=True)),
    }
    if "truth" not in found:
        return facts
    truth, answers = found["truth"], found["answers"]
    learnt = np.isin(truth, found["actions"])
    strange = (truth != "") & ~learnt
    for name, mine, right, whose in (
        ("right", learnt, truth, "whose label the model learnt"),
        ("none", strange, NONE, "whose label it never learnt"),
    ):
        if mine.any():
            count, of = int((answers == right)[mine].sum()), int(mine.sum())
            value = {"count": count, "of": of, "share": count / of}
            facts[name] = Figure(value, f"{count} of {of} {whose} ({count / of:.1%})")
    return facts


def recognition_arrays(
    path: Path, paths: Sequence[Path], params: MocapClassify, seed: int, progress: Progress
) -> dict[str, np.ndarray]:
    """The arrays of the `action-recognition` artefact."""
    stored = h5.read(path, "behaviours")
    body = behaviours.body_of_arrays(stored.arrays, path.name)
    known = of_people(read(paths, params.reading, body.groups, body.skeleton), params.actors)
    progress(0.2, "features")
    return recognised_arrays(stored, known, params, seed, progress, where=str(paths[0]))


def recognised_arrays(
    stored: Artefact,
    known: Motions,
    params: MocapClassify,
    seed: int,
    progress: Progress = silent,
    where: str = "",
) -> dict[str, np.ndarray]:
    """Ask a `behaviours` artefact about motions of its skeleton; the arrays of the `action-recognition` artefact.

    Raises NoSolution, naming `where` the clips are from or else the first of them, if no frame shows a group whole.
    """
    model, body = behaviours.of_arrays(stored.arrays), behaviours.body_of_arrays(stored.arrays, "model")
    settings = resolve(Features, flags=stored.provenance["params"]["learning"]["features"])
    features = known.features(body.lengths, settings)
    density = recognition.log_densities(model, features)
    ordered = params.motion and not params.unordered
    if not ordered:
        density = recognition.poses_alone(model, density)
    if not np.isfinite(density).any():
        raise NoSolution(
            f"{where or known.clips[0].name}: no frame shows any group of joints whole. The model needs "
            f"{', '.join(model.groups)}"
        )
    progress(0.7, "answers")
    kind, asked = _queries(known, params, seed)
    judges = FoldModels.of_arrays(stored.arrays)
    densities = judges.log_densities(features, ordered=ordered) if kind == "clip" else []
    refuse = Refusal(judges, densities, ordered, whole=kind == "clip", is_allowed=params.none, least=params.least)
    arrays = queries.recognise(model, density, known, asked, params.decision, refuse) | {"queries": np.array(kind)}
    return arrays | (queries.segments(known, arrays, asked) if kind == "window" else {})


def _queries(known: Motions, params: MocapClassify, seed: int) -> tuple[str, Queries]:
    """What is asked about: the kind as the artefact names it, and the queries."""
    if params.window is not None:
        for odd in odd_windows(known, params.window, params.step):
            log.warning("%s", odd)
        return "window", queries.windows(known, params.window, params.step or params.window / 4)
    if params.unordered:
        return "unordered", queries.unordered_frames(known, params.unordered, params.draws, seed)
    return "clip", queries.whole_clips(known)


def odd_windows(known: Motions, window: float, step: float | None) -> list[str]:
    """What a person may not expect of windows: frames that none sees, takes shorter than one, one of a single frame."""
    lengths = known.lengths / known.rates
    short = [clip.name for clip, length in zip(known.clips, lengths, strict=True) if length < window]
    found = []
    if step is not None and step > window:
        found.append(f"--step {step:g} is longer than --window {window:g}: the frames in between are seen by no window")
    if short:
        found.append(
            f"{len(short)} of {len(known.clips)} clips, such as {short[0]}, are shorter than --window {window:g}: "
            "each is asked about as a whole"
        )
    if window * float(np.max(known.rates)) < 1:
        found.append(f"--window {window:g} is shorter than a frame: each window is one frame")
    return found


def write_csv(path: Path, arrays: Mapping[str, np.ndarray], provenance: Mapping[str, Any]) -> None:
    """Write a line an answer, with the columns of `answers`: what is not known is empty."""
    text, rows = io.StringIO(), _answers(arrays)
    lines = csv.writer(text, lineterminator="\n")
    lines.writerow([HEADS.get(name, name) for name in rows[0]])
    for row in rows:
        lines.writerow([_cell(value, FORMATS.get(name, "")) for name, value in row.items()])
    atomic.write_text(path, text.getvalue())


def _cell(value: Any, form: str) -> str:
    return "" if value != value else format(value, form)
