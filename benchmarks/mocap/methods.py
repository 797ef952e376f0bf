"""Ours, and what a user might take instead to name the action of a clip: each a `fit` on clips and labels and an answer
to clips.

A clip is an array (n, j, 3) of joint positions, from the root and turned to face one way; for ours (n, w), the features
of all groups side by side. Those that work frame by frame give `frame_scores`, a list of (n, classes) log
probabilities; the others name whole clips only. DMW (Gong & Medioni), which the thesis compares with, is not among them
because no code of it is public: DTW-1NN stands in for it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.mocap.lie_group import WarpedPyramid
from benchmarks.mocap.problem import by_group

Clips = Sequence[np.ndarray]


class FrameWise:
    """Scores of single frames, added up over those of a clip: the order of frames plays no part."""

    model: Any
    classes: np.ndarray

    def fit(self, clips: Clips, labels: np.ndarray) -> None:
        self.classes = np.unique(labels)
        frames = np.concatenate([flat(clip) for clip in clips])
        self.model.fit(frames, np.repeat(labels, [len(clip) for clip in clips]))

    def frame_scores(self, clips: Clips) -> list[np.ndarray]:
        """Of all clips at once, as that is what these classifiers do best."""
        scores = self.log_probabilities(np.concatenate([flat(clip) for clip in clips]))
        return np.split(scores, np.cumsum([len(clip) for clip in clips])[:-1])

    def log_probabilities(self, frames: np.ndarray) -> np.ndarray:
        """Log probabilities (n, classes) of frames (n, d)."""
        raise NotImplementedError

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


class NearestMoves(FrameWise):
    """k-NN on all joint positions and their change, which counts `weight` times; on positions alone where no change is
    known.
    """

    def __init__(self, k: int, weight: float):
        from sklearn.neighbors import KNeighborsClassifier

        self.weight, self.model, self.still = weight, KNeighborsClassifier(k), KNeighborsClassifier(k)

    def fit(self, clips: Clips, labels: np.ndarray) -> None:
        self.classes = np.unique(labels)
        frames, each = np.concatenate([flat(clip) for clip in clips]), np.repeat(labels, [len(clip) for clip in clips])
        self.model.fit(self._weighed(frames), each)
        self.still.fit(frames[:, : frames.shape[1] // 2], each)

    def log_probabilities(self, frames: np.ndarray) -> np.ndarray:
        moves, half = np.isfinite(frames).all(axis=1), frames.shape[1] // 2
        found = np.empty((len(frames), len(self.classes)))
        if moves.any():
            found[moves] = self.model.predict_proba(self._weighed(frames[moves]))
        if not moves.all():
            found[~moves] = self.still.predict_proba(frames[~moves, :half])
        return np.log(found + 1e-9)

    def pool(self, scores: np.ndarray) -> np.ndarray:
        return np.exp(scores).mean(axis=0)

    def _weighed(self, frames: np.ndarray) -> np.ndarray:
        half = frames.shape[1] // 2
        return np.concatenate([frames[:, :half], self.weight * frames[:, half:]], axis=1)


class Discriminant(FrameWise):
    """Linear discriminant analysis with a shrunken covariance; log probabilities of a clip's frames are added."""

    def __init__(self, shrinkage: float | str):
        from sklearn.discriminant_analysis import LinearDiscriminantAnalysis

        self.model = LinearDiscriminantAnalysis(solver="lsqr", shrinkage=shrinkage)

    def log_probabilities(self, frames: np.ndarray) -> np.ndarray:
        return self.model.predict_log_proba(frames).clip(-1e3)


class Covariance:
    """Cov3DJ (Hussein et al. 2013): covariances of all coordinates over the whole clip and three overlapping parts,
    linear SVM.
    """

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
        return np.stack(
            [np.concatenate([covariance(part) for part in parts(flat(clip), self.levels)]) for clip in clips]
        )


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


class Behaviours(FrameWise):
    """Ours: a Dirichlet process mixture for each action and group of joints, recognised by the product of the groups'
    posteriors.
    """

    def __init__(self, spread: float):
        from ipcli.models.mocap.parameters import Decision, Learning

        self.settings, self.decision = Learning(spread=spread), Decision()

    def fit(self, clips: Clips, labels: np.ndarray) -> None:
        from ipcli.models.mocap import training

        self.classes, action = np.unique(labels, return_inverse=True)
        actions = np.repeat(action, [len(clip) for clip in clips])
        self.model = training.train(
            by_group(np.concatenate(clips)), actions, tuple(self.classes), self.settings, np.random.default_rng(0)
        )

    def frame_scores(self, clips: Clips) -> list[np.ndarray]:
        from ipcli.models.mocap import recognition

        density = recognition.log_densities(self.model, by_group(np.concatenate(clips)))
        posterior = recognition.frame_posteriors(self.model, density, self.decision)
        known = np.where(np.isfinite(posterior), posterior, 0.0)  # a frame that shows no group whole says nothing
        return np.split(known, np.cumsum([len(clip) for clip in clips])[:-1])


class Variational(Behaviours):
    """All as in ours, but scikit-learn's variational mixture of at most so many components in place of the
    sampled one.
    """

    def __init__(self, components: int, spread: float):
        super().__init__(spread)
        self.components = components

    def fit(self, clips: Clips, labels: np.ndarray) -> None:
        from ipcli.models.mocap import behaviours

        self.classes, action = np.unique(labels, return_inverse=True)
        actions = np.repeat(action, [len(clip) for clip in clips])
        rows = behaviours.draw_frames(actions, list(map(str, self.classes)), self.settings, np.random.default_rng(0))
        features = {group: x[rows] for group, x in behaviours.with_body(by_group(np.concatenate(clips)), True).items()}
        projections = behaviours.fit_projections(features, actions[rows], self.settings)
        cells = [
            [self._density(project(features[group])[actions[rows] == a]) for group, project in projections.items()]
            for a in range(len(self.classes))
        ]
        alpha = np.ones((len(self.classes), len(projections)))
        self.model = behaviours.Model(
            tuple(self.classes), tuple(projections), tuple(projections.values()), tuple(map(tuple, cells)), alpha
        )

    def _density(self, x: np.ndarray) -> Any:
        """What it learnt, as the kind of density that ours is: a t of so many degrees of freedom is a Gaussian."""
        from sklearn.mixture import BayesianGaussianMixture

        from ipcli.inverse.bayes.predictive import Predictive
        from ipcli.models.mocap.behaviours import of_others

        x = x[np.isfinite(x).all(axis=1)]
        count = min(self.components, len(x))
        mixture = BayesianGaussianMixture(n_components=count, reg_covar=1e-2, max_iter=200, random_state=0).fit(x)
        whole = Predictive(
            np.log(mixture.weights_),
            np.full(count, 1e6),
            mixture.means_,
            np.linalg.cholesky(mixture.covariances_),
            np.zeros(count, np.int32),
        )
        return of_others(whole, self.settings.spread)


OURS, POSES = "behaviours (ours)", "behaviours (ours), poses alone"
SPREADS = (0.1, 0.3, 0.6)
DTW = "DTW-1NN (stands in for DMW)"
LIE_GROUP = "Lie group, DTW, Fourier pyramid, linear SVM (Vemulapalli et al.)"
SKELETONS = ("positions", "reposed")  # the actor's own, or the common one
METHODS: dict[
    str, tuple[type, tuple[dict[str, Any], ...]]
] = {  # class and the grid of its settings; `by`: what describes a frame
    OURS: (Behaviours, tuple(dict(by="motion", spread=spread) for spread in SPREADS)),
    POSES: (Behaviours, tuple(dict(by="poses", spread=spread) for spread in SPREADS)),
    "scikit-learn mixture in place of ours": (
        Variational,
        tuple(dict(by="motion", components=count, spread=spread) for count in (5, 10, 20) for spread in SPREADS),
    ),
    "k-NN of frames": (NearestFrames, tuple(dict(by=by, k=k) for by in SKELETONS for k in (1, 5, 15, 50))),
    "k-NN of frames and their change": (
        NearestMoves,
        tuple(
            dict(by=f"{by}+change", k=k, weight=weight)
            for by in SKELETONS
            for k in (1, 5, 15, 50)
            for weight in (1.0, 3.0)
        ),
    ),
    "shrinkage LDA of frames": (
        Discriminant,
        tuple(dict(by=by, shrinkage=share) for by in SKELETONS for share in ("auto", 0.01, 0.1, 0.3, 0.6)),
    ),
    "covariance + linear SVM (Cov3DJ)": (
        Covariance,
        tuple(
            dict(by=by, levels=levels, cost=cost)
            for by in SKELETONS
            for levels in (1, 2)
            for cost in (0.001, 0.01, 0.1)
        ),
    ),
    DTW: (
        TimeWarping,
        tuple(
            dict(by=by, stride=2, window=window, normalised=normalised)
            for by in SKELETONS
            for window in (0.1, 0.2, 1.0)
            for normalised in (True, False)
        ),
    ),
    LIE_GROUP: (
        WarpedPyramid,
        tuple(
            dict(by=by, stride=2, levels=levels, cost=cost)
            for by in ("lie-group", *SKELETONS)
            for levels in (1, 3)
            for cost in (0.1, 1.0, 10.0)
        ),
    ),
    "MiniRocket": (MiniRocket, tuple(dict(by=by, length=length) for by in SKELETONS for length in (32, 64, 128))),
}
NEEDS = {DTW: "aeon", "MiniRocket": "aeon"}  # all others scikit-learn


def flat(clip: np.ndarray) -> np.ndarray:
    """(n, j, 3) -> (n, 3 j)."""
    return clip.reshape(len(clip), -1)


def covariance(frames: np.ndarray) -> np.ndarray:
    """The upper triangle of the covariance of (n, d) frames; of one frame, zeros."""
    matrix = np.cov(frames, rowvar=False, bias=True)
    return matrix[np.triu_indices(len(matrix))]


def parts(frames: np.ndarray, levels: int) -> list[np.ndarray]:
    """The whole clip and, at two levels, its halves and the half in the middle, none without a frame."""
    half = max(len(frames) // 2, 1)
    starts = (0, (len(frames) - half) // 2, len(frames) - half) if levels == 2 else ()
    return [frames, *(frames[start : start + half] for start in starts)]


def resample(frames: np.ndarray, length: int) -> np.ndarray:
    """(n, d) at `length` equally spaced times by linear interpolation."""
    at = np.linspace(0, len(frames) - 1, length)
    return np.stack([np.interp(at, np.arange(len(frames)), column) for column in frames.T], axis=1)
