"""The saliency of a picture: without training, or by a predictor that was learnt from fixations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ipcli.models.saliency import metrics
from ipcli.models.saliency.channels import centre_prior, channels
from ipcli.models.saliency.learning import Predictor, learn
from ipcli.models.saliency.parameters import FixationLearning

PLACE = ("centre", "aside", "above or below", "height")  # channels that are the same in every picture
UNTRAINED = "Boolean maps and SIFT density, centred"
WIDE = 0.35  # spread of the centre prior of the untrained model, as a share of the sides
MARGIN = 1e-6


def untrained(found: Mapping[str, np.ndarray]) -> np.ndarray:
    """Density (a, b) over uniform of a picture of these channels, without any learning: (Boolean maps + half the
    density of SIFT), squared, times a wide centre prior.
    """
    figures, keys = (found[name] / max(float(found[name].max()), MARGIN) for name in ("Boolean maps", "SIFT density"))
    return relative((figures + 0.5 * keys) ** 2 * centre_prior(figures.shape, WIDE))


def relative(density: np.ndarray) -> np.ndarray:
    """A non-negative map (a, b) scaled to mean 1, float32: how many times likelier than by chance."""
    density = np.asarray(density, np.float64)
    mean = float(density.mean())
    return (density / mean if mean > 0 else np.ones(density.shape)).astype(np.float32)


def features(found: Mapping[str, np.ndarray], names: Sequence[str]) -> np.ndarray:
    """Rows (a b, k) float32 of the named channels, each standardised over its picture, but for those of place."""
    columns = [found[name] if name in PLACE else _standardised(found[name]) for name in names]
    return np.stack([column.ravel() for column in columns], axis=1).astype(np.float32)


def _standardised(channel: np.ndarray) -> np.ndarray:
    return (channel - channel.mean()) / (channel.std() + MARGIN)


def predicted(predictor: Predictor, found: Mapping[str, np.ndarray]) -> np.ndarray:
    """Density (a, b) over uniform of a picture of these channels: the odds that the predictor gives."""
    scores = predictor.scores(features(found, predictor.features))
    return relative(np.exp(scores - scores.max()).reshape(found[predictor.features[0]].shape))


def saliency(rgb: np.ndarray, predictor: Predictor | None = None) -> np.ndarray:
    """Density (a, b) float32 over uniform of a picture (h, w, 3) uint8, on the grid of its channels."""
    found = channels(rgb)
    return untrained(found) if predictor is None else predicted(predictor, found)


def examples(
    found: Mapping[str, np.ndarray],
    fixations: np.ndarray,
    names: Sequence[str],
    negatives: int,
    rng: np.random.Generator,
) -> tuple[np.ndarray, np.ndarray]:
    """Rows (n, k) and labels (n,) of a picture: its fixations (m, 2) in pixels of the grid, and places drawn evenly."""
    rows = features(found, names)
    shape = found[names[0]].shape
    points = metrics.fixations_of(fixations)
    looked_at = points[:, 1] * shape[1] + points[:, 0]
    drawn = rng.integers(0, len(rows), negatives)
    chosen = np.concatenate([looked_at, drawn])
    return rows[chosen], np.repeat([1, 0], [len(looked_at), negatives])


def learnt(
    pictures: Sequence[tuple[Mapping[str, np.ndarray], np.ndarray]],
    names: Sequence[str],
    params: FixationLearning,
    seed: int,
) -> Predictor:
    """The predictor learnt from pictures, each its channels and its fixations (n, 2) in pixels of the grid."""
    rng = np.random.default_rng(seed)
    parts = [examples(found, points, names, params.negatives, rng) for found, points in pictures]
    rows, labels = (np.concatenate(part) for part in zip(*parts, strict=True))
    return learn(rows, labels, names, params, seed)


def grey(density: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """A map (a, b) in grey levels (h, w) uint8 at the size of its picture, 255 where it is highest."""
    import cv2

    top = max(float(density.max()), MARGIN)
    wide = cv2.resize(density / top, shape[::-1], interpolation=cv2.INTER_CUBIC)
    return (255 * np.clip(wide, 0, 1) + 0.5).astype(np.uint8)
