"""Whether what was seen is one of the actions at all: several scores, calibrated on people and actions held out.

    reference = Reference.of_folds(folds, decision, ordered=True)   # clips of people that a model had not learnt
    strange = reference.novelty(measured, best)                     # (q,), above reference.threshold: none of them

The posterior tells only which action is the likeliest *if it is one of them*, and a density only how usual a pose is.
What tells best is the whole row of answers: a clip of an action that was learnt is unsure between the same others as
other clips of that action, by the same groups. So a query is compared with held-out clips of the action that it is
named in what all actions and groups say of it. The scores count alike, each in units of its spread over held-out clips.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ipcli.models.mocap import recognition
from ipcli.models.mocap.behaviours import Model
from ipcli.models.mocap.parameters import BODY, MOTION, Decision

MEASURED = ("log_posterior", "share", "density", "evidence")  # the fields of `Measured`
PREFIXES = {True: "held_out_", False: "held_out_pose_"}  # of a calibration's arrays: of recordings in order, of poses
SCORES = ("share", "density", "groups", "actions", "densities")  # what `Reference.scores` gives, in its order
LEAST_LOG = -30.0  # log posterior by a group below which it is as good as excluded
SHRINKAGE = 0.2  # share of independence in the covariance of a profile within an action
PRIOR_CLIPS = 5  # clips of an action that its spread is worth before any is seen
NEIGHBOURS = 2  # held-out clips of the action that a query is compared with
PART = 5  # frames of the parts of clips that surprise is known of; fewer are not judged as whole clips are
LEAST = 1e-9  # spread below which a profile does not vary


@dataclass(frozen=True, eq=False)
class Measured:
    """What a model says about q queries, each value the mean over the frames that tell it; NaN where none does."""

    log_posterior: np.ndarray  # (q, a)
    share: np.ndarray  # (q, a), posterior
    density: np.ndarray  # (q, a, g), log density a dimension
    evidence: np.ndarray  # (q, a, g), log posterior by each group alone

    @classmethod
    def joined(cls, parts: Sequence[Measured]) -> Measured:
        """All queries of the parts, one part after the other."""
        return cls(*(np.concatenate([getattr(part, name) for part in parts]) for name in MEASURED))

    def of(self, chosen: np.ndarray) -> Measured:
        """The chosen queries, by index or as a mask."""
        return Measured(*(getattr(self, name)[chosen] for name in MEASURED))

    @property
    def is_told(self) -> np.ndarray:
        """Whether any frame of each query (q,) could be used."""
        return np.isfinite(self.log_posterior).all(axis=1)

    @property
    def best(self) -> np.ndarray:
        """The likeliest action (q,) of each query."""
        return np.where(np.isfinite(self.log_posterior), self.log_posterior, -np.inf).argmax(axis=1)


def measure(
    model: Model, log_density: np.ndarray, query: np.ndarray, queries: int, decision: Decision, *, ordered: bool = True
) -> Measured:
    """What frames say about queries, from their log densities (f, a, g); query (f,) int, the query of each frame.

    Not `ordered`: by the poses alone, in any order.
    """
    if not ordered:
        log_density = recognition.poses_alone(model, log_density)
    posterior = np.maximum(recognition.frame_posteriors(model, log_density, decision), np.log(np.finfo(float).tiny))
    sizes = np.array([project.matrix.shape[1] for project in model.projections])
    evidence = np.maximum(recognition.group_posteriors(log_density), LEAST_LOG)
    values = (posterior, np.exp(posterior), log_density / sizes, evidence)
    return Measured(*(_means(one, query, queries) for one in values))


def _means(values: np.ndarray, query: np.ndarray, queries: int) -> np.ndarray:
    """Mean (q, ...) over the frames (f, ...) of each query that have a finite value; NaN without any."""
    flat = values.reshape(len(values), -1)
    found = np.full((queries, flat.shape[1]), np.nan)
    for total, column in zip(found.T, flat.T, strict=True):
        seen = np.isfinite(column)
        count = np.bincount(query[seen], minlength=queries)
        np.divide(np.bincount(query[seen], weights=column[seen], minlength=queries), count, out=total, where=count > 0)
    return found.reshape(queries, *values.shape[1:])


def without_action(model: Model, action: int) -> Model:
    """The model as if one of its actions were not known; the coordinates stay as they are."""
    kept = [other for other in range(len(model.actions)) if other != action]
    return replace(
        model,
        actions=tuple(model.actions[other] for other in kept),
        predictives=tuple(model.predictives[other] for other in kept),
        alpha=model.alpha[kept],
    )


@dataclass(frozen=True, eq=False)
class Fold:
    """Clips of people that a model did not learn from, and what it says about their frames."""

    model: Model
    log_density: np.ndarray  # (f, a, g)
    query: np.ndarray  # (f,), the clip of each frame
    action: np.ndarray  # (q,), of each clip, index of the model's

    def measured(self, decision: Decision, *, ordered: bool, without: int | None = None) -> Measured:
        """What the model says about each clip, or would if it did not know an action."""
        if without is None:
            return measure(self.model, self.log_density, self.query, len(self.action), decision, ordered=ordered)
        model, density = without_action(self.model, without), np.delete(self.log_density, without, axis=1)
        return measure(model, density, self.query, len(self.action), decision, ordered=ordered)


@dataclass(frozen=True, eq=False)
class Profiles:
    """Points (v, d) of held-out clips and their actions: how a query differs from those of the action it is named."""

    points: np.ndarray
    action: np.ndarray

    def distance(self, points: np.ndarray, best: np.ndarray) -> np.ndarray:
        """Mahalanobis distance (q,) a dimension of points (q, d) from the mean of their action (q,), by the covariance
        within the actions, shrunk towards independence; NaN for an action of which no clip was held out.
        """
        centre = np.full((max(self.action.max(), best.max(), 0) + 1, self.points.shape[1]), np.nan)
        for action in np.unique(self.action):
            centre[action] = self.points[self.action == action].mean(axis=0)
        within = self.points - centre[self.action]
        spread = within.std(axis=0) + LEAST
        correlation = (within / spread).T @ (within / spread) / len(within)
        shrunk = (1 - SHRINKAGE) * correlation + SHRINKAGE * np.eye(len(spread))
        offset = (points - centre[best]) / spread
        known = np.isfinite(offset).all(axis=1)
        found = np.full(len(points), np.nan)
        solved = np.linalg.solve(shrunk, offset[known].T).T
        found[known] = np.sqrt((offset[known] * solved).sum(axis=1) / len(spread))
        return found

    def nearest(self, points: np.ndarray, best: np.ndarray) -> np.ndarray:
        """Mean distance (q,) a dimension of points (q, d) from the nearest clips of their action (q,); NaN if there are
        none.
        """
        scale, found = self.points.std(axis=0) + LEAST, np.full(len(points), np.nan)
        for action in np.unique(best):
            own, mine = self.points[self.action == action], np.flatnonzero(best == action)
            if len(own):
                gap = (points[mine, None] - own[None]) / scale
                apart = np.sort(np.sqrt((gap**2).mean(axis=2)), axis=1)
                found[mine] = apart[:, :NEIGHBOURS].mean(axis=1)
        return found


def scores(groups: Sequence[str], held_out: Measured, action: np.ndarray, asked: Measured) -> np.ndarray:
    """Novelty scores (q, SCORES) of queries against held-out clips of actions (v,); the higher, the less like the
    likeliest action. NaN where there is nothing to compare with, or a group was not seen that the score asks for.
    """
    best, rows = asked.best, np.arange(len(asked.best))
    shown = [g for g in range(len(groups)) if np.isfinite(held_out.density[:, :, g]).any()]
    names = [groups[g] for g in shown]
    own, density = _filled(held_out.density[:, :, shown]), asked.density[:, :, shown]
    told, evidence = (
        _by_part(names, one) for one in (_filled(held_out.evidence[:, :, shown]), asked.evidence[:, :, shown])
    )
    gaps = [np.log1p(one.log_posterior.max(axis=1, keepdims=True) - one.log_posterior) for one in (held_out, asked)]
    last = own[np.arange(len(action)), action, -1]
    centre, spread = _of_actions(last, action, held_out.log_posterior.shape[1])
    return np.stack(
        [
            -asked.share[rows, best],
            -np.maximum((density[rows, best, -1] - centre[best]) / spread[best], -6.0),
            Profiles(told, action).distance(evidence, best),
            Profiles(gaps[0], action).nearest(gaps[1], best),
            Profiles(_flat(own), action).distance(_flat(density), best),
        ],
        axis=1,
    )


def _filled(values: np.ndarray) -> np.ndarray:
    """Values (q, a, g) of groups that were never seen, by the mean of the others."""
    known = np.isfinite(values)
    total = np.where(known, values, 0.0).sum(axis=2, keepdims=True)
    with np.errstate(invalid="ignore"):
        return np.where(known, values, total / known.sum(axis=2, keepdims=True))


def _by_part(names: Sequence[str], evidence: np.ndarray) -> np.ndarray:
    """Evidence (q, a, g) as (q, d): of the parts of the body their mean, of the body and of motion each their own."""
    parts = [g for g, name in enumerate(names) if name not in (BODY, MOTION)]
    whole = [g for g, name in enumerate(names) if name in (BODY, MOTION)]
    return np.concatenate([evidence[:, :, parts].mean(axis=2), *(evidence[:, :, g] for g in whole)], axis=1)


def _flat(values: np.ndarray) -> np.ndarray:
    return values.reshape(len(values), -1)


def _of_actions(values: np.ndarray, action: np.ndarray, actions: int) -> tuple[np.ndarray, np.ndarray]:
    """Mean and spread (a,) of values (v,) of each action; the spread shrunk towards that within all actions."""
    count = np.bincount(action, minlength=actions)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.bincount(action, weights=values, minlength=actions) / count
    square = (values - mean[action]) ** 2
    own = np.bincount(action, weights=square, minlength=actions)
    return mean, np.sqrt((own + PRIOR_CLIPS * square.mean()) / (count + PRIOR_CLIPS)) + LEAST


@dataclass(frozen=True, eq=False)
class Reference:
    """Held-out clips of known actions: what a query is compared with, and how novel they are to each other."""

    groups: tuple[str, ...]
    held_out: Measured  # v clips
    action: np.ndarray  # (v,)
    scale: np.ndarray  # (SCORES, 2), mean and spread of each score over the held-out clips
    known: np.ndarray  # (v,), novelty of each held-out clip to the clips of other folds
    unknown: np.ndarray  # (v,), the same if its action were not known

    @classmethod
    def of_folds(cls, folds: Sequence[Fold], decision: Decision, *, ordered: bool) -> Reference | None:
        """Calibrate by comparing each fold with the others, whose people are not its own; None if there is nothing to
        compare. Not `ordered`: by poses alone.

        Each clip is held out with its action as well: as if no fold had a clip of it and no model knew it.
        """
        if len(folds) < 2 or len(folds[0].model.actions) < 2:
            return None
        groups, count = folds[0].model.groups, len(folds[0].model.actions)
        measured = [fold.measured(decision, ordered=ordered) for fold in folds]
        actions = [np.where(one.is_told, fold.action, -1) for fold, one in zip(folds, measured, strict=True)]
        known = _across(groups, measured, actions)
        unknown = np.full(known.shape, np.nan)
        every = np.concatenate(actions)
        for action in np.unique(every[every >= 0]) if count > 2 else ():
            less = [fold.measured(decision, ordered=ordered, without=action) for fold in folds]
            numbers = [np.where(one == action, -1, one - (one > action)) for one in actions]
            mine = every == action
            unknown[mine] = _across(groups, less, numbers)[mine]
        spread = np.stack([np.nanmean(known, axis=0), np.nanstd(known, axis=0) + LEAST], axis=1)
        told = every >= 0
        held_out = Measured.joined(measured).of(told)
        novelty = (combined(one[told], spread) for one in (known, unknown))
        return cls(groups, held_out, every[told], spread, *novelty) if told.any() else None

    def arrays(self, prefix: str) -> dict[str, np.ndarray]:
        """The calibration as flat arrays, whose names start with the prefix; `of_arrays` is the inverse."""
        own = {name: getattr(self.held_out, name) for name in MEASURED}
        own |= {name: getattr(self, name) for name in ("action", "scale", "known", "unknown")}
        return {f"{prefix}{name}": values for name, values in own.items()}

    @classmethod
    def of_arrays(cls, groups: Sequence[str], arrays: Mapping[str, np.ndarray], prefix: str) -> Reference | None:
        """The calibration that `arrays` wrote; None where there is none."""
        if f"{prefix}action" not in arrays:
            return None
        held_out = Measured(*(arrays[f"{prefix}{name}"] for name in MEASURED))
        return cls(tuple(groups), held_out, *(arrays[f"{prefix}{n}"] for n in ("action", "scale", "known", "unknown")))

    def novelty(self, asked: Measured) -> np.ndarray:
        """How unlike held-out clips of the action that is likeliest each query (q,) is; NaN without frames."""
        return combined(scores(self.groups, self.held_out, self.action, asked), self.scale)

    def is_comparable(self, asked: Measured) -> np.ndarray:
        """Whether each query (q,) shows all groups that the held-out clips do."""
        shown = np.isfinite(self.held_out.density).any(axis=(0, 1))
        return np.isfinite(asked.density[:, :, shown]).all(axis=(1, 2))

    def threshold(self, decision: Decision) -> float:
        """The novelty above which a query is none of the actions: `decision.reject` of the held-out clips are below."""
        return recognition.threshold(self.known, decision)


def _across(groups: Sequence[str], measured: Sequence[Measured], actions: Sequence[np.ndarray]) -> np.ndarray:
    """Scores (v, SCORES) of the clips of each fold against those of all others; clips of action -1 are compared with
    none and only asked about.
    """
    found = []
    for number, asked in enumerate(measured):
        others = [n for n in range(len(measured)) if n != number]
        kept = [actions[n] >= 0 for n in others]
        reference = Measured.joined([measured[n].of(keep) for n, keep in zip(others, kept, strict=True)])
        action = np.concatenate([actions[n][keep] for n, keep in zip(others, kept, strict=True)])
        found.append(
            scores(groups, reference, action, asked) if len(action) else np.full((len(asked.best), len(SCORES)), np.nan)
        )
    return np.concatenate(found)


def combined(each: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """One novelty (q,) of all scores (q, SCORES) there are, each in units of its spread over held-out clips."""
    units = (each - scale[:, 0]) / scale[:, 1]
    known = np.isfinite(units)
    total = np.where(known, units, 0.0).sum(axis=1)
    return np.divide(total, known.sum(axis=1), out=np.full(len(each), np.nan), where=known.any(axis=1))
