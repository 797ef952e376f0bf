"""How often a model that learnt from a part of the clips names the others right, for all splits of a protocol."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ipcli.inverse.bayes.mixture import Fitted
from ipcli.measurements.names import position
from ipcli.models.mocap import recognition, splits
from ipcli.models.mocap.motions import Motions, number_actions, with_mirror_images
from ipcli.models.mocap.parameters import Decision, Learning
from ipcli.models.mocap.splits import Split
from ipcli.models.mocap.training import STAGE as TRAINING
from ipcli.models.mocap.training import Fit, TrainingSet, component_counts, fit_in_turn
from ipcli.rng import stream

STAGE = "mocap-evaluate"  # names the random streams


def make_splits(
    known: Motions, kind: str, seed: int, *, test: Sequence[str] = (), only: Sequence[str] = (), repeats: int = 1
) -> list[Split]:
    """Split the labelled frames of the clips, one of splits.KINDS.

    `test`: people to recognise (subjects); none given: every other one. `only`: of the published ones these. `repeats`:
    of the random ones so many. Raises what splits.make raises, and ParameterError for a published split that is not
    there.
    """
    labels, people = known.labels, tuple(np.unique(known.actors))
    frames = splits.Frames(known.clip, np.array([one.label for one in known.clips], np.str_), known.actors, labels)
    published, found = _published(known.splits, only), []
    repeats = repeats if kind in ("clips", "frames") else 1
    for number in range(repeats):
        rng = stream(seed, STAGE, f"{kind} {number}")
        made = splits.make(kind, frames, rng, test=test or people[1::2], published=published)
        found += [replace(split, name=f"{split.name} {number + 1}") if repeats > 1 else split for split in made]
    return [replace(split, train=split.train & (labels != ""), test=split.test & (labels != "")) for split in found]


def _published(known: Mapping[str, np.ndarray], only: Sequence[str]) -> dict[str, np.ndarray]:
    names = tuple(known)
    wanted = [names[position(names, name, "published split")] for name in only] or names
    return {name: known[name] for name in wanted}


def evaluate(
    known: Motions,
    parts: Sequence[Split],
    learning: Learning,
    decision: Decision,
    seed: int,
    *,
    unordered: Sequence[int] = (),
    draws: int = 1,
    fit: Fit | None = None,
) -> dict[str, np.ndarray]:
    """Learn and ask for each split; right and wrong answers as arrays of the `action-evaluation` artefact.

    `unordered` (h,): so many frames of a clip are asked about together, by their poses alone, with so many `draws` of
    each. `fit` learns all mixtures, as of learn_behaviours.
    """
    fit = fit or (lambda points: fit_in_turn(points, learning, seed))
    names, actions = number_actions(known.labels)
    learnt = with_mirror_images(known) if learning.mirror else known
    sets = {one.name: _training_set(known, learnt, one, names, actions, learning, seed) for one in parts}
    fitted = fit({f"{split}: {cell}": x for split, one in sets.items() for cell, x in one.points.items()})
    tables = []
    for split in parts:
        training = sets[split.name]
        own = {cell: fitted[f"{split.name}: {cell}"] for cell in training.cells}
        questions = _ask(known, split, actions, training, own, decision)
        tables.append(
            questions.confusions(decision)
            | questions.clips(known, decision)
            | {"unordered_confusion": questions.unordered(unordered, draws, decision, seed, split.name)}
            | _sizes(known, split)
            | {"components": _components(training, own)}
        )
    by_clip = [key for key in tables[0] if key.startswith("clip_") or key == "clips"]
    return (
        {key: np.stack([table[key] for table in tables]) for key in tables[0] if key not in by_clip}
        | {key: np.concatenate([table[key] for table in tables]) for key in by_clip}
        | {
            "splits": np.array([split.name for split in parts], np.str_),
            "classes": np.array(names, np.str_),
            "groups": np.array(list(sets[parts[0].name].projections), np.str_),
            "unordered_frames": np.array(unordered, np.int64),
            "clip_split": np.repeat(np.arange(len(parts)), [len(table["clips"]) for table in tables]),
        }
    )


def _training_set(
    known: Motions,
    learnt: Motions,
    split: Split,
    names: tuple[str, ...],
    actions: np.ndarray,
    settings: Learning,
    seed: int,
) -> TrainingSet:
    """What a split learns from, mirror images included if `learnt` has them after the clips `known`; the common
    skeleton too is that of its people alone.
    """
    features = learnt.features(_lengths(known, split), settings.features)
    own = np.resize(np.where(split.train, actions, -1), len(learnt.clip))
    return TrainingSet.draw(features, own, names, settings, stream(seed, TRAINING, f"frames{split.name}"))


def _lengths(known: Motions, split: Split) -> np.ndarray:
    """Bone lengths (j,) of the clips that are learnt from."""
    return known.reference_lengths(np.unique(known.clip[split.train]))


def _sizes(known: Motions, split: Split) -> dict[str, np.ndarray]:
    """How many clips and frames are on either side."""
    sides = {"train": split.train, "test": split.test}
    clips = {f"{side}_clips": np.array(len(np.unique(known.clip[rows]))) for side, rows in sides.items()}
    return clips | {f"{side}_frames": np.array(rows.sum()) for side, rows in sides.items()}


def _components(training: TrainingSet, fitted: Mapping[str, Fitted]) -> np.ndarray:
    """Posterior mean of the number of clusters of each cell, and its 5 % and 95 % quantiles, (a, g, 3)."""
    counts = [component_counts(one) for one in fitted.values()]
    return np.array(counts).reshape(len(training.names), len(training.projections), 3)


def _ask(
    known: Motions,
    split: Split,
    actions: np.ndarray,
    training: TrainingSet,
    fitted: Mapping[str, Fitted],
    decision: Decision,
) -> Questions:
    """The answers of the model of a split to each frame of its test part."""
    rows = np.flatnonzero(split.test)
    features = known.features(_lengths(known, split), training.settings.features)
    model = training.model(fitted)
    density = recognition.log_densities(model, {group: x[rows] for group, x in features.items()})
    whole, poses = (
        FrameAnswers.of(known.clip[rows], actions[rows], recognition.frame_posteriors(model, one, decision))
        for one in (density, recognition.poses_alone(model, density))
    )
    by_group = recognition.group_posteriors(density)
    accuracy = [group_accuracy(by_group[:, :, g], actions[rows]) for g in range(len(model.groups))]
    return Questions(whole, poses, np.array(accuracy))


@dataclass(frozen=True, eq=False)
class FrameAnswers:
    """What single frames say, and which clip they are of. Of a clip of several actions, each action is a question by
    itself. Frames that show no group whole are left out.
    """

    posterior: np.ndarray  # (f, a), log, of each frame
    truth: np.ndarray  # (f,), index of its action
    query: np.ndarray  # (f,), which question a frame is of
    label: np.ndarray  # (q,), index of the action of each question
    clip: np.ndarray  # (q,), index of its clip

    @classmethod
    def of(cls, clip: np.ndarray, truth: np.ndarray, posterior: np.ndarray) -> FrameAnswers:
        """Sort frames by clip (f,) and true action (f,), given their log posteriors (f, a)."""
        seen, actions = np.isfinite(posterior).all(axis=1), posterior.shape[1]
        keys, query = np.unique(clip[seen] * actions + truth[seen], return_inverse=True)
        return cls(posterior[seen], truth[seen], query, keys % actions, keys // actions)

    def answer(self, decision: Decision, chosen: np.ndarray | slice = slice(None)) -> np.ndarray:
        """Posterior (q, a) of each question, from all frames or the chosen ones."""
        posterior = self.posterior[chosen]
        novelty = np.zeros(posterior.shape)
        return recognition.answer(posterior, novelty, self.query[chosen], len(self.label), decision).posterior

    def frame_confusion(self) -> np.ndarray:
        """Truth by answer (a, a) of single frames."""
        return confusion(self.truth, self.posterior.argmax(axis=1), self.posterior.shape[1])

    def sequence_confusion(self, decision: Decision, chosen: np.ndarray | slice = slice(None)) -> np.ndarray:
        """Truth by answer (a, a) of the questions."""
        return confusion(self.label, self.answer(decision, chosen).argmax(axis=1), self.posterior.shape[1])


@dataclass(frozen=True, eq=False)
class Questions:
    """What was asked about the test part of a split: its frames as they are, and by their poses alone."""

    whole: FrameAnswers
    poses: FrameAnswers
    group_accuracy: np.ndarray  # (g,)

    def confusions(self, decision: Decision) -> dict[str, np.ndarray]:
        """Truth by answer of frames and clips."""
        both = {"": self.whole, "pose_": self.poses}
        found = {f"{kind}frame_confusion": one.frame_confusion() for kind, one in both.items()}
        found |= {f"{kind}sequence_confusion": one.sequence_confusion(decision) for kind, one in both.items()}
        return found | {"group_frame_accuracy": self.group_accuracy}

    def clips(self, known: Motions, decision: Decision) -> dict[str, np.ndarray]:
        """The answer to each clip, a row for each of its actions."""
        posterior = self.whole.answer(decision)
        return {
            "clips": np.array([known.clips[index].name for index in self.whole.clip], np.str_),
            "clip_truth": self.whole.label,
            "clip_answer": posterior.argmax(axis=1),
            "clip_posterior": posterior.max(axis=1),
        }

    def unordered(self, sizes: Sequence[int], draws: int, decision: Decision, seed: int, split: str) -> np.ndarray:
        """Truth by answer (h, a, a) of so many frames of a clip drawn at random, all draws together."""
        classes = self.poses.posterior.shape[1]
        found = np.zeros((len(sizes), classes, classes), np.int64)
        for size, table in zip(sizes, found, strict=True):
            for draw in range(draws):
                rng = stream(seed, STAGE, f"{split}, {size} frames, {draw}")
                chosen = recognition.draw_unordered(self.poses.query, size, rng)
                table += self.poses.sequence_confusion(decision, chosen)
        return found


def confusion(truth: np.ndarray, answer: np.ndarray, classes: int) -> np.ndarray:
    """Count how often each answer was given to each truth, (c, c) int64."""
    return np.bincount(truth * classes + answer, minlength=classes**2).reshape(classes, classes)


def group_accuracy(posterior: np.ndarray, truth: np.ndarray) -> float:
    """Share of the frames (f, c) that show a group whole and that it names right by itself; 0 if none does."""
    seen = np.isfinite(posterior).all(axis=1)
    return float((posterior[seen].argmax(axis=1) == truth[seen]).mean()) if seen.any() else 0.0
