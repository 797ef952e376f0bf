"""The function that tells attended points from others: (3.17) to (3.19), its combination over tasks (3.20), its errors.

(3.17) is Schoelkopf's one-class machine; (3.35) counts errors of two classes, so the margin between labels is the
default. Whatever the form, what is learnt is a sum of kernels on some points, or of the features themselves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ipcli.models.saliency import features, metrics
from ipcli.models.saliency.scene_parameters import Classifying

LARGE = 200_000  # points from which on the margin is found by stochastic gradients
EXACT = 4_000  # points up to which one class is learnt exactly
FALSE_ALARMS = 0.05  # share of points nobody looked at above the threshold


@dataclass(frozen=True, eq=False)
class Learnt:
    """f(W) of (3.19) before its sign is taken, with what turns it into a probability."""

    columns: np.ndarray  # (d,) of the table
    centre: np.ndarray  # (d,)
    scale: np.ndarray  # (d,)
    supports: np.ndarray  # (s, d) scaled points that kernels sit on; one row and gamma 0: a linear function
    weights: np.ndarray  # (s,), or (d,) of a linear function
    gamma: float  # exp(-gamma |x - s|^2)
    offset: float
    slope: np.ndarray  # (2,): probability = 1 / (1 + exp(-(slope[0] f + slope[1])))
    threshold: float  # of f: FALSE_ALARMS of points nobody looked at lie above
    domain: np.ndarray  # (2, 3) task domain of (F3)

    def margin(self, table: np.ndarray) -> np.ndarray:
        """f (n,) of rows of a table."""
        chosen = features.with_domain(table, self.domain)[:, self.columns]
        scaled = (chosen - self.centre) / self.scale
        if self.gamma == 0:
            return scaled @ self.weights - self.offset
        return _kernel(scaled, self.supports, self.gamma) @ self.weights - self.offset

    def probability(self, table: np.ndarray) -> np.ndarray:
        """Saliency (n,) in [0, 1], for as many attended points as others."""
        return logistic(self.slope[0] * self.margin(table) + self.slope[1])


def logistic(values: np.ndarray) -> np.ndarray:
    """1 / (1 + exp(-x)) without overflow."""
    return 0.5 * (1 + np.tanh(0.5 * values))


def _kernel(a: np.ndarray, b: np.ndarray, gamma: float) -> np.ndarray:
    square = (a**2).sum(axis=1)[:, None] + (b**2).sum(axis=1) - 2 * a @ b.T
    return np.exp(-gamma * np.maximum(square, 0.0))


def groups_used(p: Classifying) -> tuple[str, ...]:
    """The groups of features that are learnt from."""
    out = {name.strip() for name in p.leave_out.split(",")}
    return tuple(group for group in features.GROUPS if group not in out)


def learn(
    table: np.ndarray,
    labels: np.ndarray,
    groups: Sequence[str],
    margin: float,
    p: Classifying,
    rng: np.random.Generator,
) -> Learnt:
    """Learn from rows (n, COUNT) with labels +1 and -1; `margin` (metres) widens the task domain.

    The probability is that of the training points until `calibrated` by others.
    """
    domain = features.task_domain(table[labels > 0][:, :3].astype(np.float64), margin)
    columns = features.columns_of(tuple(groups))
    chosen = features.with_domain(table, domain)[:, columns]
    centre, scale = chosen.mean(axis=0), chosen.std(axis=0)
    scale = np.where(scale > 1e-9 * np.maximum(np.abs(centre), 1e-9), scale, 1.0)
    scaled = (chosen - centre) / scale
    supports, weights, gamma, offset = _solved(scaled, labels, p, rng)
    found = Learnt(columns, centre, scale, supports, weights, gamma, offset, np.array([1.0, 0.0]), 0.0, domain)
    return calibrated(found, found.margin(table), labels)


def _solved(x: np.ndarray, labels: np.ndarray, p: Classifying, rng: np.random.Generator):
    """Supports, weights, gamma and offset of the form that is asked for."""
    gamma = 1 / (2 * p.width**2 * x.shape[1])
    if p.form == "l1":
        machine = _two_classes(p, len(x), "l1", rng)
        machine.fit(x, labels)
        return np.zeros((1, x.shape[1])), machine.coef_[0], 0.0, -float(machine.intercept_[0])
    if p.form == "one-class":
        return _one_class(x[labels > 0], gamma, p, rng)
    supports, root = _landmarks(x, gamma, p.landmarks, rng)
    machine = _two_classes(p, len(x), "l2", rng)
    machine.fit(_kernel(x, supports, gamma) @ root, labels)
    return supports, root @ machine.coef_[0], gamma, -float(machine.intercept_[0])


def _two_classes(p: Classifying, count: int, penalty: str, rng: np.random.Generator):
    from sklearn.linear_model import SGDClassifier
    from sklearn.svm import LinearSVC

    state = int(rng.integers(2**31))
    if count > LARGE:
        return SGDClassifier(
            loss="hinge", penalty=penalty, alpha=1 / (p.penalty * count), class_weight="balanced", random_state=state
        )
    return LinearSVC(penalty=penalty, C=p.penalty, dual=False, class_weight="balanced", random_state=state)


def _one_class(x: np.ndarray, gamma: float, p: Classifying, rng: np.random.Generator):
    """(3.17) and (3.18): exactly for few points, on landmarks by stochastic gradients for many."""
    from sklearn.linear_model import SGDOneClassSVM
    from sklearn.svm import OneClassSVM

    nu = float(np.clip(0.1 / p.penalty, 1e-3, 0.9))
    if len(x) <= EXACT:
        exact = OneClassSVM(kernel="rbf", gamma=gamma, nu=nu).fit(x)
        return exact.support_vectors_, exact.dual_coef_[0], gamma, -float(exact.intercept_[0])
    supports, root = _landmarks(x, gamma, p.landmarks, rng)
    large = SGDOneClassSVM(nu=nu, random_state=int(rng.integers(2**31))).fit(_kernel(x, supports, gamma) @ root)
    return supports, root @ large.coef_, gamma, float(large.offset_[0])


def _landmarks(x: np.ndarray, gamma: float, count: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Nystroem: some points, and the root of the inverse of their kernel."""
    supports = x[np.sort(rng.permutation(len(x))[:count])]
    values, vectors = np.linalg.eigh(_kernel(supports, supports, gamma))
    return supports, vectors / np.sqrt(np.maximum(values, 1e-6 * values[-1])) @ vectors.T


def calibrated(found: Learnt, margins: np.ndarray, labels: np.ndarray) -> Learnt:
    """The function with a probability and a threshold fitted to margins it has not been learnt from (Platt 1999).

    Both classes weigh the same.
    """
    weight = np.where(labels > 0, 0.5 / max((labels > 0).sum(), 1), 0.5 / max((labels < 0).sum(), 1))
    target, slope = (labels > 0).astype(float), np.array([1.0, 0.0])
    design = np.stack([margins, np.ones_like(margins)], axis=1)
    for _ in range(50):
        chance = logistic(design @ slope)
        gradient = design.T @ (weight * (chance - target)) + 1e-6 * slope
        hessian = (design * (weight * chance * (1 - chance))[:, None]).T @ design + 1e-6 * np.eye(2)
        step = np.linalg.solve(hessian, gradient)
        slope = slope - step * min(1.0, 2.0 / max(float(np.abs(step).max()), 1e-12))
        if np.abs(step).max() < 1e-9:
            break
    threshold = float(np.quantile(margins[labels < 0], 1 - FALSE_ALARMS)) if (labels < 0).any() else 0.0
    return replace(found, slope=slope, threshold=threshold)


def combined(functions: Sequence[Learnt], weights: Sequence[float], table: np.ndarray) -> np.ndarray:
    """The minimiser (n,) of (3.20): the weighted mean of what was learnt for each task."""
    total = np.sum([w * f.probability(table) for w, f in zip(weights, functions, strict=True)], axis=0)
    return total / np.sum(weights)


def folds_of(subsequences: np.ndarray, p: Classifying, rng: np.random.Generator) -> np.ndarray:
    """The fold of each row: whole subsequences, or rows at random as in table 3.1."""
    if p.split == "random":
        return rng.permutation(len(subsequences)) % p.folds
    names = np.unique(subsequences)
    return (rng.permutation(len(names)) % p.folds)[np.searchsorted(names, subsequences)]


@dataclass(frozen=True)
class ErrorRates:
    """Errors of two classes."""

    misses: float  # wp_+ / |D|_+, false negatives
    alarms: float  # wp_- / |D|_-, false positives
    accuracy: float

    @property
    def balanced(self) -> float:
        """(3.35)."""
        return (self.misses + self.alarms) / 2


def error_rates(margins: np.ndarray, labels: np.ndarray) -> ErrorRates:
    """Errors of the sign of f; NaN for a class that has no point."""
    right = np.sign(margins) == labels
    with np.errstate(invalid="ignore"):
        shares = [1 - right[labels == sign].mean() if (labels == sign).any() else np.nan for sign in (1, -1)]
    return ErrorRates(float(shares[0]), float(shares[1]), float(right.mean()))


def cross_validated(
    table: np.ndarray,
    labels: np.ndarray,
    folds: np.ndarray,
    groups: Sequence[str],
    margin: float,
    p: Classifying,
    rng: np.random.Generator,
) -> tuple[np.ndarray, dict[int, Learnt]]:
    """Margins (n,) of rows by functions that have not seen their fold, and those functions; NaN where none can be
    learnt since all attended points, or all others, are in that fold.
    """
    margins, found = np.full(len(table), np.nan), {}
    for fold in np.unique(folds):
        others = folds != fold
        if (labels[others] > 0).sum() < 2 or (labels[others] < 0).sum() < 2:
            continue
        found[int(fold)] = learn(table[others], labels[others], groups, margin, p, rng)
        margins[~others] = found[int(fold)].margin(table[~others])
    return margins, found


def ranking(scores: np.ndarray, labels: np.ndarray) -> float:
    """Area under the ROC curve: how often an attended point scores above another; ties count half."""
    known = np.isfinite(scores)
    positive, negative = (scores[known & (labels * sign > 0)] for sign in (1, -1))
    return float(metrics.auc_each(positive, negative).mean()) if len(positive) and len(negative) else float("nan")
