"""Which material: a classifier on colour and statistics of the picture, learnt on generated scenes (linear
discriminants).

The features are chosen so that neither exposure nor the shape decides: chroma of the whole and of the highlights, and
the shape of the histogram. The posterior is that of Gaussians of one covariance, softened until held-out scenes are
told as often as it says.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipcli.models.brdf.solid import Pictured

STATISTICS = (
    "log R/G",
    "log B/G",
    "log R/G of highlights, less the whole",
    "log B/G of highlights, less the whole",
    "log R/G of shadows, less the whole",
    "log B/G of shadows, less the whole",
    "variation",
    "skewness",
    "kurtosis",
    "log of 10th over 50th percentile",
    "log of 90th over 50th percentile",
    "log of 99th over 50th percentile",
    "share of sharp changes",
    "variation of chroma",
)


@dataclass(frozen=True, eq=False)
class Classifier:
    """log p(material | x) = temperature * (x . weights + bias), up to a constant, of standardised features."""

    weights: np.ndarray  # (f, b)
    bias: np.ndarray  # (b,)
    mean: np.ndarray  # (f,)
    spread: np.ndarray  # (f,)
    temperature: float

    def posterior(self, features: np.ndarray) -> np.ndarray:
        """Probabilities (..., b) of features (..., f)."""
        x = np.clip((features - self.mean) / self.spread, -4, 4)
        score = self.temperature * (x @ self.weights + self.bias)
        score = np.exp(score - score.max(axis=-1, keepdims=True))
        return score / score.sum(axis=-1, keepdims=True)


def learn(features: np.ndarray, labels: np.ndarray, count: int, *, folds: int = 5) -> Classifier:
    """Discriminants of features (n, f) of materials (n,) int; the temperature is the best one on held-out scenes."""
    scores, truth = [], []
    for fold in range(folds):
        held = np.arange(len(labels)) % folds == fold
        one = _discriminants(features[~held], labels[~held], count)
        x = np.clip((features[held] - one.mean) / one.spread, -4, 4)
        scores.append(x @ one.weights + one.bias)
        truth.append(labels[held])
    score, known = np.concatenate(scores), np.concatenate(truth)
    temperatures = np.geomspace(0.05, 1.5, 30)
    losses = [_loss(t * score, known) for t in temperatures]
    whole = _discriminants(features, labels, count)
    return Classifier(whole.weights, whole.bias, whole.mean, whole.spread, float(temperatures[int(np.argmin(losses))]))


def _loss(score: np.ndarray, labels: np.ndarray) -> float:
    top = score.max(axis=1)
    return float(
        (top + np.log(np.exp(score - top[:, None]).sum(axis=1)) - score[np.arange(len(labels)), labels]).mean()
    )


def _discriminants(features: np.ndarray, labels: np.ndarray, count: int, ridge: float = 0.05) -> Classifier:
    mean, spread = features.mean(axis=0), np.maximum(features.std(axis=0), 1e-6)
    x = np.clip((features - mean) / spread, -4, 4)
    centres = np.stack(
        [x[labels == k].mean(axis=0) if (labels == k).any() else np.zeros(x.shape[1]) for k in range(count)]
    )
    within = x - centres[labels]
    precision = np.linalg.inv(within.T @ within / max(len(x) - count, 1) + ridge * np.eye(x.shape[1]))
    weights = precision @ centres.T
    return Classifier(weights, -0.5 * (centres * weights.T).sum(axis=1), mean, spread, 1.0)


def accuracy(
    features: np.ndarray, labels: np.ndarray, surfaces: np.ndarray, probes: np.ndarray, metals: np.ndarray
) -> tuple[float, float]:
    """Shares named right, and told right as metal or not, of pictures (n) whose surface and whose probe were both held
    out, by fifths.
    """
    named = np.full(len(labels), -1)
    for fold in range(25):
        mesh, light = surfaces % 5 == fold % 5, probes % 5 == fold // 5
        held, taught = mesh & light, ~mesh & ~light
        if held.any() and len(np.unique(labels[taught])) == len(metals):
            named[held] = learn(features[taught], labels[taught], len(metals)).posterior(features[held]).argmax(axis=1)
    told = named >= 0
    if not told.any():
        return np.nan, np.nan
    return float((named == labels)[told].mean()), float((metals[named] == metals[labels])[told].mean())


def statistics(picture: Pictured) -> np.ndarray:
    """All `STATISTICS` (f,) of a picture."""
    colour = np.maximum(picture.colour, 1e-3)
    grey = colour.mean(axis=1)
    low, middle, high, top = np.percentile(grey, (10, 50, 90, 99))
    whole = _chroma(colour)
    bright, dark = _chroma(colour[grey >= np.percentile(grey, 97)]), _chroma(colour[grey <= np.percentile(grey, 30)])
    away = (grey - grey.mean()) / max(float(grey.std()), 1e-6)
    slope = np.hypot(picture.grid.slope_x @ grey, picture.grid.slope_y @ grey)
    each = np.log(colour[:, 0] / colour[:, 1]), np.log(colour[:, 2] / colour[:, 1])
    return np.array(
        [
            *whole,
            *(bright - whole),
            *(dark - whole),
            np.log(max(float(grey.std() / grey.mean()), 1e-3)),
            np.clip((away**3).mean(), -5, 10),
            np.log(np.clip((away**4).mean(), 1, 200)),
            np.log(low / middle),
            np.log(high / middle),
            np.log(top / middle),
            float((slope > 0.15).mean()) if len(slope) else 0.0,
            float(np.hypot(*(channel.std() for channel in each))),
        ]
    )


def _chroma(colour: np.ndarray) -> np.ndarray:
    r, g, b = colour.mean(axis=0)
    return np.array([np.log(r / g), np.log(b / g)])
