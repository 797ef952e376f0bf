"""The method of Vemulapalli, Arrate and Chellappa (CVPR 2014), whose ten splits of the Kinect sets are reported.

A pose is where each bone lies as seen from each other one, as the logarithm of a rigid motion, beside the positions of
the joints. The curves of an action are warped onto a nominal one, described by a Fourier temporal pyramid, and told
from those of all other actions by a linear SVM. Only their paper was at hand, not their code.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from benchmarks.mocap.warping import mean_along, warping_path
from ipcli.geometry import lie

ROUNDS = 5  # of warping and averaging a nominal curve
AXES_FROM = 1500  # frames, spread evenly over all, that the principal axes are those of
QUARTER = 4  # one in so many Fourier coefficients of a segment is kept, the lowest


def relative_bones(starts: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Logarithms (n, 6 b (b - 1)) of the rigid motions from each bone's frame to each other bone, for bones (n, b, 3).

    A bone's frame has it on the x axis from the origin; the motion carries that onto the other bone. Lengths do not
    enter: divide positions by a common one first.
    """
    along = ends - starts
    local = np.swapaxes(lie.minimal_rotation(along), -1, -2)  # (n, b, 3, 3) world to bone
    pairs = [(m, k) for m in range(starts.shape[1]) for k in range(starts.shape[1]) if m != k]
    frame, other = (np.array(side) for side in zip(*pairs, strict=True))
    turned = np.einsum("npij,npj->npi", local[:, frame], along[:, other])
    offset = np.einsum("npij,npj->npi", local[:, frame], starts[:, other] - starts[:, frame])
    length = np.linalg.norm(turned, axis=-1, keepdims=True)
    across = np.cross([1.0, 0.0, 0.0], turned / np.maximum(length, 1e-12))
    sine = np.linalg.norm(across, axis=-1)
    angle = np.arctan2(sine, turned[..., 0] / np.maximum(length[..., 0], 1e-12))
    opposite = (sine < 1e-12) & (angle > 1)
    rotation = across * (angle / np.maximum(sine, 1e-12))[..., None]
    rotation[opposite] = [0.0, 0.0, np.pi]
    moved = np.einsum("npij,npj->npi", lie.left_jacobian_inverse(rotation), offset)
    return np.concatenate([rotation, moved], axis=-1).reshape(len(starts), -1)


def warped(curve: np.ndarray, nominal: np.ndarray) -> np.ndarray:
    """A curve (n, d) at the times of a nominal one (m, d): the mean of what is matched to each of them."""
    square = (curve**2).sum(axis=1)[:, None] + (nominal**2).sum(axis=1) - 2 * curve @ nominal.T
    return mean_along(warping_path(np.sqrt(np.maximum(square, 0.0))), curve, len(nominal))


def nominal_curve(curves: Sequence[np.ndarray]) -> np.ndarray:
    """The mean of curves (n, d) warped onto it, from the one of median length on."""
    middle = curves[int(np.argsort([len(curve) for curve in curves], kind="stable")[len(curves) // 2])]
    for _ in range(ROUNDS):
        middle = np.mean([warped(curve, middle) for curve in curves], axis=0)
    return middle


def fourier_pyramid(curve: np.ndarray, levels: int) -> np.ndarray:
    """The lowest quarter of the Fourier coefficients of a curve (n, d), of its halves, and so on, over the length."""
    found = []
    for level in range(levels):
        for part in np.array_split(curve, 2**level):
            spectrum = np.fft.rfft(part, axis=0) / max(len(part), 1)
            kept = spectrum[: max(1, -(-len(part) // QUARTER))]
            found += [kept.real.ravel(), kept.imag.ravel()]
    return np.concatenate(found)


class WarpedPyramid:
    """Warping to the nominal curve of each action, Fourier temporal pyramid, one linear SVM an action.

    Curves are first turned onto their principal axes, of which so many are kept: distances and inner products stay.
    """

    def __init__(self, stride: int, levels: int, cost: float, axes: int = 200):
        self.stride, self.levels, self.cost, self.axes = stride, levels, cost, axes

    def fit(self, clips: Sequence[np.ndarray], labels: np.ndarray) -> None:
        from sklearn.decomposition import PCA
        from sklearn.svm import SVC

        self.classes, labels = np.unique(labels), np.asarray(labels)
        frames = np.concatenate([self._thinned(clip) for clip in clips])
        frames = frames[:: max(1, len(frames) // AXES_FROM)]
        self.turn = PCA(min(self.axes, *frames.shape), svd_solver="randomized", random_state=0).fit(frames)
        curves = self._curves(clips)
        self.nominal = [
            nominal_curve([curve for curve, label in zip(curves, labels, strict=True) if label == one])
            for one in self.classes
        ]
        self.known = [self._described(curves, middle) for middle in self.nominal]
        self.models = [
            SVC(C=self.cost, kernel="precomputed").fit(known @ known.T, labels == one)
            for one, known in zip(self.classes, self.known, strict=True)
        ]

    def answer(self, clips: Sequence[np.ndarray]) -> np.ndarray:
        curves = self._curves(clips)
        margins = [
            model.decision_function(self._described(curves, middle) @ known.T)
            for model, middle, known in zip(self.models, self.nominal, self.known, strict=True)
        ]
        return self.classes[np.argmax(margins, axis=0)]

    def _thinned(self, clip: np.ndarray) -> np.ndarray:
        return clip.reshape(len(clip), -1)[:: self.stride]

    def _curves(self, clips: Sequence[np.ndarray]) -> list[np.ndarray]:
        return [self.turn.transform(self._thinned(clip)) for clip in clips]

    def _described(self, curves: Sequence[np.ndarray], middle: np.ndarray) -> np.ndarray:
        return np.stack([fourier_pyramid(warped(curve, middle), self.levels) for curve in curves])
