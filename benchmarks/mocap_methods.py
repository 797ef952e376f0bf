"""What a user might take instead to name the action of a clip: each a `fit` on clips and labels and an answer to clips.

A clip is an array (n, j, 3) of joint positions, relative to the root and turned to face one way. Those that work frame by frame
give `frame_scores`, a list of (n, classes) log probabilities; the others name whole clips only. The name of DMW (Gong & Medioni), which
the thesis compares with, is not among them because no code of it is public: DTW-1NN stands in for it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

Clips = Sequence[np.ndarray]


class FrameWise:
    """Scores of single frames, added up over those of a clip: the order of frames plays no part."""

    def fit(self, clips: Clips, labels: np.ndarray) -> None:
        self.classes = np.unique(labels)
        frames = np.concatenate([flat(clip) for clip in clips])
        self.model.fit(frames, np.repeat(labels, [len(clip) for clip in clips]))

    def frame_scores(self, clips: Clips) -> list[np.ndarray]:
        """Of all clips at once, as that is what these classifiers do best."""
        scores = self.log_probabilities(np.concatenate([flat(clip) for clip in clips]))
        return np.split(scores, np.cumsum([len(clip) for clip in clips])[:-1])

    def answer(self, clips: Clips) -> np.ndarray:
        return self.classes[[self.pool(scores).argmax() for scores in self.frame_scores(clips)]]

    def pool(self, scores: np.ndarray) -> np.ndarray:
        return scores.sum(axis=0)


class NearestFrames(FrameWise):
    """k-NN on all joint positions; the votes of a clip's frames are averaged."""

    def __init__(self, k: int):
        from sklearn.neighbors import KNeighborsClassifier

        self.model = KNeighborsClassifier(k)

    def log_probabilities(self, frames: np.ndarray) -> np.ndarray:
        return np.log(self.model.predict_proba(frames) + 1e-9)

    def pool(self, scores: np.ndarray) -> np.ndarray:
        return np.exp(scores).mean(axis=0)


class Discriminant(FrameWise):
    """Linear discriminant analysis with a shrunken covariance; log probabilities of a clip's frames are added."""

    def __init__(self, shrinkage: float | str):
        from sklearn.discriminant_analysis import LinearDiscriminantAnalysis

        self.model = LinearDiscriminantAnalysis(solver="lsqr", shrinkage=shrinkage)

    def log_probabilities(self, frames: np.ndarray) -> np.ndarray:
        return self.model.predict_log_proba(frames).clip(-1e3)


class Covariance:
    """Cov3DJ (Hussein et al. 2013): covariances of all coordinates over the whole clip and three overlapping parts, linear SVM."""

    def __init__(self, levels: int, cost: float):
        from sklearn.pipeline import make_pipeline
        from sklearn.preprocessing import StandardScaler
        from sklearn.svm import LinearSVC

        self.levels = levels
        self.model = make_pipeline(StandardScaler(), LinearSVC(C=cost, random_state=0, max_iter=20_000))

    def fit(self, clips: Clips, labels: np.ndarray) -> None:
        self.model.fit(self._described(clips), labels)

    def answer(self, clips: Clips) -> np.ndarray:
        return self.model.predict(self._described(clips))

    def _described(self, clips: Clips) -> np.ndarray:
        return np.stack([np.concatenate([covariance(part) for part in parts(flat(clip), self.levels)]) for clip in clips])


class TimeWarping:
    """1-NN by dynamic time warping (aeon), the distance divided by the length of the longer clip if `normalised`."""

    def __init__(self, stride: int, window: float, normalised: bool):
        self.stride, self.window, self.normalised = stride, window, normalised

    def fit(self, clips: Clips, labels: np.ndarray) -> None:
        self.clips, self.labels = self._series(clips), np.asarray(labels)

    def answer(self, clips: Clips) -> np.ndarray:
        from aeon.distances import pairwise_distance

        queries = self._series(clips)
        distance = pairwise_distance(queries, self.clips, method="dtw", window=self.window)
        if self.normalised:
            distance /= np.maximum.outer([one.shape[1] for one in queries], [one.shape[1] for one in self.clips])
        return self.labels[distance.argmin(axis=1)]

    def _series(self, clips: Clips) -> list[np.ndarray]:
        return [np.ascontiguousarray(flat(clip)[:: self.stride].T) for clip in clips]


class MiniRocket:
    """Random convolution kernels and a ridge classifier (aeon), clips resampled to one length."""

    def __init__(self, length: int):
        from aeon.classification.convolution_based import MiniRocketClassifier

        self.length, self.model = length, MiniRocketClassifier(random_state=0)

    def fit(self, clips: Clips, labels: np.ndarray) -> None:
        self.model.fit(self._resampled(clips), labels)

    def answer(self, clips: Clips) -> np.ndarray:
        return self.model.predict(self._resampled(clips))

    def _resampled(self, clips: Clips) -> np.ndarray:
        return np.stack([resample(flat(clip), self.length).T for clip in clips]).astype(np.float32)


METHODS: dict[str, tuple[type, tuple[dict[str, Any], ...]]] = {  # class and the grid of its settings
    "DTW-1NN (stands in for DMW)": (
        TimeWarping,
        tuple(dict(stride=2, window=window, normalised=normalised) for window in (0.1, 0.2, 1.0) for normalised in (True, False)),
    ),
    "MiniRocket": (MiniRocket, tuple(dict(length=length) for length in (32, 64, 128))),
    "covariance + linear SVM (Cov3DJ)": (
        Covariance,
        tuple(dict(levels=levels, cost=cost) for levels in (1, 2) for cost in (0.001, 0.01, 0.1)),
    ),
    "k-NN of frames": (NearestFrames, tuple(dict(k=k) for k in (1, 5, 15, 50))),
    "shrinkage LDA of frames": (Discriminant, tuple(dict(shrinkage=share) for share in ("auto", 0.01, 0.1, 0.3, 0.6))),
}
NEEDS = {"DTW-1NN (stands in for DMW)": "aeon", "MiniRocket": "aeon"}  # all others scikit-learn


def flat(clip: np.ndarray) -> np.ndarray:
    """(n, j, 3) -> (n, 3 j)."""
    return clip.reshape(len(clip), -1)


def covariance(frames: np.ndarray) -> np.ndarray:
    """The upper triangle of the covariance of (n, d) frames; of one frame, zeros."""
    matrix = np.cov(frames, rowvar=False, bias=True)
    return matrix[np.triu_indices(len(matrix))]


def parts(frames: np.ndarray, levels: int) -> list[np.ndarray]:
    """The whole clip and, at two levels, its halves and the half in the middle."""
    n = len(frames)
    halves = [(0, n // 2), (n // 4, n // 4 + n // 2), (n - n // 2, n)] if levels == 2 else []
    return [frames, *(frames[start : max(end, start + 1)] for start, end in halves)]


def resample(frames: np.ndarray, length: int) -> np.ndarray:
    """(n, d) at `length` equally spaced times by linear interpolation."""
    at = np.linspace(0, len(frames) - 1, length)
    return np.stack([np.interp(at, np.arange(len(frames)), column) for column in frames.T], axis=1)
