"""What each feature is worth: rankings of attended points, balanced error rates of groups, recursive elimination."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from ipcli import rng
from ipcli.models.saliency import classifier, features
from ipcli.models.saliency.scene_parameters import SceneSaliency

TASK = ("F1", "F3", "F4")  # groups that say nothing within one subsequence, or only once somebody looked
SCORED = tuple(k for k, column in enumerate(features.COLUMNS) if column.group not in TASK)
RANKED = ("learnt function", "membranes as used", *(features.COLUMNS[k].name for k in SCORED))
PAIRED = 2_000  # rows on which groups are compared


def of_subsequence(table: np.ndarray, labels: np.ndarray, learnt: np.ndarray, energy: np.ndarray) -> np.ndarray:
    """Areas under the curve (len(RANKED),) of attended points against those nobody looked at; NaN where unknown."""
    known = labels != 0
    scores = [learnt, energy, *(table[:, k] for k in SCORED)]
    return np.array([classifier.ranking(score[known], labels[known]) for score in scores])


def table(
    rows: np.ndarray,
    labels: np.ndarray,
    subsequence: np.ndarray,
    folds: np.ndarray,
    margins: np.ndarray,
    groups: Sequence[str],
    p: SceneSaliency,
    seed: int,
) -> dict[str, np.ndarray]:
    """Error rates of the function (table 3.1), of every few groups together, and of what elimination leaves."""
    by_fold = []
    for fold in np.unique(folds):
        mine = (folds == fold) & np.isfinite(margins)
        rates = classifier.error_rates(margins[mine], labels[mine])
        by_fold.append((int((labels[mine] > 0).sum()), rates.misses, rates.alarms, rates.accuracy, rates.balanced))
    few = rng.stream(seed, "saliency groups", "").permutation(len(rows))[:PAIRED]
    small = (rows[few], labels[few], folds[few])
    sets = [names for size in range(1, p.group_size + 1) for names in combinations(groups, size)]
    taken = [(" + ".join(names), _balanced(*small, names, p, seed)) for names in sets]
    for out in groups if p.group_size and len(groups) > 1 else ():
        rest = [group for group in groups if group != out]
        taken.append((f"all but {out}", _balanced(*small, rest, p, seed)))
    path = eliminated(*small, groups, p, seed) if p.group_size else []
    return {
        "folds/rates": np.array(by_fold, np.float64).reshape(-1, 5),
        "groups/names": _texts(names for names, _ in taken),
        "groups/balanced": np.array([value for _, value in taken], np.float64),
        "elimination/names": _texts(" + ".join(names) for names, _ in path),
        "elimination/balanced": np.array([value for _, value in path], np.float64),
    }


def _texts(values) -> np.ndarray:
    return np.array(list(values), dtype=np.str_).reshape(-1)


def _balanced(
    rows: np.ndarray, labels: np.ndarray, folds: np.ndarray, groups: Sequence[str], p: SceneSaliency, seed: int
) -> float:
    draw = rng.stream(seed, "saliency error rate", " ".join(groups))
    margins, _ = classifier.cross_validated(rows, labels, folds, groups, p.radius, p.classifying, draw)
    known = np.isfinite(margins)
    return classifier.error_rates(margins[known], labels[known]).balanced


def eliminated(
    rows: np.ndarray, labels: np.ndarray, folds: np.ndarray, groups: Sequence[str], p: SceneSaliency, seed: int
) -> list[tuple[tuple[str, ...], float]]:
    """Groups that are left and their error rate, from all to one: the group goes whose shuffling hurts least."""
    left, path = tuple(groups), []
    while left:
        draw = rng.stream(seed, "saliency elimination", " ".join(left))
        margins, found = classifier.cross_validated(rows, labels, folds, left, p.radius, p.classifying, draw)
        known = np.isfinite(margins)
        path.append((left, classifier.error_rates(margins[known], labels[known]).balanced))
        if len(left) == 1 or not found:
            break
        harm = [_without(rows, labels, folds, found, group, draw) for group in left]
        left = tuple(group for group in left if group != left[int(np.argmin(harm))])
    return path


def _without(rows, labels, folds, found, group: str, draw: np.random.Generator) -> float:
    """The error rate when a group's columns are shuffled among the rows of a fold."""
    columns = features.columns_of((group,))
    margins = np.full(len(rows), np.nan)
    for fold, function in found.items():
        mine = np.flatnonzero(folds == fold)
        shuffled = rows[mine].copy()
        sources = [0, 1, 2] if group == "F3" else columns  # the domain is known from the place
        shuffled[:, sources] = shuffled[draw.permutation(len(mine))][:, sources]
        margins[mine] = function.margin(shuffled)
    known = np.isfinite(margins)
    return classifier.error_rates(margins[known], labels[known]).balanced
