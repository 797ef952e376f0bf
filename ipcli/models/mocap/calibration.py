"""When a query is none of the actions: its novelty as the p-value of a cross-conformal test on people held out.

    reference = Reference.of_folds(folds, decision, ordered=True)
    novelty = reference.novelty([fold.measured(decision, ordered=True) for ...])   # (q,), -log10 of the p-value
    is_none = novelty > threshold(decision)

A model knows the people that it learnt from, and one of fewer people finds everybody stranger: neither clips that were
learnt nor clips held out of a smaller model tell how new people look to the final one. So a query is judged as the
held-out clips were, by the model of every fold against held-out clips of the other folds. Its p-value by one fold is
the share of the clips held out of it that are at least as novel: CV+ of Barber, Candes, Ramdas and Tibshirani 2021
("Predictive inference with the jackknife+"), cross-conformal prediction of Vovk 2015. Both take the mean of the folds'
p-values, which is seldom small where the folds do not quite agree: far less would be lost than may be. Of the means of
powers of p-values (Vovk and Wang 2020, "Combining p-values via averaging") that of their roots loses about what it may
(`experiments/mocap/refusals.py`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ipcli.models.mocap.behaviours import Model
from ipcli.models.mocap.novelty import LEAST, MEASURED, SCORES, Measured, measure, scores
from ipcli.models.mocap.parameters import Decision

PREFIXES = {True: "held_out_", False: "held_out_pose_"}  # of a calibration's arrays: of recordings in order, of poses
PRIOR_CLIPS = 5  # clips that the mean and spread over all actions count as, beside the clips of one
POWER = 0.5  # of the p-values that are averaged; 1: CV+, towards 0: their geometric mean
TAIL = 1.0  # how far, in spreads of the clips held out of a fold, beyond all of them a p-value falls to 1/e


@dataclass(frozen=True, eq=False)
class Fold:
    """Clips of people that a model did not learn from, and what it says about their frames."""

    model: Model
    log_density: np.ndarray  # (f, a, g)
    query: np.ndarray  # (f,), the clip of each frame
    action: np.ndarray  # (q,), of each clip, index of the model's

    def measured(self, decision: Decision, *, ordered: bool) -> Measured:
        """What the model says about each clip."""
        return measure(self.model, self.log_density, self.query, len(self.action), decision, ordered=ordered)


@dataclass(frozen=True, eq=False)
class Standard:
    """Mean and spread (a, SCORES) of the scores of clips that are most like each action, drawn towards those of all."""

    mean: np.ndarray
    spread: np.ndarray

    @classmethod
    def of(cls, each: np.ndarray, best: np.ndarray, actions: int) -> Standard:
        """That of clips with scores (v, SCORES), NaN left out, most like an action (v,)."""
        known = np.isfinite(each)
        told = np.maximum(known.sum(axis=0), 1)
        centre = np.where(known, each, 0.0).sum(axis=0) / told
        scale = np.sqrt(np.where(known, (each - centre) ** 2, 0.0).sum(axis=0) / told) + LEAST
        units = np.nan_to_num((each - centre) / scale)
        count = np.bincount(best, minlength=actions)[:, None] + PRIOR_CLIPS
        mean = _sums(units, best, actions) / count
        spread = np.sqrt((_sums((units - mean[best]) ** 2, best, actions) + PRIOR_CLIPS) / count)
        return cls(centre + scale * mean, scale * spread)

    def combined(self, each: np.ndarray, best: np.ndarray) -> np.ndarray:
        """One novelty (q,) of all scores (q, SCORES) there are, the mean in these units; NaN without any."""
        units = (each - self.mean[best]) / self.spread[best]
        known = np.isfinite(units)
        total = np.where(known, units, 0.0).sum(axis=1)
        return np.divide(total, known.sum(axis=1), out=np.full(len(each), np.nan), where=known.any(axis=1))


def _sums(values: np.ndarray, index: np.ndarray, count: int) -> np.ndarray:
    """Sums (count, d) of the rows of values (n, d) that have the same index."""
    found = np.zeros((count, values.shape[1]))
    np.add.at(found, index, values)
    return found


@dataclass(frozen=True, eq=False)
class Reference:
    """Held-out clips of known actions: what a query is compared with, and how novel they are themselves."""

    groups: tuple[str, ...]
    held_out: Measured  # v clips, by the model of their fold
    action: np.ndarray  # (v,)
    fold: np.ndarray  # (v,), the fold that each was held out of
    scores: np.ndarray  # (v, SCORES), of each against the clips of the other folds

    @classmethod
    def of_folds(cls, folds: Sequence[Fold], decision: Decision, *, ordered: bool) -> Reference | None:
        """Compare the clips of each fold with those of the others; None if there is nothing to compare.

        Not `ordered`: by poses alone.
        """
        if len(folds) < 2 or len(folds[0].model.actions) < 2:
            return None
        groups, measured = folds[0].model.groups, [fold.measured(decision, ordered=ordered) for fold in folds]
        told = [one.is_told for one in measured]
        held_out = Measured.joined([one.of(mine) for one, mine in zip(measured, told, strict=True)])
        action = np.concatenate([fold.action[mine] for fold, mine in zip(folds, told, strict=True)])
        number = np.repeat(np.arange(len(folds)), [mine.sum() for mine in told])
        each = np.full((len(action), len(SCORES)), np.nan)
        for fold in range(len(folds)):
            mine, others = number == fold, number != fold
            if mine.any() and others.any():
                each[mine] = scores(groups, held_out.of(others), action[others], held_out.of(mine))
        known = np.isfinite(each).any(axis=1)
        return cls(groups, held_out.of(known), action[known], number[known], each[known]) if known.any() else None

    def arrays(self, prefix: str) -> dict[str, np.ndarray]:
        """The calibration as flat arrays, whose names start with the prefix; `of_arrays` is the inverse."""
        own = {name: getattr(self.held_out, name) for name in MEASURED}
        own |= {name: getattr(self, name) for name in ("action", "fold", "scores")}
        return {f"{prefix}{name}": values for name, values in own.items()}

    @classmethod
    def of_arrays(cls, groups: Sequence[str], arrays: Mapping[str, np.ndarray], prefix: str) -> Reference | None:
        """The calibration that `arrays` wrote; None where there is none."""
        if f"{prefix}action" not in arrays:
            return None
        held_out = Measured(*(arrays[f"{prefix}{name}"] for name in MEASURED))
        return cls(tuple(groups), held_out, *(arrays[f"{prefix}{n}"] for n in ("action", "fold", "scores")))

    def novelty(self, asked: Sequence[Measured]) -> np.ndarray:
        """-log10 of the p-value (q,) of queries, by what the model of each fold says of them; NaN without frames."""
        return cross_conformal(*self.compared(asked))

    def compared(
        self, asked: Sequence[Measured], chosen: Sequence[str] = SCORES
    ) -> tuple[list[np.ndarray], list[np.ndarray]]:
        """One number of the chosen scores, by each fold: of the clips held out of it, and of queries (q,)."""
        is_chosen = np.isin(SCORES, chosen)
        held_out, best = np.where(is_chosen, self.scores, np.nan), self.held_out.best
        known, found = [], []
        for fold, one in enumerate(asked):
            mine = self.fold == fold
            standard = Standard.of(held_out[~mine], best[~mine], len(self.held_out.log_posterior[0]))
            each = scores(self.groups, self.held_out.of(~mine), self.action[~mine], one)
            known.append(standard.combined(held_out[mine], best[mine]))
            found.append(standard.combined(np.where(is_chosen, each, np.nan), one.best))
        return known, found

    def is_comparable(self, asked: Measured) -> np.ndarray:
        """Whether each query (q,) shows all groups that the held-out clips do."""
        shown = np.isfinite(self.held_out.density).any(axis=(0, 1))
        return np.isfinite(asked.density[:, :, shown]).all(axis=(1, 2))


def cross_conformal(known: Sequence[np.ndarray], asked: Sequence[np.ndarray], power: float = POWER) -> np.ndarray:
    """-log10 of the p-value (q,) of queries, the mean of a power of those by each fold.

    `known`: of each fold the novelty (v,) of the clips held out of it; `asked`: that of the queries (q,) under the same
    model, NaN where it does not tell. A fold counts by its clips. Between two clips the share of those at least as
    novel is interpolated, and beyond the last it falls exponentially, so that what is more novel than all of them has
    an order too.
    """
    total, count = np.full(len(asked[0]), -np.inf), np.zeros(len(asked[0]))
    for held_out, one in zip(known, asked, strict=True):
        order, told = np.sort(held_out[np.isfinite(held_out)]), np.isfinite(one)
        if len(order):
            rank = np.log((len(order) - np.arange(len(order)) - 0.5) / len(order))
            beyond = np.maximum(one[told] - order[-1], 0.0) / (TAIL * (order.std() + LEAST))
            p_value = np.interp(one[told], order, rank) - beyond  # log
            total[told] = np.logaddexp(total[told], power * p_value + np.log(len(order)))
            count[told] += len(order)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(count > 0, (np.log(count) - total) / (power * np.log(10)), np.nan)


def threshold(decision: Decision) -> float:
    """The novelty above which a query is none of the actions: as novel are 1 - `decision.reject` of new people's
    clips.
    """
    return float(-np.log10(1 - decision.reject)) if decision.reject < 1 else np.inf
