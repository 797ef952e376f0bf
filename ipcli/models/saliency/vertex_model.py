"""The saliency of surfaces: untrained, or by a predictor that was learnt from how long vertices were looked at."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ipcli.models.saliency import metrics
from ipcli.models.saliency.image_model import relative
from ipcli.models.saliency.learning import Predictor, learn
from ipcli.models.saliency.parameters import FixationLearning, Validation
from ipcli.models.saliency.validation import Row, over_folds
from ipcli.models.saliency.vertex_features import SPACING, features, ranks
from ipcli.progress import Progress, silent

SQUARED = ", far from its median"
UNTRAINED = "convexity of 16"
MEASURES = ("AUC", "AUC by area", "NSS", "CC")
FORMS = ("logistic + boosting", "logistic", "logistic + boosting, bending alone")
PLACE = ("height", "nearness", "faces", "slenderness", "overhang")  # how names of features of place begin
DRAWN = 1500  # most vertices of a surface that are learnt from, of those looked at and of the others


@dataclass(frozen=True, eq=False)
class SurfaceCase:
    """A surface as it is judged: features (n,) by name, which vertices (n,) were looked at, and how long (n,)."""

    name: str
    features: Mapping[str, np.ndarray]
    looked_at: np.ndarray
    attention: np.ndarray

    @property
    def area(self) -> np.ndarray:
        """Share (n,) of the surface that each vertex stands for, from the distance of its neighbours."""
        area = self.features[SPACING] ** 2
        return area / area.sum()


def columns(names: Sequence[str], place: bool = True) -> tuple[str, ...]:
    """What is learnt from: each feature's rank and its square, but for the spacing; without `place`, bending alone."""
    kept = [name for name in names if name != SPACING and (place or not name.startswith(PLACE))]
    return (*kept, *(name + SQUARED for name in kept))


def rows(found: Mapping[str, np.ndarray], names: Sequence[str]) -> np.ndarray:
    """Rows (n, k) float32 of the named columns: ranks within the surface about 0, and their squares."""
    plain = {name.removesuffix(SQUARED) for name in names}
    ranked = {name: ranks(found[name]) - 0.5 for name in plain}
    return np.stack(
        [ranked[name] if name in ranked else ranked[name.removesuffix(SQUARED)] ** 2 for name in names], axis=1
    ).astype(np.float32)


def predicted(predictor: Predictor, found: Mapping[str, np.ndarray]) -> np.ndarray:
    """Density (n,) over chance of the vertices of a surface with these features: the odds that the predictor gives."""
    scores = predictor.scores(rows(found, predictor.features))
    return relative(np.exp(scores - scores.max()))


def untrained(found: Mapping[str, np.ndarray]) -> np.ndarray:
    """Density (n,) over chance without any learning: the rank of the convexity, the best of all single features."""
    return relative(ranks(found[UNTRAINED]))


def saliency(vertices: np.ndarray, normals: np.ndarray, predictor: Predictor | None = None) -> np.ndarray:
    """Density (n,) float32 over chance of vertices (n, 3) with unit normals (n, 3)."""
    found = features(vertices, normals)
    return untrained(found) if predictor is None else predicted(predictor, found)


def learnt(cases: Sequence[SurfaceCase], params: FixationLearning, seed: int, place: bool = True) -> Predictor:
    """The predictor of surfaces: vertices of each that were looked at, and others, drawn at random."""
    names = columns(tuple(cases[0].features), place)
    rng = np.random.default_rng(seed)
    parts, labels = [], []
    for one in cases:
        drawn = [rng.permutation(np.flatnonzero(one.looked_at == hit))[:DRAWN] for hit in (True, False)]
        parts.append(rows(one.features, names)[np.concatenate(drawn)])
        labels.append(np.repeat([1, 0], [len(part) for part in drawn]))
    return learn(np.concatenate(parts), np.concatenate(labels), names, params, seed)


def cross_validated(
    cases: Sequence[SurfaceCase], learning: FixationLearning, params: Validation, seed: int, tell: Progress = silent
) -> dict[str, list[np.ndarray]]:
    """Maps of every surface by predictors learnt from the other folds of surfaces alone; as many folds as surfaces
    leave one out.
    """

    def forms(ours: Sequence[SurfaceCase]) -> dict[str, Predictor]:
        whole = learnt(ours, learning, seed)
        bending = learnt(ours, learning, seed, place=False)
        return dict(zip(FORMS, (whole, replace(whole, boosting=None), bending), strict=True))

    return over_folds(cases, params.folds, seed, forms, lambda one, case: predicted(one, case.features), tell)


def judged(name: str, role: str, maps: Sequence[np.ndarray], cases: Sequence[SurfaceCase]) -> Row:
    """The measures of a predictor's maps of all surfaces."""
    return Row(name, role, tuple(maps), np.array([_measures(m, c) for m, c in zip(maps, cases, strict=True)]))


def _measures(saliency: np.ndarray, one: SurfaceCase) -> list[float]:
    hit, values = one.looked_at, np.asarray(saliency, np.float64)
    if not hit.any() or hit.all():
        return [float("nan")] * len(MEASURES)
    spread = values.std()
    return [
        float(metrics.auc_each(values[hit], values[~hit]).mean()),
        weighted_auc(values, hit, one.area),
        float((values[hit].mean() - values.mean()) / (spread if spread > 0 else 1)),
        metrics.correlation(values, one.attention),
    ]


def weighted_auc(values: np.ndarray, hit: np.ndarray, weight: np.ndarray) -> float:
    """AUC of values (n,) with a weight (n,) for each: the chance that one that was hit ranks above one that was not,
    both drawn by weight; equal ones count by half.
    """
    order = np.argsort(values, kind="stable")
    _, group = np.unique(values[order], return_inverse=True)
    misses = np.bincount(group, np.where(hit[order], 0, weight[order]))
    hits = np.bincount(group, np.where(hit[order], weight[order], 0))
    below = np.cumsum(misses) - misses / 2
    return float((hits * below).sum() / (hits.sum() * misses.sum()))


def worth(cases: Sequence[SurfaceCase], maps: Mapping[str, Sequence[np.ndarray]], tell: Progress = silent) -> list[Row]:
    """Everything there is to compare: learnt models by name, the untrained one, the spacing, each feature."""
    found = [judged(name, "model", made, cases) for name, made in maps.items()]
    found.append(judged(UNTRAINED + ", untrained", "model", [untrained(c.features) for c in cases], cases))
    found.append(judged(SPACING, "baseline", [c.features[SPACING] for c in cases], cases))
    names = [name for name in cases[0].features if name != SPACING]
    for k, name in enumerate(names):
        found.append(judged(name, "feature", [c.features[name] for c in cases], cases))
        tell((k + 1) / len(names), name)
    return found
