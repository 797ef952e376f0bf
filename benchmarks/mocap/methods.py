"""What a user might take instead of ours to name the action of a clip: each a `fit` on clips and labels and an answer.

A clip is an array (n, j, 3) of joint positions, from the root and turned to face one way; for what learns from ours'
features (n, w), those of all groups side by side. Those that work frame by frame give `frame_scores`, a list of
(n, classes) log probabilities; the others name whole clips only. DMW (Gong & Medioni), which the thesis compares with,
is not among them because no code of it is public: DTW-1NN stands in for it.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.mocap.lie_group import WarpedPyramid
from benchmarks.mocap.problem import by_group
from benchmarks.mocap.warping import nearest

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
        self.k = k

    def fit(self, clips: Clips, labels: np.ndarray) -> None:
        self.classes, each = np.unique(np.repeat(labels, [len(clip) for clip in clips]), return_inverse=True)
        self.known, self.votes = together(clips), np.eye(len(self.classes))[each]

    def log_probabilities(self, frames: np.ndarray) -> np.ndarray:
        return self._log_votes(self.known, frames)

    def pool(self, scores: np.ndarray) -> np.ndarray:
        return np.exp(scores).mean(axis=0)

    def _log_votes(self, known: np.ndarray, frames: np.ndarray) -> np.ndarray:
        return np.log(self.votes[nearest_frames(known, frames)[:, : self.k]].mean(axis=1) + 1e-9)


class NearestMoves(NearestFrames):
    """k-NN on all joint positions and their change, which counts `weight` times; on positions alone where no change is
    known.
    """

    def __init__(self, k: int, weight: float):
        super().__init__(k)
        self.weight = weight

    def log_probabilities(self, frames: np.ndarray) -> np.ndarray:
        moves, half = np.isfinite(frames).all(axis=1), frames.shape[1] // 2
        found = np.empty((len(frames), len(self.classes)))
        if moves.any():
            found[moves] = self._log_votes(self._weighed(self.known), self._weighed(frames[moves]))
        if not moves.all():
            found[~moves] = self._log_votes(self.known[:, :half], frames[~moves, :half])
        return found

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
    """The nearest clip by dynamic time warping; the window is a share of the longer clip. Longer clips have longer
    paths: their distance is over its length if `normalised`.
    """

    def __init__(self, stride: int, window: float, normalised: bool):
        self.stride, self.window, self.normalised = stride, window, normalised

    def fit(self, clips: Clips, labels: np.ndarray) -> None:
        self.known, self.labels = self._in_a_row(clips), np.asarray(labels)

    def answer(self, clips: Clips) -> np.ndarray:
        return self.labels[nearest(*self._in_a_row(clips), *self.known, self.window, self.normalised)]

    def _in_a_row(self, clips: Clips) -> tuple[np.ndarray, np.ndarray]:
        thinned = [clip[:: self.stride] for clip in clips]
        return together(thinned), np.cumsum([0, *map(len, thinned)])


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


class Variational(FrameWise):
    """All as in ours, but scikit-learn's variational mixture of at most so many components in place of the
    sampled one.
    """

    def __init__(self, components: int, spread: float):
        from ipcli.models.mocap.parameters import Decision, Learning

        self.settings, self.decision, self.components = Learning(spread=spread), Decision(), components

    def fit(self, clips: Clips, labels: np.ndarray) -> None:
        from ipcli.models.mocap import behaviours, training

        self.classes, action = np.unique(labels, return_inverse=True)
        drawn = training.TrainingSet.draw(
            by_group(np.concatenate(clips)),
            np.repeat(action, [len(clip) for clip in clips]),
            tuple(self.classes),
            self.settings,
            np.random.default_rng(0),
        )
        densities = {name: self._density(points) for name, points in drawn.points.items()}
        groups = tuple(drawn.projections)
        cells = tuple(tuple(densities[f"{name}, {group}"] for group in groups) for name in drawn.names)
        alpha = np.ones((len(cells), len(groups)))
        self.model = behaviours.Model(drawn.names, groups, tuple(drawn.projections.values()), cells, alpha)

    def frame_scores(self, clips: Clips) -> list[np.ndarray]:
        from ipcli.models.mocap import recognition

        density = recognition.log_densities(self.model, by_group(np.concatenate(clips)))
        posterior = recognition.frame_posteriors(self.model, density, self.decision)
        known = np.where(np.isfinite(posterior), posterior, 0.0)  # a frame that shows no group whole says nothing
        return np.split(known, np.cumsum([len(clip) for clip in clips])[:-1])

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


MOST_NEAREST, REMEMBERED = 50, 3
SPREADS = (0.1, 0.3, 0.6)
DTW = "DTW-1NN (stands in for DMW)"
LIE_GROUP = "Lie group, DTW, Fourier pyramid, linear SVM (Vemulapalli et al.)"
SKELETONS = ("positions", "reposed")  # the actor's own, or the common one
METHODS: dict[
    str, tuple[type, tuple[dict[str, Any], ...]]
] = {  # class and the grid of its settings; `by`: what describes a frame
    "scikit-learn mixture in place of ours": (
        Variational,
        tuple(dict(by="motion", components=count, spread=spread) for count in (5, 10, 20) for spread in SPREADS),
    ),
    "k-NN of frames": (NearestFrames, tuple(dict(by=by, k=k) for by in SKELETONS for k in (1, 5, 15, MOST_NEAREST))),
    "k-NN of frames and their change": (
        NearestMoves,
        tuple(
            dict(by=f"{by}+change", k=k, weight=weight)
            for by in SKELETONS
            for weight in (1.0, 3.0)
            for k in (1, 5, 15, MOST_NEAREST)
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
            for cost in (0.1, 1.0, 10.0, 100.0)
        ),
    ),
    "MiniRocket": (MiniRocket, tuple(dict(by=by, length=length) for by in SKELETONS for length in (32, 64, 128))),
}
NEEDS = {"MiniRocket": "aeon"}  # all others scikit-learn
ORDERED = (DTW, LIE_GROUP, "MiniRocket")  # tell curves apart: asked about whole clips alone


def together(clips: Clips) -> np.ndarray:
    """The frames (n, d) of all clips, in single precision."""
    return np.concatenate([flat(clip) for clip in clips], dtype=np.float32)


_found: dict[str, np.ndarray] = {}


def nearest_frames(known: np.ndarray, asked: np.ndarray) -> np.ndarray:
    """Which of the known frames (m, d) are the MOST_NEAREST to each that is asked about, (n, k), the nearest first.

    The last few answers are kept: settings of a grid that differ in k alone ask again.
    """
    from sklearn.neighbors import NearestNeighbors

    key = " ".join(hashlib.sha256(frames.tobytes()).hexdigest() for frames in (known, asked))
    if key not in _found:
        while len(_found) >= REMEMBERED:
            _found.pop(next(iter(_found)))
        count = min(MOST_NEAREST, len(known))
        searched = NearestNeighbors(n_neighbors=count, algorithm="brute").fit(known)
        _found[key] = searched.kneighbors(asked.astype(np.float32), return_distance=False)
    return _found[key]


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
