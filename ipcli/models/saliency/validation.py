"""What models, single channels and baselines are worth on pictures with recorded fixations."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeVar

import numpy as np

from ipcli.models.saliency import image_model, metrics
from ipcli.models.saliency.channels import centre_prior
from ipcli.models.saliency.learning import Predictor
from ipcli.models.saliency.parameters import FixationLearning, Validation
from ipcli.progress import Progress, silent

AnyCase = TypeVar("AnyCase")
MEASURES = ("AUC", "sAUC", "NSS", "information gain", "CC", "SIM", "KL")
DENSITIES = ("model", "baseline", "ceiling")  # roles whose maps are probabilities: the others gain no information
FORMS = ("logistic + boosting", "logistic", "logistic + boosting without place")
WIDE = 0.05  # spread of the density of other pictures' fixations, as a share of the width


@dataclass(frozen=True, eq=False)
class Case:
    """A picture as it is judged: its channels, and its fixations (n, 2) and their observers (n,) on their grid."""

    name: str
    channels: Mapping[str, np.ndarray]
    fixations: np.ndarray
    observers: np.ndarray

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the grid."""
        rows, columns = next(iter(self.channels.values())).shape
        return rows, columns


@dataclass(frozen=True, eq=False)
class Row:
    """One predictor: its role, its map of every case, and the measures of each case (i, c), AUC summed as means."""

    name: str
    role: str
    maps: tuple[np.ndarray, ...]
    each: np.ndarray


def case(
    name: str, channels: Mapping[str, np.ndarray], fixations: np.ndarray, observers: np.ndarray, size: tuple[int, int]
) -> Case:
    """A picture of `size` (h, w) whose fixations are in its own pixels; those outside count at its border."""
    shape = next(iter(channels.values())).shape
    return Case(name, channels, metrics.rescaled(fixations, size, (shape[0], shape[1])), observers)


def rescaled_to(points: np.ndarray, source: tuple[int, int], target: tuple[int, int]) -> np.ndarray:
    """Fixations (n, 2) on one grid as those of another of a picture of another shape."""
    return points if source == target else metrics.rescaled(points + 0.5, source, target)


def elsewhere(cases: Sequence[Case], index: int) -> np.ndarray:
    """Fixations (m, 2) on all other pictures, at the shape of this one."""
    return metrics.others([rescaled_to(c.fixations, c.shape, cases[index].shape) for c in cases], index)


@dataclass(frozen=True, eq=False)
class Yardstick:
    """What maps of one case are measured against."""

    points: np.ndarray  # (n, 2) its fixations
    elsewhere: np.ndarray  # (m, 2) those on all other pictures, at its shape
    truth: np.ndarray  # (a, b) its fixations blurred
    shape: tuple[int, int]

    @cached_property
    def prior(self) -> np.ndarray:
        """Density (a, b) of the fixations elsewhere, a hundredth of it uniform: the best centre prior."""
        density = metrics.fixation_map(self.elsewhere, self.shape, WIDE * self.shape[1])
        return 0.99 * density + 0.01 / density.size


def yardsticks(cases: Sequence[Case], params: Validation) -> list[Yardstick]:
    """That of each case."""
    return [
        Yardstick(
            one.fixations,
            elsewhere(cases, k),
            metrics.fixation_map(one.fixations, one.shape, params.blur * one.shape[1]),
            one.shape,
        )
        for k, one in enumerate(cases)
    ]


def judged(name: str, role: str, maps: Sequence[np.ndarray], against: Sequence[Yardstick]) -> Row:
    """The measures of a predictor's maps of all cases."""
    each = [_measures(role, saliency, stick) for saliency, stick in zip(maps, against, strict=True)]
    return Row(name, role, tuple(maps), np.array(each))


def _measures(role: str, saliency: np.ndarray, against: Yardstick) -> list[float]:
    points, others = against.points, against.elsewhere
    if not len(points):
        return [float("nan")] * len(MEASURES)
    gain = float("nan")
    if role in DENSITIES and len(others):
        gain = float(metrics.information_gain(saliency, points, against.prior).mean())
    shuffled = float(metrics.shuffled_auc(saliency, points, others).mean()) if len(others) else float("nan")
    return [
        float(metrics.auc(saliency, points).mean()),
        shuffled,
        float(metrics.nss(saliency, points).mean()),
        gain,
        metrics.correlation(saliency, against.truth),
        metrics.similarity(saliency, against.truth),
        metrics.divergence(saliency, against.truth),
    ]


def totals(each: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """Measures (r, c) of measures of cases (r, i, c): over fixations, of which each case has `counts` (i,), but CC,
    SIM and KL over pictures.
    """
    by_fixation = np.array([name not in ("CC", "SIM", "KL") for name in MEASURES])
    known = np.isfinite(each)
    weights = np.where(by_fixation, counts[:, None], 1.0) * known
    total = weights.sum(axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(total > 0, (np.where(known, each, 0) * weights).sum(axis=1) / total, np.nan)


def ceiling(one: Case, around: np.ndarray, params: Validation) -> tuple[Case, np.ndarray]:
    """The case with the fixations of every other observer alone, and the density of those of the rest, with a
    twentieth of the prior density (a, b) for where none of them looked.
    """
    ranks = np.unique(one.observers, return_inverse=True)[1]
    first = ranks % 2 == 0
    kept = Case(one.name, one.channels, one.fixations[~first], one.observers[~first])
    theirs = metrics.fixation_map(one.fixations[first], one.shape, params.blur * one.shape[1])
    return kept, 0.95 * theirs + 0.05 * around


def folds_of(count: int, folds: int, seed: int) -> np.ndarray:
    """The fold (count,) of each picture."""
    return np.random.default_rng(seed).permutation(count) % folds


def cross_validated(
    cases: Sequence[Case], learning: FixationLearning, params: Validation, seed: int, tell: Progress = silent
) -> dict[str, list[np.ndarray]]:
    """Maps of every case by predictors that were learnt from the other folds of pictures alone: that of all features,
    its linear half, and one without the channels of place.
    """

    def forms(ours: Sequence[Case]) -> dict[str, Predictor]:
        whole = learnt_from(ours, learning, seed)
        elsewhere = learnt_from(ours, learning, seed, without=image_model.PLACE)
        return dict(zip(FORMS, (whole, replace(whole, boosting=None), elsewhere), strict=True))

    return over_folds(
        cases, params.folds, seed, forms, lambda one, case: image_model.predicted(one, case.channels), tell
    )


def over_folds(
    cases: Sequence[AnyCase],
    folds: int,
    seed: int,
    forms: Callable[[Sequence[AnyCase]], Mapping[str, Predictor]],
    predict: Callable[[Predictor, AnyCase], np.ndarray],
    tell: Progress = silent,
) -> dict[str, list[np.ndarray]]:
    """Maps of every case, by name, of the predictors that `forms` learns from the other folds of cases alone."""
    fold = folds_of(len(cases), min(folds, len(cases)), seed)
    maps: dict[str, dict[int, np.ndarray]] = {}
    for k in range(int(fold.max()) + 1):
        learnt = forms([one for one, f in zip(cases, fold, strict=True) if f != k])
        for name, predictor in learnt.items():
            for index in map(int, np.flatnonzero(fold == k)):
                maps.setdefault(name, {})[index] = predict(predictor, cases[index])
        tell((k + 1) / (fold.max() + 1), "cross-validation")
    return {name: [found[index] for index in range(len(cases))] for name, found in maps.items()}


def learnt_from(cases: Sequence[Case], learning: FixationLearning, seed: int, without: Sequence[str] = ()) -> Predictor:
    """The predictor of all these cases on their channels."""
    names = tuple(name for name in cases[0].channels if name not in without)
    return image_model.learnt([(c.channels, c.fixations) for c in cases], names, learning, seed)


def rows(
    cases: Sequence[Case], learnt: Mapping[str, Sequence[np.ndarray]], params: Validation, tell: Progress = silent
) -> list[Row]:
    """Everything there is to compare: the maps of learnt models by name, the untrained model, baselines, the ceiling,
    and each single channel.
    """
    against = yardsticks(cases, params)
    made: dict[str, tuple[str, Sequence[np.ndarray]]] = {name: ("model", maps) for name, maps in learnt.items()}
    made[image_model.UNTRAINED] = ("model", [image_model.untrained(c.channels) for c in cases])
    made["centre prior"] = ("baseline", [centre_prior(c.shape) for c in cases])
    if len(cases) > 1:
        made["fixations on other pictures"] = ("baseline", [stick.prior for stick in against])
    found = [judged(name, role, maps, against) for name, (role, maps) in made.items()]
    if len(cases) > 1 and all(len(np.unique(c.observers)) > 1 for c in cases):
        halves = [ceiling(c, stick.prior, params) for c, stick in zip(cases, against, strict=True)]
        kept = yardsticks([one for one, _ in halves], params)
        found.append(judged("half of the observers", "ceiling", [density for _, density in halves], kept))
    names = tuple(cases[0].channels)
    for k, name in enumerate(names):
        found.append(judged(name, "feature", [c.channels[name] for c in cases], against))
        tell((k + 1) / len(names), name)
    return found
