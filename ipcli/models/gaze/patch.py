"""The plane before one gaze, aligned to the grey levels of both pictures: disparities to some hundredths of a pixel.

Dense matching gives each pixel a disparity that is off by a quarter of a pixel, and neighbours are off alike (they
share windows, and sixteenths draw towards whole pixels), so that their spread does not tell how wrong their mean is.
Least-squares matching (Grün 1985) of the patch as a whole does, by the noise that is left.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

ROUNDS = 6
STEADY = 0.01  # pixels: a step that ends the rounds
TRUST = 1.0  # pixels that the middle may move from where dense matching put it
LEAST = 40  # pixels of a patch
REACH = 2  # pixels over which errors of grey levels are alike
ALIKE = 0.5  # least correlation of the two pictures of a patch


@dataclass(frozen=True, eq=False)
class Plane:
    """n of n . X = 1 in the rectified frame: inverse depth n . (x, y, 1) at normalised coordinates."""

    normal: np.ndarray  # (3,) 1 / metres
    covariance: np.ndarray  # (3, 3)


def align(
    left: np.ndarray, right: np.ndarray, ideal: np.ndarray, pixels: np.ndarray, base: float, start: np.ndarray
) -> Plane | None:
    """Gauss-Newton of grey levels, gain and level free; None where it does not settle near `start` (3,).

    Slopes are the left picture's: those of the interpolated right one hold the very noise they are to be set against,
    which draws disparities towards whole pixels.

    `left`, `right` (h, w): rectified pictures. `pixels` (n, 2) int (u, v): the patch, `ideal` (n, 3) its normalised
    coordinates. `base`: pixels * metres, disparity = base * inverse depth.
    """
    import cv2

    if len(pixels) < LEAST:
        return None
    u, v = pixels[:, 0].astype(np.float32), pixels[:, 1].astype(np.float32)
    top, bottom = pixels[:, 1].min(), pixels[:, 1].max() + 1
    strip = right[top:bottom].astype(np.float32)  # fewer rows to convert
    seen = left[pixels[:, 1], pixels[:, 0]].astype(np.float64)
    beside = [left[pixels[:, 1], np.clip(pixels[:, 0] + k, 0, left.shape[1] - 1)] for k in (1, -1)]
    slope = (beside[0].astype(np.float64) - beside[1]) / 2
    middle = ideal.mean(axis=0)
    normal, gain = start.copy(), 1.0
    for turn in range(ROUNDS + 1):
        at = (u - base * (ideal @ normal)).astype(np.float32)
        if at.min() < 1 or at.max() > right.shape[1] - 2:
            return None
        other = cv2.remap(
            strip, at[None], v[None] - np.float32(top), cv2.INTER_LANCZOS4, borderMode=cv2.BORDER_REPLICATE
        )[0].astype(np.float64)  # fmt: skip
        design = np.column_stack([-base * gain * slope[:, None] * ideal, -seen, -np.ones(len(seen))])
        solved, _, rank, _ = np.linalg.lstsq(design, -other, rcond=1e-9)
        if rank < design.shape[1]:
            return None
        step, rest = solved[:3], other + design @ solved
        normal, gain = normal + step, float(solved[3])
        if abs(base * (ideal @ step)).max() < STEADY or turn == ROUNDS:
            break
    moved = abs(base * (middle @ (normal - start)))
    spread = float(np.std(other))
    if moved > TRUST or not np.isfinite(normal).all() or rest.std() > spread * np.sqrt(1 - ALIKE**2):
        return None
    return Plane(normal, _covariance(design, rest, pixels)[:3, :3])


def _covariance(design: np.ndarray, rest: np.ndarray, pixels: np.ndarray) -> np.ndarray:
    """Covariance of a least-squares fit whose errors (n,) at neighbouring pixels (n, 2) are alike (Conley 1999).

    Interpolated pictures and a surface that is not quite a plane leave such errors; taken as independent they would
    make it half of what it is. Weights fall linearly over `REACH` pixels along each axis.
    """
    from scipy.ndimage import correlate1d

    inverse = np.linalg.inv(design.T @ design)
    corner = pixels.min(axis=0)
    columns, rows = (pixels - corner).T
    scores = np.zeros((rows.max() + 1, columns.max() + 1, design.shape[1]))
    scores[rows, columns] = design * rest[:, None]
    weights = 1 - np.abs(np.arange(-REACH, REACH + 1)) / (REACH + 1)
    around = scores
    for axis in range(2):
        around = correlate1d(around, weights, axis=axis, mode="constant")
    middle = np.einsum("vua,vub->ab", scores, around)
    spare = len(rest) / (len(rest) - design.shape[1])
    return spare * inverse @ (middle + middle.T) @ inverse / 2
