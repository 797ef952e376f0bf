"""mocap-evaluate: how often a model that learnt from a part of the clips names the others right, for all splits of a
protocol.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ipcli.errors import ParameterError
from ipcli.models.mocap.parameters import Decision, Learning
from ipcli.params import Run, option
from ipcli.progress import Progress, silent
from ipcli.stages.kit.checkpoint import Checkpoint
from ipcli.stages.mocap import motions
from ipcli.stages.mocap.mocap_train import Lesson, chosen, counted, learn, numbered
from ipcli.stages.mocap.motions import Motions, Reading

if TYPE_CHECKING:
    import numpy as np

    from ipcli.models.mocap.splits import Split
    from ipcli.stages.kit.artefact import Outcome

SPLITS = {
    "subjects": "actors",
    "leave-one-out": "leave-one-actor-out",
    "one-to-rest": "one-actor",
    "published": "published",
    "clips": "random-clips",
    "frames": "random-frames",
}


@dataclass(frozen=True)
class Params:
    """How the clips are parted, and how is learnt and recognised."""

    split: str = option(
        "subjects",
        "how to part the clips: by subjects, at random by clips or frames, ...",
        flag="--split",
        choices=tuple(SPLITS),
    )
    test: tuple[str, ...] = option(
        (), "people to recognise with --split subjects; none given: every other one", flag="--test"
    )
    only: tuple[str, ...] = option(
        (), "of the published splits, only these, with commas; none given: all", flag="--only"
    )
    actors: tuple[str, ...] = option(
        (), "take clips of these people only, with commas; none given: of all", flag="--actors"
    )
    actions: tuple[str, ...] = option((), "take these actions only, with commas; none given: all", flag="--actions")
    repeats: int = option(1, "random splits by clips or frames, each drawn anew", flag="--repeats", low=1)
    handfuls: tuple[int, ...] = option(
        (20, 5, 1), "unordered frames of a clip to ask about together", flag="--handfuls", low=1
    )
    draws: int = option(3, "handfuls of each size from each clip", low=1)
    groups: str = option("auto", "groups of joints: auto, the name of shipped ones, or a TOML file", flag="--groups")
    reading: Reading = field(default_factory=Reading)
    learning: Learning = field(default_factory=Learning)
    decision: Decision = field(default_factory=Decision)


def run(paths: Sequence[Path], output: Path, params: Params, run: Run, progress: Progress = silent) -> Outcome:
    """Write what was answered and beside it a page (.html). A run that was killed goes on where its chains were.

    Raises ParameterError for a split that leaves nothing on one side, and what motions.read raises.
    """
    from ipcli import provenance
    from ipcli.params import as_dict
    from ipcli.stages.kit.artefact import Job, make
    from ipcli.stages.kit.pages import page

    inputs = tuple(paths) + ((Path(params.groups),) if Path(params.groups).is_file() else ())
    record = provenance.record("mocap-evaluate", as_dict(params), inputs, "action-evaluation", run.seed)
    work = Checkpoint.of(output, record["digest"])
    job = Job(output, "action-evaluation", "mocap-evaluate", params, inputs, page(output, "action-evaluation"))
    outcome = make(job, lambda: evaluation(paths, params, run, work, progress), run)
    if not run.dry_run:
        work.clear()
    return outcome


def evaluation(
    paths: Sequence[Path], params: Params, run: Run, work: Checkpoint, progress: Progress
) -> dict[str, np.ndarray]:
    """The arrays of the `evaluation` artefact."""
    import numpy as np

    known = chosen(motions.read(paths, params.reading, params.groups), params)
    names, actions = numbered(known.labels)
    if len(names) < 2:
        raise ParameterError(
            f"{paths[0]}: {len(names)} actions have labels; there is nothing to tell apart. Give clips of at least two"
        )
    splits = parted(known, params, run.seed)
    taught = motions.to_learn(known, params.learning.mirror)
    lessons = {split.name: lesson(known, taught, split, names, actions, params, run.seed) for split in splits}
    points = {f"{split}: {cell}": x for split, one in lessons.items() for cell, x in one.points.items()}
    fitted = learn(points, params.learning, run, work, progress)
    tables = []
    for split in splits:
        own = {cell: fitted[f"{split.name}: {cell}"] for cell in lessons[split.name].cells}
        tables.append(asked(known, split, actions, lessons[split.name], own, params, run.seed))
    found = {
        key: np.stack([table[key] for table in tables])
        for key in tables[0]
        if not key.startswith("clip_") and key != "clips"
    }
    each = {
        key: np.concatenate([table[key] for table in tables])
        for key in tables[0]
        if key.startswith("clip_") or key == "clips"
    }
    return (
        found
        | each
        | {
            "split": np.array(params.split),
            "splits": np.array([split.name for split in splits], np.str_),
            "classes": np.array(names, np.str_),
            "groups": np.array(list(next(iter(lessons.values())).projections), np.str_),
            "handfuls": np.array(params.handfuls, np.int64),
            "clip_split": np.repeat(np.arange(len(splits)), [len(table["clips"]) for table in tables]),
        }
    )


def parted(known: Motions, params: Params, seed: int) -> list[Split]:
    """The splits of the protocol; frames without a label are on neither side."""
    from dataclasses import replace

    import numpy as np

    from ipcli.models.mocap import splits
    from ipcli.rng import stream

    labels, clip = known.labels, known.clip
    frames = splits.Frames(clip, np.array([one.label for one in known.clips], np.str_), known.actors, labels)
    people = tuple(np.unique(known.actors))
    test, repeats = params.test or people[1::2], params.repeats if params.split in ("clips", "frames") else 1
    found = []
    for number in range(repeats):
        rng = stream(seed, "mocap-evaluate", f"{params.split} {number}")
        made = splits.make(SPLITS[params.split], frames, rng, test=test, published=published(known.splits, params.only))
        found += [replace(split, name=f"{split.name} {number + 1}") if repeats > 1 else split for split in made]
    return [replace(split, train=split.train & (labels != ""), test=split.test & (labels != "")) for split in found]


def published(splits: Mapping[str, np.ndarray], only: Sequence[str]) -> dict[str, np.ndarray]:
    """Those named, or all if none is."""
    from ipcli.measurements.names import position

    names = tuple(splits)
    wanted = [names[position(names, name, "published split")] for name in only] or names
    return {name: splits[name] for name in wanted}


def lesson(
    known: Motions,
    taught: Motions,
    split: Split,
    names: tuple[str, ...],
    actions: np.ndarray,
    params: Params,
    seed: int,
) -> Lesson:
    """What a split learns from, mirror images included if `taught` has them; the common skeleton too is that of its
    people alone.
    """
    import numpy as np

    features = motions.features(taught, skeleton_of(known, split), params.learning.features)
    learnt = np.resize(np.where(split.train, actions, -1), len(taught.clip))
    return Lesson.of(features, learnt, names, params.learning, seed, split.name)


def skeleton_of(known: Motions, split: Split) -> np.ndarray:
    """Bone lengths (j,) of the clips that are learnt from."""
    import numpy as np

    from ipcli.models.mocap.features import reference_lengths

    return reference_lengths([known.clips[index].motion for index in np.unique(known.clip[split.train])], known.groups)


def asked(
    known: Motions,
    split: Split,
    actions: np.ndarray,
    lesson: Lesson,
    fitted: Mapping[str, Any],
    params: Params,
    seed: int,
) -> dict[str, np.ndarray]:
    """Right and wrong answers to the test part of one split."""
    import numpy as np

    from ipcli.models.mocap import recognition

    rows = np.flatnonzero(split.test)
    features = motions.features(known, skeleton_of(known, split), params.learning.features)
    model = lesson.model(fitted)
    density = recognition.log_densities(model, {group: x[rows] for group, x in features.items()})
    by_group = recognition.group_posteriors(density)
    both = {"": density, "pose_": recognition.poses_alone(model, density)}
    asks = {
        kind: Questions.of(known, rows, actions[rows], recognition.frame_posteriors(model, d, params.decision))
        for kind, d in both.items()
    }
    found = {f"{kind}frame_confusion": one.frames() for kind, one in asks.items()}
    found |= {f"{kind}sequence_confusion": one.sequences(params.decision) for kind, one in asks.items()}
    return (
        found
        | asks[""].clips(known, params.decision)
        | {
            "handful_confusion": handfuls(asks["pose_"], params, seed, split.name),
            "train_clips": np.int64(len(np.unique(known.clip[split.train]))),
            "train_frames": np.int64(split.train.sum()),
            "test_clips": np.int64(len(np.unique(known.clip[rows]))),
            "test_frames": np.int64(len(rows)),
            "group_frame_accuracy": np.array(
                [group_accuracy(by_group[:, :, g], actions[rows]) for g in range(len(model.groups))]
            ),
            "components": np.array([counted(one) for one in fitted.values()]).reshape(
                len(model.actions), len(model.groups), 3
            ),
        }
    )


@dataclass(frozen=True, eq=False)
class Questions:
    """What is asked about: frames that show a group whole, and clips. Of a clip of several actions, each action is a
    question by itself.
    """

    posterior: np.ndarray  # (f, a), log, of each frame
    truth: np.ndarray  # (f,), index of its action
    query: np.ndarray  # (f,), which question a frame is of
    label: np.ndarray  # (q,), index of the action of each question
    clip: np.ndarray  # (q,), index of its clip

    @classmethod
    def of(cls, known: Motions, rows: np.ndarray, truth: np.ndarray, posterior: np.ndarray) -> Questions:
        """Those of the frames `rows` (f,) of all clips."""
        import numpy as np

        seen, actions = np.isfinite(posterior).all(axis=1), posterior.shape[1]
        keys, query = np.unique(known.clip[rows[seen]] * actions + truth[seen], return_inverse=True)
        return cls(posterior[seen], truth[seen], query, keys % actions, keys // actions)

    def answer(self, decision: Decision, chosen: np.ndarray | slice = slice(None)) -> np.ndarray:
        """Posterior (q, a) of each question, from all frames or the chosen ones."""
        import numpy as np

        from ipcli.models.mocap import recognition

        posterior = self.posterior[chosen]
        return recognition.answer(
            posterior, np.zeros(posterior.shape), self.query[chosen], len(self.label), decision
        ).posterior

    def frames(self) -> np.ndarray:
        """Truth by answer of single frames."""
        return confusion(self.truth, self.posterior.argmax(axis=1), self.posterior.shape[1])

    def sequences(self, decision: Decision, chosen: np.ndarray | slice = slice(None)) -> np.ndarray:
        """Truth by answer of the questions."""
        return confusion(self.label, self.answer(decision, chosen).argmax(axis=1), self.posterior.shape[1])

    def clips(self, known: Motions, decision: Decision) -> dict[str, np.ndarray]:
        """The answer to each question."""
        import numpy as np

        posterior = self.answer(decision)
        return {
            "clips": np.array([known.clips[index].name for index in self.clip], np.str_),
            "clip_truth": self.label,
            "clip_answer": posterior.argmax(axis=1),
            "clip_posterior": posterior.max(axis=1),
        }


def handfuls(asked: Questions, params: Params, seed: int, split: str) -> np.ndarray:
    """Truth by answer (h, c, c) of handfuls of frames of each size, all draws together."""
    import numpy as np

    from ipcli.models.mocap import recognition
    from ipcli.rng import stream

    def of_size(size: int) -> np.ndarray:
        rngs = (stream(seed, "mocap-evaluate", f"{split}, {size} frames, {draw}") for draw in range(params.draws))
        return sum(asked.sequences(params.decision, recognition.handfuls(asked.query, size, rng)) for rng in rngs)

    classes = asked.posterior.shape[1]
    return np.array([of_size(size) for size in params.handfuls], np.int64).reshape(-1, classes, classes)


def confusion(truth: np.ndarray, answer: np.ndarray, classes: int) -> np.ndarray:
    """How often each answer was given to each truth, (c, c) int64."""
    import numpy as np

    return np.bincount(truth * classes + answer, minlength=classes**2).reshape(classes, classes)


def group_accuracy(posterior: np.ndarray, truth: np.ndarray) -> float:
    """Share of the frames (f, c) that show a group whole and that it names right by itself; 0 if none does."""
    import numpy as np

    seen = np.isfinite(posterior).all(axis=1)
    return float((posterior[seen].argmax(axis=1) == truth[seen]).mean()) if seen.any() else 0.0
