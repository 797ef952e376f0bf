"""mocap-classify: the action of clips, of handfuls of their frames in no order, or along long takes (thesis 5.10,
5.11).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ipcli.errors import NoSolution, ParameterError
from ipcli.models.mocap.parameters import Decision, Features
from ipcli.params import Run, option
from ipcli.progress import Progress, silent
from ipcli.stages.mocap import motions
from ipcli.stages.mocap.motions import Motions, Reading

if TYPE_CHECKING:
    import numpy as np

    from ipcli.models.mocap.behaviours import Model
    from ipcli.stages.kit.artefact import Outcome

NONE = "none"


@dataclass(frozen=True)
class Params:
    """What is asked about, and how the answers of frames and groups make one."""

    actors: tuple[str, ...] = option(
        (), "ask about clips of these people only, with commas; none given: of all", flag="--actors"
    )
    unordered: int = option(
        0,
        "ask about so many frames of each clip, drawn at random, by their poses alone; 0: about all",
        flag="--unordered",
        low=0,
    )
    handfuls: int = option(1, "so many such draws from each clip", flag="--handfuls", low=1)
    window: float | None = option(
        None, "ask about a window of that length along each clip", flag="--window", low=0.0, unit="s"
    )
    step: float | None = option(
        None, "from one window to the next; a quarter of the window if not given", flag="--step", low=0.0, unit="s"
    )
    motion: bool = option(
        True, "use how the parts move, where the model knows; else poses alone, in any order", flag="--motion"
    )
    none: bool = option(True, "allow the answer that it is none of the actions", flag="--none")
    reading: Reading = field(default_factory=Reading)
    decision: Decision = field(default_factory=Decision)


class Queries(NamedTuple):
    """Which frames belong to which query."""

    rows: np.ndarray  # (r,), indices of frames
    query: np.ndarray  # (r,), the query of each
    clip: np.ndarray  # (q,), the clip of each query
    times: np.ndarray  # (q, 2), seconds from the start of the clip


def run(
    model: Path,
    paths: Sequence[Path],
    output: Path,
    params: Params,
    run: Run,
    progress: Progress = silent,
) -> Outcome:
    """Write the answers and beside them a page (.html) and a table (.csv): of segments with --window, else of the
    queries.

    Raises ParameterError for --window together with --unordered, FormatError for clips of another skeleton than the
    model's, NoSolution when no frame of any clip shows a group of joints whole.
    """
    from ipcli.stages.kit.artefact import Job, make
    from ipcli.stages.kit.pages import page

    if params.window is not None and params.unordered:
        raise ParameterError("--window and --unordered exclude each other: a window has all its frames")
    beside = page(output, "action-recognition") | {output.with_suffix(".csv"): write_csv}
    job = Job(output, "action-recognition", "mocap-classify", params, (model, *paths), beside)
    return make(job, lambda: recognised(model, paths, params, run.seed, progress), run)


def answers(output: Path) -> list[dict[str, Any]]:
    """The answers in an artefact, ready for JSON."""
    from ipcli.io.files import h5

    found = h5.read(output, "action-recognition").arrays
    columns = ("clips", "answers", "surprise", "frames")
    rows = zip(
        *(found[name].tolist() for name in columns),
        found["posterior"].max(axis=1).tolist(),
        found["times"].tolist(),
        strict=True,
    )
    return [
        {
            "clip": clip,
            "start": times[0],
            "end": times[1],
            "answer": answer,
            "posterior": share,
            "surprise": surprise,
            "frames": frames,
        }
        for clip, answer, surprise, frames, share, times in rows
    ]


def recognised(
    path: Path, paths: Sequence[Path], params: Params, seed: int, progress: Progress
) -> dict[str, np.ndarray]:
    """The arrays of the `recognition` artefact."""
    import numpy as np

    from ipcli.io.files import h5
    from ipcli.models.mocap import behaviours, recognition
    from ipcli.params import resolve

    stored = h5.read(path, "behaviours")
    model, known = behaviours.of_arrays(stored.arrays), asked(stored.arrays, path, paths, params)
    settings = resolve(Features, flags=stored.provenance["params"]["learning"]["features"])
    progress(0.2, "features")
    density = recognition.log_densities(model, motions.features(known, stored.arrays["lengths"], settings))
    if params.unordered or not params.motion:
        density = recognition.poses_alone(model, density)
    if not np.isfinite(density).any():
        raise NoSolution(
            f"{paths[0]}: no frame shows any group of joints whole. The model needs {', '.join(model.groups)}"
        )
    progress(0.7, "answers")
    queries = posed(known, params, seed)
    posterior, surprise = (
        f(model, density, params.decision) for f in (recognition.frame_posteriors, recognition.surprises)
    )
    limit = recognition.threshold(stored.arrays["surprise"], params.decision) if params.none else np.inf
    rows, count = queries.rows, len(queries.clip)
    told = recognition.answer(posterior[rows], surprise[rows], queries.query, count, params.decision, limit)
    names = np.array([*model.actions, NONE], np.str_)
    answered = names[told.action]
    arrays = described(known, queries, told, model) | {
        "answers": answered,
        "threshold": np.float64(limit),
        "group_posterior": group_shares(density, rows, queries.query, told),
        "queries": np.array("window" if params.window is not None else "unordered" if params.unordered else "clip"),
    }
    return arrays | labelled(known, queries) | (segmented(known, arrays, queries) if params.window is not None else {})


def asked(arrays: Mapping[str, np.ndarray], path: Path, paths: Sequence[Path], params: Params) -> Motions:
    """The clips to recognise, of the people asked for and of the skeleton of the model."""
    from ipcli.geometry.skeleton import Skeleton
    from ipcli.stages.mocap.mocap_train import groups_of

    skeleton = Skeleton(tuple(map(str, arrays["joints"])), tuple(map(int, arrays["parents"])))
    return motions.of_people(motions.read(paths, params.reading, groups_of(arrays, path.name), skeleton), params.actors)


def posed(known: Motions, params: Params, seed: int) -> Queries:
    """The questions: whole clips, handfuls of their frames in no order, or windows along them."""
    import numpy as np

    from ipcli.models.mocap import recognition
    from ipcli.rng import stream

    lengths, clip = known.lengths, known.clip
    whole = np.stack([np.zeros(len(lengths)), lengths / _rates(known)], axis=1)
    if params.window is not None:
        return _windows(known, params.window, params.step or params.window / 4)
    if not params.unordered:
        return Queries(np.arange(len(clip)), clip, np.arange(len(lengths)), whole)
    drawn = [
        recognition.handfuls(clip, params.unordered, stream(seed, "mocap-classify", str(n)))
        for n in range(params.handfuls)
    ]
    query = [clip[rows] + n * len(lengths) for n, rows in enumerate(drawn)]
    repeats = params.handfuls
    return Queries(
        np.concatenate(drawn),
        np.concatenate(query),
        np.tile(np.arange(len(lengths)), repeats),
        np.tile(whole, (repeats, 1)),
    )


def _rates(known: Motions) -> np.ndarray:
    import numpy as np

    return np.array([clip.motion.rate for clip in known.clips])


def _windows(known: Motions, width: float, step: float) -> Queries:
    import numpy as np

    from ipcli.models.mocap import recognition

    rows, clips, times, starts = [], [], [], np.cumsum([0, *known.lengths])
    for index, (length, rate) in enumerate(zip(known.lengths, _rates(known), strict=True)):
        spans = recognition.windows(int(length), max(round(width * rate), 1), max(round(step * rate), 1))
        rows += [starts[index] + np.arange(first, last) for first, last in spans]
        clips += [index] * len(spans)
        times.append(spans / rate)
    query = np.repeat(np.arange(len(rows)), [len(one) for one in rows])
    return Queries(np.concatenate(rows), query, np.array(clips), np.concatenate(times))


def described(known: Motions, queries: Queries, told: Any, model: Model) -> dict[str, np.ndarray]:
    """What was asked about, and how sure the answers are."""
    import numpy as np

    return {
        "clips": np.array([known.clips[index].name for index in queries.clip], np.str_),
        "frames": told.frames.astype(np.int64),
        "times": queries.times,
        "actions": np.array(model.actions, np.str_),
        "groups": np.array(model.groups, np.str_),
        "posterior": told.posterior,
        "surprise": told.surprise,
    }


def group_shares(density: np.ndarray, rows: np.ndarray, query: np.ndarray, told: Any) -> np.ndarray:
    """Posterior (q, g) of the best action of each query by each group alone, the mean over the frames that show it; NaN
    without any.
    """
    import numpy as np

    from ipcli.models.mocap import recognition

    best = told.posterior.argmax(axis=1)[query]
    share = np.exp(recognition.group_posteriors(density)[rows, best])
    seen = np.isfinite(share)
    sums = [
        np.bincount(query[s], weights=column[s], minlength=len(told.frames))
        for column, s in zip(share.T, seen.T, strict=True)
    ]
    counts = [np.bincount(query[s], minlength=len(told.frames)) for s in seen.T]
    with np.errstate(invalid="ignore"):
        return np.stack(sums, axis=1) / np.stack(counts, axis=1)


def labelled(known: Motions, queries: Queries) -> dict[str, np.ndarray]:
    """The label that most frames of each query have, if there are any."""
    import numpy as np

    names, number = np.unique(known.labels, return_inverse=True)
    if not names.any():
        return {}
    votes = np.zeros((len(queries.clip), len(names)), np.int64)
    np.add.at(votes, (queries.query, number[queries.rows]), 1)
    return {"truth": names[votes.argmax(axis=1)]}


def segmented(known: Motions, arrays: Mapping[str, np.ndarray], queries: Queries) -> dict[str, np.ndarray]:
    """Windows of one answer in a row as segments; they meet half-way between the middles of the windows."""
    import numpy as np

    rows, shares = (
        [],
        np.where(arrays["answers"] == NONE, 1 - arrays["posterior"].max(axis=1), arrays["posterior"].max(axis=1)),
    )
    for index, clip in enumerate(known.clips):
        mine = np.flatnonzero(queries.clip == index)
        middle = queries.times[mine].mean(axis=1)
        length = len(clip.motion.positions) / clip.motion.rate
        edges = np.concatenate([[0.0], (middle[1:] + middle[:-1]) / 2, [length]])
        for first, last in runs(arrays["answers"][mine]):
            share = float(shares[mine[first:last]].mean())
            rows.append((clip.name, edges[[first, last]], str(arrays["answers"][mine[first]]), share))
    clips, times, names, share = zip(*rows, strict=True)
    found = {
        "clip": np.array(clips, np.str_),
        "time": np.array(times),
        "answer": np.array(names, np.str_),
        "posterior": np.array(share),
    }
    return {f"segment_{key}": value for key, value in found.items()} | truth_segments(known)


def truth_segments(known: Motions) -> dict[str, np.ndarray]:
    """Frames of one label in a row, of the clips that have labels frame by frame."""
    import numpy as np

    rows = []
    for clip in known.clips:
        labels = clip.frame_labels
        for first, last in runs(labels) if labels is not None else ():
            if labels[first]:
                rows.append((clip.name, np.array([first, last]) / clip.motion.rate, str(labels[first])))
    if not rows:
        return {}
    clips, times, names = zip(*rows, strict=True)
    found = {"clip": np.array(clips, np.str_), "time": np.array(times), "answer": np.array(names, np.str_)}
    return {f"truth_segment_{key}": value for key, value in found.items()}


def runs(values: np.ndarray) -> list[tuple[int, int]]:
    """First index and index after the last of equal values in a row."""
    import numpy as np

    edges = np.flatnonzero(values[1:] != values[:-1]) + 1
    bounds = [0, *edges.tolist(), len(values)]
    return list(zip(bounds[:-1], bounds[1:], strict=True)) if len(values) else []


def write_csv(path: Path, arrays: Mapping[str, np.ndarray], provenance: Mapping[str, Any]) -> None:
    """A line for each segment, or else for each query."""
    import csv
    import io

    from ipcli.io.files import atomic

    text = io.StringIO()
    lines = csv.writer(text, lineterminator="\n")
    kind = "segment_" if "segment_clip" in arrays else ""
    clips, times, names = (
        arrays[kind + name] for name in (("clip", "time", "answer") if kind else ("clips", "times", "answers"))
    )
    shares = arrays["segment_posterior"] if kind else arrays["posterior"].max(axis=1)
    lines.writerow(["clip", "start_s", "end_s", "action", "posterior"])
    for clip, (start, end), name, share in zip(clips, times, names, shares, strict=True):
        lines.writerow([clip, f"{start:.3f}", f"{end:.3f}", name, f"{share:.4f}"])
    atomic.write_text(path, text.getvalue())
