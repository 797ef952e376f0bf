"""mocap-train: labelled clips -> the behaviours of every action in every group of joints (thesis 5.3, 5.4)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ipcli.errors import ParameterError
from ipcli.models.mocap.parameters import BODY, MOTION, Decision, Learning
from ipcli.params import Run, option
from ipcli.progress import Progress, silent
from ipcli.stages.kit.checkpoint import Checkpoint
from ipcli.stages.mocap import motions
from ipcli.stages.mocap.motions import Motions, Reading

if TYPE_CHECKING:
    import numpy as np

    from ipcli.geometry.skeleton import Groups
    from ipcli.inverse.bayes.mixture import Fitted
    from ipcli.models.mocap.behaviours import Model
    from ipcli.stages.kit.artefact import Outcome

SHOWN = 4  # poses of a behaviour: the most typical, and others
POINTS = "points"
REHEARSAL = 4  # a rehearsal takes one in so many of the frames


@dataclass(frozen=True)
class Params:
    """What to learn from and how."""

    groups: str = option("auto", "groups of joints: auto, the name of shipped ones, or a TOML file", flag="--groups")
    actors: tuple[str, ...] = option(
        (), "learn only from these people, with commas; none given: from all", flag="--actors"
    )
    actions: tuple[str, ...] = option((), "learn only these actions, with commas; none given: all", flag="--actions")
    reading: Reading = field(default_factory=Reading)
    learning: Learning = field(default_factory=Learning)
    decision: Decision = field(default_factory=Decision)


def run(paths: Sequence[Path], output: Path, params: Params, run: Run, progress: Progress = silent) -> Outcome:
    """Write the model and beside it a report (.html). A run that was killed goes on where its chains were.

    Raises ParameterError for clips without labels or an action of hardly a frame, and what motions.read raises.
    """
    from ipcli import provenance
    from ipcli.params import as_dict
    from ipcli.stages.kit.artefact import Job, make
    from ipcli.stages.kit.pages import page

    inputs = tuple(paths) + ((Path(params.groups),) if Path(params.groups).is_file() else ())
    record = provenance.record("mocap-train", as_dict(params), inputs, "behaviours", run.seed)
    work = Checkpoint.of(output, record["digest"])
    job = Job(output, "behaviours", "mocap-train", params, inputs, page(output, "behaviours"))
    outcome = make(job, lambda: model_artefact(paths, params, run, work, progress), run)
    if not run.dry_run:
        work.clear()
    return outcome


def model_artefact(
    paths: Sequence[Path], params: Params, run: Run, work: Checkpoint, progress: Progress
) -> dict[str, np.ndarray]:
    """The arrays of the `behaviours` artefact."""
    from ipcli.models.mocap import behaviours, recognition
    from ipcli.models.mocap.features import reference_lengths

    known = chosen(motions.read(paths, params.reading, params.groups), params)
    lengths = reference_lengths([clip.motion for clip in known.clips], known.groups)
    names, actions = numbered(known.labels)
    taught = motions.to_learn(known, params.learning.mirror)
    features = motions.features(taught, lengths, params.learning.features)
    lesson = Lesson.of(features, numbered(taught.labels)[1], names, params.learning, run.seed)
    trials = rehearsals(known, taught, params, run.seed)
    lessons = {"": lesson} | {trial: one.lesson for trial, one in trials.items()}
    points = {f"{trial}{cell}": x for trial, one in lessons.items() for cell, x in one.points.items()}
    found = learn(points, params.learning, run, work, progress)
    fitted = {cell: found[cell] for cell in lesson.cells}
    model = lesson.model(fitted)
    tried = {
        trial: one.lesson.model({cell: found[f"{trial}{cell}"] for cell in one.lesson.cells})
        for trial, one in trials.items()
    }
    progress(1.0, "writing")
    return (
        behaviours.arrays(model)
        | body(known, lengths, model.groups)
        | {"surprise": held_out_surprises(tried, trials, known, actions, params), **_counts(known, actions, names)}
        | {"preferences": recognition.preference(model, params.decision)}
        | diagnosed(lesson, fitted)
        | drawn(lesson, fitted, motions.poses(taught, lengths))
    )


def chosen(known: Motions, params: Params) -> Motions:
    """The clips of the people and actions asked for. ParameterError for a name that is not there, or nothing
    to learn.
    """
    from dataclasses import replace

    from ipcli.measurements.names import position

    known = motions.of_people(known, params.actors)
    labels = tuple(sorted({*map(str, known.labels)} - {""}))
    actions = {labels[position(labels, name, "action")] for name in params.actions} or {*labels}
    if not actions:
        raise ParameterError(
            "none of the clips has a label to learn. Name them by a manifest (ipcli import-clips --manifest) or by "
            "folders"
        )
    return replace(known, clips=tuple(_only(clip, actions) for clip in known.clips))


def _only(clip: Any, actions: set[str]) -> Any:
    """The clip with the labels of these actions alone."""
    from dataclasses import replace

    import numpy as np

    frame_labels = clip.frame_labels
    if frame_labels is not None:
        frame_labels = np.where(np.isin(frame_labels, list(actions)), frame_labels, "")
    return replace(clip, label=clip.label if clip.label in actions else "", frame_labels=frame_labels)


def numbered(labels: np.ndarray) -> tuple[tuple[str, ...], np.ndarray]:
    """The actions in order of their names, and the number (n,) of each label; -1 for none."""
    import numpy as np

    names = tuple(sorted({*map(str, labels)} - {""}))
    return names, np.where(labels == "", -1, np.searchsorted(names, labels)) if names else np.full(len(labels), -1)


@dataclass(frozen=True, eq=False)
class Lesson:
    """What the mixtures are learnt from: the coordinates of the drawn frames, a cell an action and group."""

    names: tuple[str, ...]
    settings: Learning
    rows: np.ndarray  # (m,), the frames that were drawn
    actions: np.ndarray  # (m,), their actions
    projections: Mapping[str, Any]  # of each group
    coordinates: Mapping[str, np.ndarray]  # (m, d) of each group

    @classmethod
    def of(
        cls,
        features: Mapping[str, np.ndarray],
        actions: np.ndarray,
        names: tuple[str, ...],
        settings: Learning,
        seed: int,
        split: str = "",
    ) -> Lesson:
        """Frames drawn from those whose action (n,) is not -1."""
        from ipcli.models.mocap import behaviours
        from ipcli.rng import stream

        for action, name in enumerate(names):
            if (count := int((actions == action).sum())) < behaviours.LEAST_FRAMES:
                least = behaviours.LEAST_FRAMES
                raise ParameterError(
                    f"action '{name}' has {count} frame{'s' * (count != 1)} to learn from: give at least {least}, or "
                    "leave it out"
                )
        rows = behaviours.draw_frames(actions, len(names), settings, stream(seed, "mocap-train", f"frames{split}"))
        features = {group: x[rows] for group, x in behaviours.with_body(features, settings.features.body).items()}
        projections = behaviours.fit_projections(features, actions[rows], settings)
        coordinates = {group: project(features[group]) for group, project in projections.items()}
        return cls(names, settings, rows, actions[rows], projections, coordinates)

    @property
    def cells(self) -> dict[str, tuple[int, str]]:
        """Action and group of each cell by its name."""
        return {
            f"{name}, {group}": (action, group) for action, name in enumerate(self.names) for group in self.projections
        }

    @property
    def points(self) -> dict[str, np.ndarray]:
        """The coordinates (n, d) of each cell by its name."""
        return {name: self.coordinates[group][self.actions == action] for name, (action, group) in self.cells.items()}

    def members(self, name: str) -> np.ndarray:
        """The frames (n,) that the mixture of a cell was learnt from: those that show the whole group."""
        import numpy as np

        action, group = self.cells[name]
        seen = np.isfinite(self.coordinates[group]).all(axis=1)
        return self.rows[(self.actions == action) & seen]

    def model(self, fitted: Mapping[str, Fitted]) -> Model:
        """What recognition needs of the mixtures of all cells."""
        from ipcli.models.mocap import behaviours

        return behaviours.assemble(
            self.names, self.projections, {self.cells[name]: one for name, one in fitted.items()}, self.settings
        )


def learn(
    points: Mapping[str, np.ndarray], settings: Learning, run: Run, work: Checkpoint, progress: Progress
) -> dict[str, Fitted]:
    """The mixture of each cell, wherever the executor runs it. Raises ItemsFailed when some could not be learnt."""
    from ipcli.executor import map_items

    work.save(POINTS, points)
    one = partial(learn_cell, settings=settings, seed=run.seed, work=work)
    map_items(one, list(points), run.executor, progress)
    return {name: _fitted(work.load(f"{name}.done")) for name in points}


def learn_cell(name: str, *, settings: Learning, seed: int, work: Checkpoint) -> None:
    """Learn one cell and save it, from where its chains were last seen."""
    from ipcli.models.mocap import behaviours
    from ipcli.rng import stream

    if work.load(f"{name}.done") is not None:
        return
    points, rng = work.load(POINTS)[name], stream(seed, "mocap-train", name)
    found = behaviours.learn(
        points, settings, rng, state=work.load(f"{name}.chains"), watch=partial(work.save, f"{name}.chains")
    )
    work.save(
        f"{name}.done",
        found.predictive.arrays() | {key: getattr(found, key) for key in ("partitions", "log_joint", "trace")},
    )


def _fitted(arrays: Mapping[str, np.ndarray]) -> Fitted:
    from ipcli.inverse.bayes.mixture import Fitted
    from ipcli.inverse.bayes.predictive import Predictive

    own = ("partitions", "log_joint", "trace")
    return Fitted(
        Predictive(**{key: value for key, value in arrays.items() if key not in own}),
        **{key: arrays[key] for key in own},
    )


def body(known: Motions, lengths: np.ndarray, groups: tuple[str, ...]) -> dict[str, np.ndarray]:
    """The skeleton and its groups, as a recognition needs them again."""
    import numpy as np

    skeleton, parts = known.skeleton, known.groups.indices(known.skeleton)
    member = [(groups.index(part), joint) for part, joints in parts.items() for joint in joints]
    roles = {
        name: np.array(getattr(known.groups, name), np.str_) for name in ("root", "left", "right", "top", "bottom")
    }
    return roles | {
        "joints": np.array(skeleton.joints, np.str_),
        "parents": np.array(skeleton.parents, np.int64),
        "lengths": lengths,
        "group_members": np.array(member, np.int64).reshape(-1, 2),
        "up": np.array(known.groups.up, float),
    }


def groups_of(arrays: Mapping[str, np.ndarray], source: str) -> Groups:
    """The groups that `body` wrote."""
    from ipcli.geometry.skeleton import Groups

    joints, names = [str(name) for name in arrays["joints"]], [str(name) for name in arrays["groups"]]
    parts = {
        name: tuple(joints[j] for g, j in arrays["group_members"] if g == index) for index, name in enumerate(names)
    }
    lists = {role: tuple(map(str, arrays[role])) for role in ("left", "right", "bottom")}
    single = {role: str(arrays[role]) for role in ("root", "top")}
    kept = {name: members for name, members in parts.items() if name not in (BODY, MOTION)}
    return Groups(kept, **single, **lists, up=tuple(map(float, arrays["up"])), source=source)


@dataclass(frozen=True, eq=False)
class Rehearsal:
    """A lesson from a part of the clips."""

    taught: np.ndarray  # (c,) bool, the clips
    features: Mapping[
        str, np.ndarray
    ]  # (n, D) of each group, of all clips and then of mirror images, on the common skeleton of those that teach
    lesson: Lesson


def rehearsals(known: Motions, taught: Motions, params: Params, seed: int) -> dict[str, Rehearsal]:
    """Lessons from one half of the people each, or of the clips of a single one, to see how strange the other half
    looks.

    `taught` as `to_learn` gives it of the clips `known`. They take a part of the frames only. An action that one half
    does not show cannot be judged from it.
    """
    from dataclasses import replace

    import numpy as np

    from ipcli.models.mocap.features import reference_lengths

    settings = replace(params.learning, frames=max(params.learning.frames // REHEARSAL, 2))
    actions, found = numbered(taught.labels)[1], {}
    for number, half in enumerate(halves(known), 1):
        learnt = np.where(np.resize(half[known.clip], len(actions)), actions, -1)
        shown = [action for action in range(int(actions.max()) + 1) if (learnt == action).sum() > 1]
        if shown:
            names = tuple(numbered(known.labels)[0][action] for action in shown)
            own = np.full(len(learnt), -1)
            for index, action in enumerate(shown):
                own[learnt == action] = index
            lengths = reference_lengths([known.clips[clip].motion for clip in np.flatnonzero(half)], known.groups)
            features = motions.features(taught, lengths, settings.features)
            lesson = Lesson.of(features, own, names, settings, seed, f"half {number}")
            found[f"half {number}: "] = Rehearsal(half, features, lesson)
    return found


def halves(known: Motions) -> list[np.ndarray]:
    """Every other person (c,) bool and the others; every other clip of a single person."""
    import numpy as np

    people = np.unique(known.actors)
    first = np.isin(known.actors, people[::2]) if len(people) > 1 else np.arange(len(known.clips)) % 2 == 0
    return [first, ~first] if len(known.clips) > 1 else []


def held_out_surprises(
    tried: Mapping[str, Model], trials: Mapping[str, Rehearsal], known: Motions, actions: np.ndarray, params: Params
) -> np.ndarray:
    """How strange each labelled clip looks to a model of the other half, ascending; later clips stranger than those are
    no action.
    """
    import numpy as np

    from ipcli.models.mocap import recognition

    told = []
    for trial, model in tried.items():
        one = trials[trial]
        rows = np.flatnonzero(~one.taught[known.clip] & (actions >= 0) & np.isin(known.labels, model.actions))
        density = recognition.log_densities(model, {group: x[rows] for group, x in one.features.items()})
        posterior, surprise = (
            f(model, density, params.decision) for f in (recognition.frame_posteriors, recognition.surprises)
        )
        told.append(
            recognition.answer(posterior, surprise, known.clip[rows], len(known.clips), params.decision).surprise
        )
    every = np.concatenate(told) if told else np.empty(0)
    return np.sort(every[np.isfinite(every)])


def _counts(known: Motions, actions: np.ndarray, names: tuple[str, ...]) -> dict[str, np.ndarray]:
    import numpy as np

    clips = [len(np.unique(known.clip[actions == action])) for action in range(len(names))]
    return {
        "frames": np.bincount(actions[actions >= 0], minlength=len(names)),
        "clips": np.array(clips, np.int64),
        "actors": np.unique(known.actors),
    }


def diagnosed(lesson: Lesson, fitted: Mapping[str, Fitted]) -> dict[str, np.ndarray]:
    """Numbers of clusters with their posterior, the traces, and how far the chains can be trusted, an entry a cell."""
    import numpy as np

    from ipcli.inverse.bayes import diagnostics
    from ipcli.inverse.bayes.chain import TRACE

    shape, burn_in = (len(lesson.names), len(lesson.projections)), lesson.settings.mixture.burn_in
    cells = [fitted[name] for name in lesson.cells]
    trace = np.stack([one.trace[:, :, TRACE.index("clusters")] for one in cells], axis=-1)
    settled = np.moveaxis(trace[:, burn_in:], -1, 0)
    return {
        "components": np.array([counted(one) for one in cells]).reshape(*shape, 3),
        "trace_clusters": np.ascontiguousarray(trace).reshape(*trace.shape[:2], *shape).astype(np.int32),
        "r_hat": np.array([diagnostics.split_r_hat(one) for one in settled]).reshape(shape),
        "ess": np.array([diagnostics.effective_draws(one) for one in settled]).reshape(shape),
    }


def counted(fitted: Fitted) -> tuple[float, float, float]:
    """Posterior mean, 5 % and 95 % of the number of clusters."""
    import numpy as np

    share = fitted.cluster_counts()
    low, high = (int(np.searchsorted(np.cumsum(share), level)) for level in (0.05, 0.95))
    return float(share @ np.arange(len(share))), low, high


def drawn(lesson: Lesson, fitted: Mapping[str, Fitted], poses: np.ndarray) -> dict[str, np.ndarray]:
    """The behaviours of the point partitions, each by poses (thesis figure 5.6): the most typical frame first, then
    less and less typical ones.
    """
    import numpy as np

    groups, found = list(lesson.projections), []
    for name, (action, group) in lesson.cells.items():
        points, rows, labels = lesson.points[name], lesson.members(name), fitted[name].labels()
        points = points[np.isfinite(points).all(axis=1)]
        density = fitted[name].behaviours().students.log_density(points)
        for label in range(int(labels.max()) + 1):
            mine = np.flatnonzero(labels == label)
            order = rows[mine[np.argsort(-density[mine, label], kind="stable")]]
            shown = order[np.linspace(0, len(order) - 1, SHOWN).round().astype(int)]
            found.append((action, groups.index(group), len(mine) / len(labels), poses[shown]))
    action, group, share, shown = zip(*found, strict=True)
    return {
        "behaviour_action": np.array(action, np.int64),
        "behaviour_group": np.array(group, np.int64),
        "behaviour_share": np.array(share),
        "behaviour_poses": np.array(shown, np.float32),
    }
