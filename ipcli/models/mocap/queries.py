"""What is asked of a model: whole clips, unordered frames of them, or windows along long takes (thesis 5.10, 5.11)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ipcli.models.mocap import calibration, recognition
from ipcli.models.mocap.behaviours import Model
from ipcli.models.mocap.fold_models import PART, FoldModels
from ipcli.models.mocap.motions import NONE, Motions
from ipcli.models.mocap.parameters import Decision
from ipcli.models.mocap.recognition import Answer
from ipcli.rng import stream

STAGE = "mocap-classify"  # names the random streams


class Queries(NamedTuple):
    """Which frames belong to which query."""

    rows: np.ndarray  # (r,), indices of frames
    query: np.ndarray  # (r,), the query of each
    clip: np.ndarray  # (q,), the clip of each query
    times: np.ndarray  # (q, 2), seconds from the start of the clip


def whole_clips(known: Motions) -> Queries:
    """Ask about each clip by all its frames."""
    clip = known.clip
    return Queries(np.arange(len(clip)), clip, np.arange(len(known.clips)), _spans(known))


def unordered_frames(known: Motions, frames: int, draws: int, seed: int) -> Queries:
    """Ask about so many frames of each clip, drawn at random, in no order; so many such draws of each clip."""
    clip, count = known.clip, len(known.clips)
    drawn = [recognition.draw_unordered(clip, frames, stream(seed, STAGE, str(n))) for n in range(draws)]
    return Queries(
        np.concatenate(drawn),
        np.concatenate([clip[rows] + n * count for n, rows in enumerate(drawn)]),
        np.tile(np.arange(count), draws),
        np.tile(_spans(known), (draws, 1)),
    )


def windows(known: Motions, width: float, step: float) -> Queries:
    """Ask about windows along each clip, of a width and from one to the next a step in seconds."""
    rows, clips, times, starts = [], [], [], np.cumsum([0, *known.lengths])
    for index, (length, rate) in enumerate(zip(known.lengths, known.rates, strict=True)):
        spans = recognition.windows(int(length), max(round(width * rate), 1), max(round(step * rate), 1))
        rows += [starts[index] + np.arange(first, last) for first, last in spans]
        clips += [index] * len(spans)
        times.append(spans / rate)
    query = np.repeat(np.arange(len(rows)), [len(one) for one in rows])
    return Queries(np.concatenate(rows), query, np.array(clips), np.concatenate(times))


def _spans(known: Motions) -> np.ndarray:
    """Start and end (c, 2) of each clip in seconds."""
    return np.stack([np.zeros(len(known.clips)), known.lengths / known.rates], axis=1)


class Refusal(NamedTuple):
    """When the answer is none of the actions."""

    judges: FoldModels  # what they say of a whole clip decides, of recordings in order or of poses alone
    densities: Sequence[np.ndarray]  # (f, a, g) of all frames, log, by each of their models
    ordered: bool = True  # whether the queries are recordings in order
    whole: bool = True  # whether they are whole clips; a part of one says less, and surprise alone decides
    is_allowed: bool = True  # the answer none
    least: float = 0.0  # posterior of the best action below which it is none

    @property
    def by_judges(self) -> bool:
        """Whether the models of the folds decide; else surprise alone does."""
        return self.whole and self.ordered in self.judges.references

    def threshold(self, decision: Decision) -> float:
        """The novelty above which the answer is none."""
        if not self.is_allowed:
            return np.inf
        return calibration.threshold(decision) if self.by_judges else self.surprise_threshold(decision)

    def surprise_threshold(self, decision: Decision) -> float:
        """The surprise above which it is, where that alone decides."""
        return recognition.threshold(self.judges.surprise, decision) if self.is_allowed else np.inf

    def novelty(self, queries: Queries, frames: np.ndarray, decision: Decision) -> np.ndarray:
        """How unlike held-out clips each query (q,) is to the judges, of so many frames (q,) that could be used; NaN of
        those that do not show all groups, or are too short to be called none.
        """
        densities, reference = [one[queries.rows] for one in self.densities], self.judges.references[self.ordered]
        asked = self.judges.measured(densities, queries.query, len(frames), decision, ordered=self.ordered)
        return np.where(reference.is_comparable(asked[0]) & (frames >= PART), reference.novelty(asked), np.nan)


def recognise(
    model: Model, density: np.ndarray, known: Motions, queries: Queries, decision: Decision, refuse: Refusal
) -> dict[str, np.ndarray]:
    """Answer the queries from the frames' log densities (f, a, g); arrays of the `action-recognition` artefact."""
    rows, count = queries.rows, len(queries.clip)
    posterior = recognition.frame_posteriors(model, density, decision)
    surprise = recognition.novelty_scores(model, density)
    told = recognition.answer(posterior[rows], surprise[rows], queries.query, count, decision)
    novelty, threshold = told.novelty, refuse.threshold(decision)
    is_known = told.novelty <= refuse.surprise_threshold(decision)
    if refuse.by_judges:
        novelty = refuse.novelty(queries, told.frames, decision)
        plain = is_known | ((told.frames < PART) & (told.frames > 0))
        is_known = np.where(np.isfinite(novelty), novelty <= threshold, plain)
    is_known &= told.posterior.max(axis=1) >= (refuse.least if refuse.is_allowed else 0.0)
    return (
        {
            "clips": np.array([known.clips[index].name for index in queries.clip], np.str_),
            "frames": told.frames.astype(np.int64),
            "times": queries.times,
            "actions": np.array(model.actions, np.str_),
            "groups": np.array(model.groups, np.str_),
            "posterior": told.posterior,
            "novelty": novelty,
            "answers": np.array([*model.actions, NONE], np.str_)[np.where(is_known, told.action, recognition.NONE)],
            "threshold": np.array(threshold, np.float64),
            "group_posterior": group_shares(density, queries, told),
        }
        | query_labels(known, queries)
        | _people(known, queries)
    )


def _people(known: Motions, queries: Queries) -> dict[str, np.ndarray]:
    """Whom each query is of, if that is known of any."""
    return {"actors": known.actors[queries.clip]} if known.actors.astype(bool).any() else {}


def group_shares(density: np.ndarray, queries: Queries, told: Answer) -> np.ndarray:
    """Posterior (q, g) of the best action of each query by each group alone, the mean over the frames that show it; NaN
    without any.
    """
    query, best = queries.query, told.posterior.argmax(axis=1)[queries.query]
    share = np.exp(recognition.group_posteriors(density)[queries.rows, best])
    seen, count = np.isfinite(share), len(told.frames)
    sums = [
        np.bincount(query[s], weights=column[s], minlength=count) for column, s in zip(share.T, seen.T, strict=True)
    ]
    counts = [np.bincount(query[s], minlength=count) for s in seen.T]
    with np.errstate(invalid="ignore"):
        return np.stack(sums, axis=1) / np.stack(counts, axis=1)


def query_labels(known: Motions, queries: Queries) -> dict[str, np.ndarray]:
    """The label that most frames of each query have, if there are any."""
    names, number = np.unique(known.labels, return_inverse=True)
    if not names.any():
        return {}
    votes = np.zeros((len(queries.clip), len(names)), np.int64)
    np.add.at(votes, (queries.query, number[queries.rows]), 1)
    return {"truth": names[votes.argmax(axis=1)]}


def segments(known: Motions, arrays: Mapping[str, np.ndarray], queries: Queries) -> dict[str, np.ndarray]:
    """Join windows of one answer in a row to segments; they meet half-way between the middles of the windows. Of the
    windows of a segment the means of the posteriors and of the novelty count.

    `arrays` as `recognise` gives them of windows.
    """
    clips, times, names, means, strange = [], [], [], [], []
    for index, clip in enumerate(known.clips):
        mine = np.flatnonzero(queries.clip == index)
        middle = queries.times[mine].mean(axis=1)
        length = len(clip.motion.positions) / clip.motion.rate
        edges = np.concatenate([[0.0], (middle[1:] + middle[:-1]) / 2, [length]])
        for first, last in runs(arrays["answers"][mine]):
            clips.append(clip.name)
            times.append(edges[[first, last]])
            names.append(str(arrays["answers"][mine[first]]))
            means.append(arrays["posterior"][mine[first:last]].mean(axis=0))
            strange.append(arrays["novelty"][mine[first:last]].mean())
    posterior = np.stack(means)
    return {
        "segment_clip": np.array(clips, np.str_),
        "segment_time": np.array(times),
        "segment_answer": np.array(names, np.str_),
        "segment_best": arrays["actions"][posterior.argmax(axis=1)],
        "segment_posterior": posterior.max(axis=1),
        "segment_novelty": np.array(strange, np.float64),
    } | label_segments(known)


def label_segments(known: Motions) -> dict[str, np.ndarray]:
    """Frames of one label in a row, of the clips that have labels frame by frame; nothing if no clip has."""
    clips, times, names = [], [], []
    for clip in known.clips:
        if clip.frame_labels is None:
            continue
        for first, last in runs(clip.frame_labels):
            if clip.frame_labels[first]:
                clips.append(clip.name)
                times.append(np.array([first, last]) / clip.motion.rate)
                names.append(str(clip.frame_labels[first]))
    found = {"clip": np.array(clips, np.str_), "time": np.array(times), "answer": np.array(names, np.str_)}
    return {f"truth_segment_{key}": value for key, value in found.items()} if clips else {}


def runs(values: np.ndarray) -> list[tuple[int, int]]:
    """First index and index after the last of equal values in a row."""
    edges = np.flatnonzero(values[1:] != values[:-1]) + 1
    bounds = [0, *edges.tolist(), len(values)]
    return list(zip(bounds[:-1], bounds[1:], strict=True)) if len(values) else []
