"""What tells the looked at from the rest: logistic regression and boosted trees, kept as plain arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ipcli.kernels import trees as kernels
from ipcli.models.saliency.parameters import FixationLearning

NODES = ("feature", "threshold", "left", "right", "value")


@dataclass(frozen=True, eq=False)
class Boosting:
    """Regression trees whose sum, with `start`, is the log odds. Nodes (t, m) as `kernels.trees` takes them."""

    feature: np.ndarray  # int64
    threshold: np.ndarray  # float64: rows up to it go left
    left: np.ndarray  # int64; -1: a leaf
    right: np.ndarray
    value: np.ndarray  # float64
    start: float

    def scores(self, rows: np.ndarray) -> np.ndarray:
        """Log odds (n,) of rows (n, k) float32."""
        nodes = (self.feature, self.threshold, self.left, self.right, self.value)
        return self.start + kernels.sum_trees(np.ascontiguousarray(rows, np.float32), *nodes)


@dataclass(frozen=True, eq=False)
class Predictor:
    """Log odds of being looked at, from named features: logistic regression, or its mean with boosted trees."""

    features: tuple[str, ...]
    mean: np.ndarray  # (k,)
    spread: np.ndarray  # (k,)
    weights: np.ndarray  # (k,) of the standardised features
    bias: float
    boosting: Boosting | None = None

    def scores(self, rows: np.ndarray) -> np.ndarray:
        """Log odds (n,) of rows (n, k)."""
        linear = ((rows - self.mean) / self.spread) @ self.weights + self.bias
        return linear if self.boosting is None else (linear + self.boosting.scores(rows)) / 2

    def arrays(self) -> dict[str, np.ndarray]:
        """All of it as arrays of a `saliency-model`."""
        own = {
            "features": np.array(self.features),
            "mean": self.mean,
            "spread": self.spread,
            "weights": self.weights,
            "bias": np.array(self.bias, np.float64),
        }
        if self.boosting is None:
            return own
        nodes = {f"trees/{name}": getattr(self.boosting, name) for name in NODES}
        return own | nodes | {"trees/start": np.array(self.boosting.start, np.float64)}

    @classmethod
    def of(cls, arrays: Mapping[str, np.ndarray]) -> Predictor:
        """What `arrays` gave."""
        boosting = None
        if "trees/start" in arrays:
            nodes = {name: arrays[f"trees/{name}"] for name in NODES}
            boosting = Boosting(**nodes, start=float(arrays["trees/start"]))
        names = tuple(arrays["features"].tolist())
        bias = float(arrays["bias"])
        return cls(names, arrays["mean"], arrays["spread"], arrays["weights"], bias, boosting)


def learn(
    rows: np.ndarray, looked_at: np.ndarray, features: Sequence[str], params: FixationLearning, seed: int = 0
) -> Predictor:
    """The predictor of rows (n, k) float32 and labels (n,) 0 or 1."""
    from sklearn.linear_model import LogisticRegression

    mean, spread = rows.mean(axis=0, dtype=np.float64), rows.std(axis=0, dtype=np.float64) + 1e-9
    linear = LogisticRegression(C=params.inverse_ridge, max_iter=200, tol=1e-3)
    linear.fit((rows - mean) / spread, looked_at)
    boosting = boost(rows, looked_at, params, seed) if params.trees else None
    return Predictor(tuple(features), mean, spread, linear.coef_[0], float(linear.intercept_[0]), boosting)


def boost(rows: np.ndarray, looked_at: np.ndarray, params: FixationLearning, seed: int) -> Boosting:
    """Trees that scikit-learn boosts on binned rows, their nodes taken out of it so that no pickle is needed."""
    from sklearn.ensemble import HistGradientBoostingClassifier

    model = HistGradientBoostingClassifier(
        max_iter=params.trees,
        max_depth=params.depth,
        learning_rate=params.rate,
        min_samples_leaf=params.leaf,
        l2_regularization=1.0,
        max_features=params.share,
        early_stopping=False,
        random_state=seed,
    )
    model.fit(np.ascontiguousarray(rows, np.float32), looked_at)
    grown = [stage[0].nodes for stage in model._predictors]
    shape = (len(grown), max(map(len, grown)))
    feature, left, right = (np.full(shape, fill, np.int64) for fill in (0, -1, -1))
    threshold, value = np.zeros(shape), np.zeros(shape)
    for t, nodes in enumerate(grown):
        inner = nodes["is_leaf"] == 0
        m = len(nodes)
        feature[t, :m] = np.where(inner, nodes["feature_idx"], 0)
        threshold[t, :m] = np.where(inner, nodes["num_threshold"], 0)
        left[t, :m], right[t, :m] = (np.where(inner, nodes[side].astype(np.int64), -1) for side in ("left", "right"))
        value[t, :m] = nodes["value"]
    return Boosting(feature, threshold, left, right, value, float(np.ravel(model._baseline_prediction)[0]))
