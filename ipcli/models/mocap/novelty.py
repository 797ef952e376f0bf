"""How unlike the action it is named a query is: six scores, by what a model of other people says of it and of others.

    each = scores(groups, held_out, action, measure(model, density, query, queries, decision))   # (q, SCORES)

The posterior tells only which action is the likeliest *if it is one of them*, and a density only how usual a pose is.
What tells best is the whole row of answers: a clip of an action that was learnt is unsure between the same others as
other clips of that action, by the same groups, and at its beginning between others than at its end. So a query is
compared with held-out clips of the action that it is named in what all actions and groups say of it. `calibration`
makes one novelty of the scores, and says above which the answer is none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ipcli.models.mocap import recognition
from ipcli.models.mocap.behaviours import Model
from ipcli.models.mocap.parameters import BODY, MOTION, Decision

MEASURED = ("log_posterior", "density", "evidence", "course")  # the fields of `Measured`
SCORES = ("density", "groups", "actions", "motion", "course of motion", "course of the body")  # as `scores` gives them
THIRDS = 3  # parts of a clip whose answers make its course
LEAST_LOG = -30.0  # log posterior by a group below which it is as good as excluded
SHRINKAGE = 0.2  # share of independence in the covariance of a profile within an action
NEIGHBOURS = 2  # held-out clips of the action that a query is compared with
LEAST = 1e-9  # spread below which a profile does not vary


@dataclass(frozen=True, eq=False)
class Measured:
    """What a model says about q queries, each value the mean over the frames that tell it; NaN where none does."""

    log_posterior: np.ndarray  # (q, a)
    density: np.ndarray  # (q, a, g), log density a dimension
    evidence: np.ndarray  # (q, a, g), log posterior by each group alone
    course: np.ndarray  # (q, THIRDS, a, g), the same of each third of a recording in order

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
    """What frames say about queries, from their log densities (f, a, g); query (f,) int, the query of each frame, whose
    frames follow one another.

    Not `ordered`: by the poses alone, in any order.
    """
    if not ordered:
        log_density = recognition.poses_alone(model, log_density)
    posterior = np.maximum(recognition.frame_posteriors(model, log_density, decision), np.log(np.finfo(float).tiny))
    sizes = np.array([project.matrix.shape[1] for project in model.projections])
    evidence = np.maximum(recognition.group_posteriors(log_density), LEAST_LOG)
    values = (_means(one, query, queries) for one in (posterior, log_density / sizes, evidence))
    course = np.full((queries * THIRDS, *evidence.shape[1:]), np.nan)
    if ordered:
        course = _means(evidence, query * THIRDS + _third(query, queries), queries * THIRDS)
    return Measured(**dict(zip(MEASURED, (*values, course.reshape(queries, THIRDS, *course.shape[1:])), strict=True)))


def _third(query: np.ndarray, queries: int) -> np.ndarray:
    """Number (f,) of the third of its query that each frame is in."""
    order, count = np.argsort(query, kind="stable"), np.bincount(query, minlength=queries)
    place = np.empty(len(query), np.int64)
    place[order] = np.arange(len(query)) - (np.cumsum(count) - count)[query[order]]
    return place * THIRDS // count[query]


def _means(values: np.ndarray, query: np.ndarray, queries: int) -> np.ndarray:
    """Mean (q, ...) over the frames (f, ...) of each query that have a finite value; NaN without any."""
    flat = values.reshape(len(values), -1)
    found = np.full((queries, flat.shape[1]), np.nan)
    for total, column in zip(found.T, flat.T, strict=True):
        seen = np.isfinite(column)
        count = np.bincount(query[seen], minlength=queries)
        np.divide(np.bincount(query[seen], weights=column[seen], minlength=queries), count, out=total, where=count > 0)
    return found.reshape(queries, *values.shape[1:])


@dataclass(frozen=True, eq=False)
class Profiles:
    """Points (v, d) of held-out clips and their actions: how a query differs from those of the action it is named."""

    points: np.ndarray
    action: np.ndarray

    @classmethod
    def known(cls, points: np.ndarray, action: np.ndarray) -> Profiles:
        """Those of the points that are finite."""
        told = np.isfinite(points).all(axis=1)
        return cls(points[told], action[told])

    def distance(self, points: np.ndarray, best: np.ndarray) -> np.ndarray:
        """Mahalanobis distance (q,) a dimension of points (q, d) from the mean of their action (q,), by the covariance
        within the actions, shrunk towards independence; NaN for an action of which no clip was held out.
        """
        found = np.full(len(points), np.nan)
        if not len(self.action):
            return found
        centre = np.full((max(self.action.max(), best.max(initial=0)) + 1, self.points.shape[1]), np.nan)
        for action in np.unique(self.action):
            centre[action] = self.points[self.action == action].mean(axis=0)
        within = self.points - centre[self.action]
        spread = within.std(axis=0) + LEAST
        correlation = (within / spread).T @ (within / spread) / len(within)
        shrunk = (1 - SHRINKAGE) * correlation + SHRINKAGE * np.eye(len(spread))
        offset = (points - centre[best]) / spread
        known = np.isfinite(offset).all(axis=1)
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
    shown = [g for g in range(len(groups)) if np.isfinite(held_out.density[:, :, g]).any()]
    names, best = [groups[g] for g in shown], asked.best
    evidence = _filled(held_out.evidence[:, :, shown]), asked.evidence[:, :, shown]
    by_part, own_part = (_by_part(names, one) for one in evidence)
    motion, own_motion = (gaps(one[:, :, -1]) for one in evidence)
    both, own_both = (
        np.concatenate([gaps(one.log_posterior), other], axis=1)
        for one, other in ((held_out, motion), (asked, own_motion))
    )
    return np.stack(
        [
            -asked.density[np.arange(len(best)), best, shown[-1]],
            Profiles(by_part, action).distance(own_part, best),
            Profiles(both, action).distance(own_both, best),
            Profiles(motion, action).nearest(own_motion, best),
            *(_course(groups, group, held_out, action, asked) for group in (MOTION, BODY)),
        ],
        axis=1,
    )


def _course(groups: Sequence[str], group: str, held_out: Measured, action: np.ndarray, asked: Measured) -> np.ndarray:
    """Mahalanobis distance (q,) of how far every action is behind the likeliest in each third of a clip, by one group;
    NaN where the model has no such group, or a third does not show it.
    """
    best = asked.best
    if group not in groups:
        return np.full(len(best), np.nan)
    points, own = (
        gaps(one.course[..., groups.index(group)].reshape(-1, one.course.shape[2])).reshape(len(one.course), -1)
        for one in (held_out, asked)
    )
    return Profiles.known(points, action).distance(own, best)


def gaps(log_posterior: np.ndarray) -> np.ndarray:
    """How far each action (q, a) is behind the likeliest, on a scale where twice as far behind says little more."""
    return np.log1p(log_posterior.max(axis=1, keepdims=True) - log_posterior)


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
