"""Heuristic prior confidences: the surface seen at an angle (4.35) and the edges of the image (4.37)."""

from __future__ import annotations

import numpy as np

from ipcli.geometry.cameras import rays
from ipcli.geometry.surface import normals
from ipcli.inverse.regularize.operators import gradient

# of the noise that the neighbours leave; chosen with NEAR on the development scenes by the area of `metrics.ause`
SHARE = 0.3
NEAR = 1.5  # pixels, standard deviation of a neighbourhood
LEAST = 0.05  # a surface seen edge-on keeps this much, so that no pixel is cut off from its data


def view_angle(depth: np.ndarray, intrinsics: np.ndarray) -> np.ndarray:
    """|n . r| in [LEAST, 1] (h, w) for the normals n of a smooth depth map (h, w) and the viewing rays r, eq. (4.35).

    On a noisy depth map the normals, and with them this confidence, mean nothing: take a first fused map, not an input.
    """
    directions = rays(depth.shape, intrinsics)
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    cosine = np.abs((normals(depth, intrinsics) * directions).sum(axis=-1))
    return np.clip(np.nan_to_num(cosine), LEAST, 1).astype(np.float32)


def uncertainty(x: np.ndarray, deviation: np.ndarray, count: np.ndarray) -> np.ndarray:
    """The error to expect of a fused image x (h, w), in units of its noise and up to a factor: it orders pixels.

    What the observations leave of their noise, SHARE times their mean deviation over sqrt(K), and how far x changes
    within a pixel, since what is off sideways is off by that in depth: on slopes that turn away, and at the edges of
    surfaces. Both are means over a neighbourhood; deviation (h, w) is sum_k |x - d_k| and count (h, w) the number K of
    observations.
    """
    import cv2

    def near(image: np.ndarray, reach: float) -> np.ndarray:
        return cv2.GaussianBlur(image.astype(np.float32), (0, 0), reach)

    each = near(deviation, 2 * NEAR) / np.maximum(near(count, 2 * NEAR), LEAST)
    return SHARE * each / np.sqrt(np.maximum(near(count, NEAR), LEAST)) + near(np.hypot(*gradient(x)), NEAR)


def image_edges(image: np.ndarray, gain: float, power: float, blur: float) -> np.ndarray:
    """1 + gain g^power (h, w) with g in [0, 1] the blurred image gradient over its 99th percentile, eq. (4.37).

    image is (h, w, 3) uint8. The 1 keeps the data term alive away from edges, where (4.37) as printed would drop it.
    """
    import cv2

    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY).astype(np.float32)
    size = np.hypot(cv2.Sobel(grey, cv2.CV_32F, 1, 0), cv2.Sobel(grey, cv2.CV_32F, 0, 1))
    if blur:
        size = cv2.GaussianBlur(size, (0, 0), blur)
    g = np.clip(size / max(float(np.percentile(size, 99)), 1e-6), 0, 1)
    return (1 + gain * g**power).astype(np.float32)
