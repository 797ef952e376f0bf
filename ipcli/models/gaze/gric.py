"""Homography or fundamental matrix between two pictures, by GRIC (3.5)-(3.6), and when a gaze changes.

Torr's criterion: residuals within the model against what the model costs. Both residuals are Sampson distances: a
one-sided transfer error carries the noise of both pictures and picks the fundamental matrix every time.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ipcli.models.gaze.parameters import Keyframes

DIMENSIONS = 4  # r: of a pair of pixels
F_SHAPE, H_SHAPE = (3, 7), (2, 8)  # (d, k): dimension of the manifold, parameters
LEAST = 16  # matches below which nothing is said


def gric(squares: np.ndarray, sigma: float, shape: tuple[int, int], dimensions: int = DIMENSIONS) -> float:
    """(3.5) of squared residuals (n,) in pixels^2 for a model of `shape` (d, k)."""
    d, k = shape
    n = len(squares)
    cut = 2.0 * (dimensions - d)
    return float(np.minimum(squares / sigma**2, cut).sum() + n * d * np.log(dimensions) + k * np.log(dimensions * n))


def sampson_fundamental(f: np.ndarray, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Squared Sampson distances (n,) of pixels (n, 2): (x'^T F x)^2 / (|(F x)_12|^2 + |(F^T x')_12|^2)."""
    a, b = _homogeneous(first), _homogeneous(second)
    line, back = a @ f.T, b @ f
    slope = np.square(line[:, :2]).sum(axis=1) + np.square(back[:, :2]).sum(axis=1)
    return np.einsum("ni,ni->n", b, line) ** 2 / np.maximum(slope, 1e-300)


def sampson_homography(h: np.ndarray, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Squared Sampson distances (n,) of pixels (n, 2) to second = H first: e^T (J J^T)^-1 e (Chum 2005)."""
    a = _homogeneous(first)
    mapped = a @ h.T
    u, v = second.T
    e = np.stack([mapped[:, 0] - u * mapped[:, 2], mapped[:, 1] - v * mapped[:, 2]], axis=1)
    zero = np.zeros(len(a))
    row_u = np.stack([h[0, 0] - u * h[2, 0], h[0, 1] - u * h[2, 1], -mapped[:, 2], zero], axis=1)
    row_v = np.stack([h[1, 0] - v * h[2, 0], h[1, 1] - v * h[2, 1], zero, -mapped[:, 2]], axis=1)
    aa, bb, ab = ((x * y).sum(axis=1) for x, y in ((row_u, row_u), (row_v, row_v), (row_u, row_v)))
    det = np.maximum(aa * bb - ab**2, 1e-300)
    return (bb * e[:, 0] ** 2 - 2 * ab * e[:, 0] * e[:, 1] + aa * e[:, 1] ** 2) / det


def _homogeneous(pixels: np.ndarray) -> np.ndarray:
    return np.concatenate([pixels, np.ones((len(pixels), 1))], axis=1)


@dataclass(frozen=True, eq=False)
class FrameMotion:
    """Both models between a keyframe and a frame, with their scores; NaN where there were too few matches."""

    fundamental: np.ndarray  # (3, 3)
    homography: np.ndarray  # (3, 3)
    score_f: float
    score_h: float
    matches: int
    flow: float  # median displacement of the matches, pixels

    @property
    def is_parallax(self) -> bool:
        """Whether the fundamental matrix explains the matches better."""
        return self.score_f < self.score_h


def motion(first: np.ndarray, second: np.ndarray, sigma: float, seed: int = 0) -> FrameMotion:
    """Fit both models to matches (n, 2) robustly and score them."""
    import cv2

    nothing = np.full((3, 3), np.nan)
    flow = float(np.median(np.linalg.norm(second - first, axis=1))) if len(first) else float("nan")
    if len(first) < LEAST:
        return FrameMotion(nothing, nothing, float("nan"), float("nan"), len(first), flow)
    cv2.setRNGSeed(seed)
    f = _fitted(lambda: cv2.findFundamentalMat(first, second, cv2.USAC_MAGSAC, 2 * sigma, 0.999, 2000))
    h = _fitted(lambda: cv2.findHomography(first, second, cv2.USAC_MAGSAC, 3 * sigma, None, 2000, 0.999))
    scores = [
        float("inf") if model is None else gric(distance(model, first, second), sigma, shape)
        for model, distance, shape in ((f, sampson_fundamental, F_SHAPE), (h, sampson_homography, H_SHAPE))
    ]
    return FrameMotion(nothing if f is None else f, nothing if h is None else h, scores[0], scores[1], len(first), flow)


def _fitted(fit: Callable[[], tuple[Any, Any]]) -> np.ndarray | None:
    """The model (3, 3) that OpenCV fits, or None: it gives up by an error where a refined sample is degenerate."""
    import cv2

    try:
        model = fit()[0]
    except cv2.error:
        return None
    return model if model is not None and model.shape == (3, 3) else None


def change(found: FrameMotion, before: np.ndarray, now: np.ndarray, rule: str = "sampson") -> float:
    """delta: how far the gaze (pixels (2,), in the keyframe and now) is from what the motion explains.

    `sampson`: the distance in pixels under the selected model. `printed`: (3.7) with the absolute value, which the
    arbitrary scale and sign of F make of no unit.
    """
    a, b = before[None], now[None]
    if not np.isfinite([*before, *now, found.score_f, found.score_h]).all():
        return float("nan")
    if rule == "printed":
        if found.is_parallax:
            scale = np.linalg.norm(found.fundamental)
            return float(abs(_homogeneous(b)[0] @ found.fundamental @ _homogeneous(a)[0]) / scale)
        mapped = found.homography @ _homogeneous(a)[0]
        return float(np.linalg.norm(mapped[:2] / mapped[2] - now))
    if found.is_parallax:
        return float(np.sqrt(sampson_fundamental(found.fundamental, a, b)[0]))
    return float(np.sqrt(sampson_homography(found.homography, a, b)[0]) * np.sqrt(2.0))


def wants_keyframe(changed: list[bool], late: bool, p: Keyframes) -> bool:
    """Whether a new subsequence begins: the gaze changed for some frames running, or time passed while moving."""
    recent = changed[-p.samples :]
    return late or (len(recent) == p.samples and all(recent))
