"""Learning the behaviours of every action in every group from labelled clips (thesis 5.3, 5.4).

    artefact = learn_behaviours(motions, Learning(), Decision(), seed=0)

A *cell* is one action in one group. The mixtures of the cells do not depend on each other, so that `fit`, which learns
all of them, may be anything from a loop (the default) to a cluster.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from ipcli.inverse.bayes import diagnostics
from ipcli.inverse.bayes.chain import TRACE
from ipcli.inverse.bayes.mixture import Fitted, State
from ipcli.models.mocap import behaviours, recognition
from ipcli.models.mocap.behaviours import Model
from ipcli.models.mocap.calibration import Fold
from ipcli.models.mocap.fold_models import FoldModels
from ipcli.models.mocap.motions import Motions, number_actions, with_mirror_images
from ipcli.models.mocap.parameters import Decision, Learning
from ipcli.models.mocap.projection import Projection
from ipcli.rng import stream

STAGE = "mocap-train"  # names the random streams
SHOWN = 4  # poses of a behaviour: the most typical, and others
Fit = Callable[[Mapping[str, np.ndarray]], Mapping[str, Fitted]]  # coordinates (n, d) of each cell -> its mixture


@dataclass(frozen=True, eq=False)
class TrainingSet:
    """The frames that one model learns from, by their coordinates in each group."""

    names: tuple[str, ...]  # of the actions
    settings: Learning
    rows: np.ndarray  # (m,), the frames that were drawn
    actions: np.ndarray  # (m,), their actions
    projections: Mapping[str, Projection]  # of each group
    coordinates: Mapping[str, np.ndarray]  # (m, d) of each group

    @classmethod
    def draw(
        cls,
        features: Mapping[str, np.ndarray],
        actions: np.ndarray,
        names: tuple[str, ...],
        settings: Learning,
        rng: np.random.Generator,
    ) -> TrainingSet:
        """Draw frames from features (n, D) of each group and actions (n,) int, indices of `names`, -1: not to learn.

        Raises ParameterError for an action with hardly a frame, or a group that is never seen whole.
        """
        rows = behaviours.draw_frames(actions, names, settings, rng)
        chosen = {group: x[rows] for group, x in behaviours.with_body(features, settings.features.body).items()}
        projections = behaviours.fit_projections(chosen, actions[rows], settings)
        coordinates = {group: project(chosen[group]) for group, project in projections.items()}
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
        """The frames (n,) that the mixture of a cell learns from: those that show the whole group."""
        action, group = self.cells[name]
        seen = np.isfinite(self.coordinates[group]).all(axis=1)
        return self.rows[(self.actions == action) & seen]

    def model(self, fitted: Mapping[str, Fitted]) -> Model:
        """What recognition needs of the mixtures of all cells."""
        cells = {self.cells[name]: one for name, one in fitted.items()}
        return behaviours.assemble(self.names, self.projections, cells, self.settings)


def fit_cell(
    name: str,
    points: np.ndarray,
    settings: Learning,
    seed: int,
    *,
    state: Mapping[str, np.ndarray] | None = None,
    watch: Callable[[State], None] | None = None,
) -> Fitted:
    """Learn the mixture of one cell; its random stream is named by the cell. `state` and `watch` as of mixture.fit."""
    return behaviours.learn(points, settings, stream(seed, STAGE, name), state=state, watch=watch)


def fit_in_turn(points: Mapping[str, np.ndarray], settings: Learning, seed: int) -> dict[str, Fitted]:
    """Learn the mixtures of all cells one after the other."""
    return {name: fit_cell(name, x, settings, seed) for name, x in points.items()}


def train(
    features: Mapping[str, np.ndarray],
    actions: np.ndarray,
    names: tuple[str, ...],
    settings: Learning,
    rng: np.random.Generator,
) -> Model:
    """Learn a model from features (n, D) of each group and actions (n,) int, as `TrainingSet.draw` takes them."""
    drawn = TrainingSet.draw(features, actions, names, settings, rng)
    points = drawn.points
    by_group = sorted(drawn.cells, key=lambda name: list(drawn.projections).index(drawn.cells[name][1]))
    return drawn.model({name: behaviours.learn(points[name], settings, rng.spawn(1)[0]) for name in by_group})


def learn_behaviours(
    known: Motions, learning: Learning, decision: Decision, seed: int, fit: Fit | None = None
) -> dict[str, np.ndarray]:
    """Learn from all labelled frames of the clips; the arrays of the `behaviours` artefact.

    Raises ParameterError for an action with hardly a frame, or a group that is never seen whole.
    """
    learnt = learn(known, learning, decision, seed, fit)
    images = with_mirror_images(known) if learning.mirror else known
    model, lengths = learnt.model, learnt.lengths
    names, actions = number_actions(known.labels)
    return (
        behaviours.arrays(model)
        | behaviours.body_arrays(known.skeleton, known.groups, lengths, model.groups)
        | learnt.judges.arrays()
        | _counts(known, actions, names)
        | {"preferences": recognition.preference(model, decision)}
        | chain_diagnostics(learnt.training, learnt.fitted)
        | typical_poses(learnt.training, learnt.fitted, images.poses(lengths))
    )


@dataclass(frozen=True, eq=False)
class LearntBehaviours:
    """A model, and what models of other people than clips were held out of say of when the answer is none."""

    model: Model
    lengths: np.ndarray  # (j,), bones of the common skeleton
    training: TrainingSet
    fitted: Mapping[str, Fitted]  # of each cell
    judges: FoldModels


def learn(
    known: Motions, learning: Learning, decision: Decision, seed: int, fit: Fit | None = None, name: str = ""
) -> LearntBehaviours:
    """Learn from all labelled frames of the clips, and lightly from all but a part of the people in turn; `name` starts
    the names of the cells and so of the random streams.

    Raises what learn_behaviours raises.
    """
    fit = fit or (lambda points: fit_in_turn(points, learning, seed))
    lengths = known.reference_lengths()
    names, actions = number_actions(known.labels)
    learnt = with_mirror_images(known) if learning.mirror else known
    features = learnt.features(lengths, learning.features)
    numbers = number_actions(learnt.labels)[1]
    whole = TrainingSet.draw(features, numbers, names, learning, stream(seed, STAGE, f"frames{name}"))
    splits = validation_splits(known, features, learning, seed, name)
    every = {"": whole} | {prefix: split.training for prefix, split in splits.items()}
    found = fit({f"{name}{prefix}{cell}": x for prefix, one in every.items() for cell, x in one.points.items()})
    models = {
        prefix: one.model({cell: found[f"{name}{prefix}{cell}"] for cell in one.cells}) for prefix, one in every.items()
    }
    own = {group: x[: len(actions)] for group, x in features.items()}
    folds = [split.fold(models[prefix], own, known, actions) for prefix, split in splits.items()]
    return LearntBehaviours(
        models[""],
        lengths,
        whole,
        {cell: found[f"{name}{cell}"] for cell in whole.cells},
        FoldModels.of_folds(folds, decision),
    )


@dataclass(frozen=True, eq=False)
class ValidationSplit:
    """A training set from a part of the people; the others tell how unlike what was learnt an action may look."""

    is_learnt: np.ndarray  # (c,) bool, the clips that are learnt from
    training: TrainingSet

    def fold(self, model: Model, features: Mapping[str, np.ndarray], known: Motions, actions: np.ndarray) -> Fold:
        """What the model says of the labelled frames of the other clips, by the features (n, D) of each group and the
        actions (n,) of all frames; one of several actions counts as a clip for each.
        """
        rows, count = np.flatnonzero(~self.is_learnt[known.clip] & (actions >= 0)), len(model.actions)
        density = recognition.log_densities(model, {group: x[rows] for group, x in features.items()})
        keys, query = np.unique(known.clip[rows] * count + actions[rows], return_inverse=True)
        return Fold(model, density, query, keys % count)


def validation_splits(
    known: Motions, features: Mapping[str, np.ndarray], learning: Learning, seed: int, name: str = ""
) -> dict[str, ValidationSplit]:
    """Learn lightly from all but a part of the people each, or of the clips of a single one, to validate on that part.

    `features` (n, D) of each group are those of the clips, and of their mirror images after them if those are learnt.
    Only the common skeleton is that of all. A split that would not know every action is left out: one that nobody else
    shows cannot be validated. By the prefix that the names of the cells get.
    """
    names, actions = number_actions(known.labels)
    light = replace(learning, frames=min(learning.fold_frames, learning.frames))
    found = {}
    for number, kept in enumerate(_kept(known, learning.folds), 1):
        own = np.where(kept[known.clip], actions, -1)
        if (np.bincount(own[own >= 0], minlength=len(names)) >= behaviours.LEAST_FRAMES).all():
            own = np.resize(own, len(next(iter(features.values()))))
            rng = stream(seed, STAGE, f"frames{name}fold {number}")
            found[f"fold {number}: "] = ValidationSplit(kept, TrainingSet.draw(features, own, names, light, rng))
    return found


def _kept(known: Motions, folds: int) -> list[np.ndarray]:
    """The clips (c,) bool that are not held out, of each fold: every so many-th person, or clip of a single one, is."""
    people, person = np.unique(known.actors, return_inverse=True)
    part = person if len(people) > 1 else np.arange(len(known.clips))
    folds = min(folds, len(people) if len(people) > 1 else 2, int(part.max()) + 1)
    return [part % folds != (number + 1) % folds for number in range(folds)] if folds > 1 else []


def _counts(known: Motions, actions: np.ndarray, names: tuple[str, ...]) -> dict[str, np.ndarray]:
    clips = [len(np.unique(known.clip[actions == action])) for action in range(len(names))]
    return {
        "frames": np.bincount(actions[actions >= 0], minlength=len(names)),
        "clips": np.array(clips, np.int64),
        "actors": np.unique(known.actors),
    }


def chain_diagnostics(training: TrainingSet, fitted: Mapping[str, Fitted]) -> dict[str, np.ndarray]:
    """Numbers of clusters with their posterior, traces, and how far the chains can be trusted; one entry a cell."""
    shape, burn_in = (len(training.names), len(training.projections)), training.settings.mixture.burn_in
    cells = [fitted[name] for name in training.cells]
    trace = np.stack([one.trace[:, :, TRACE.index("clusters")] for one in cells], axis=-1)
    settled = np.moveaxis(trace[:, burn_in:], -1, 0)
    return {
        "components": np.array([component_counts(one) for one in cells]).reshape(*shape, 3),
        "trace_clusters": np.ascontiguousarray(trace).reshape(*trace.shape[:2], *shape).astype(np.int32),
        "r_hat": np.array([diagnostics.split_r_hat(one) for one in settled]).reshape(shape),
        "ess": np.array([diagnostics.effective_draws(one) for one in settled]).reshape(shape),
    }


def component_counts(fitted: Fitted) -> tuple[float, int, int]:
    """Posterior mean of the number of clusters, and its 5 % and 95 % quantiles."""
    share = fitted.cluster_counts()
    low, high = (int(np.searchsorted(np.cumsum(share), level)) for level in (0.05, 0.95))
    return float(share @ np.arange(len(share))), low, high


def typical_poses(training: TrainingSet, fitted: Mapping[str, Fitted], poses: np.ndarray) -> dict[str, np.ndarray]:
    """Show each behaviour of the point partitions by poses (thesis figure 5.6), the most typical frame first.

    `poses` (n, j, 3) are those of all frames that the training set was drawn from.
    """
    groups = list(training.projections)
    actions, parts, shares, shown = [], [], [], []
    for name, (action, group) in training.cells.items():
        points, rows, labels = training.points[name], training.members(name), fitted[name].labels()
        points = points[np.isfinite(points).all(axis=1)]
        density = fitted[name].behaviours().students.log_density(points)
        for label in range(int(labels.max()) + 1):
            mine = np.flatnonzero(labels == label)
            order = rows[mine[np.argsort(-density[mine, label], kind="stable")]]
            actions.append(action)
            parts.append(groups.index(group))
            shares.append(len(mine) / len(labels))
            shown.append(poses[order[np.linspace(0, len(order) - 1, SHOWN).round().astype(int)]])
    return {
        "behaviour_action": np.array(actions, np.int64),
        "behaviour_group": np.array(parts, np.int64),
        "behaviour_share": np.array(shares),
        "behaviour_poses": np.array(shown, np.float32),
    }
