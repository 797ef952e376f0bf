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

    def looked(beside: float) -> np.ndarray:
        """Grey levels of the right picture so many pixels beside where it is taken to show the patch."""
        maps = (at + np.float32(beside))[None], v[None] - np.float32(top)
        return cv2.remap(strip, *maps, cv2.INTER_LANCZOS4, borderMode=cv2.BORDER_REPLICATE)[0].astype(np.float64)

    for turn in range(ROUNDS + 1):
        at = (u - base * (ideal @ normal)).astype(np.float32)
        if at.min() < 1 or at.max() > right.shape[1] - 2:
            return None
        other = looked(0.0)
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
    response = design.copy()
    response[:, :3] = -base * ((looked(1.0) - looked(-1.0)) / 2)[:, None] * ideal
    covariance = _covariance(design, response, rest, pixels)[:3, :3]
    if not np.linalg.eigvalsh(covariance)[0] > 0:
        return None
    return Plane(normal, covariance)


def _covariance(design: np.ndarray, response: np.ndarray, rest: np.ndarray, pixels: np.ndarray) -> np.ndarray:
    """Covariance of where `design` . `rest` = 0, when `rest` answers to the unknowns by `response` (n, k).

    Steps are weighed by the slopes of the left picture, the residual moves by those of the right one, and each holds
    the noise of its own picture. Their product does not grow with it; the square of the left slopes would, and would
    make the error too small. Errors (n,) of neighbouring pixels (n, 2) are alike (interpolation, a surface that is not
    quite a plane), by as much as they are on the whole patch: what `rest` tells of pairs up to `REACH` pixels apart.
    """
    columns, rows = (pixels - pixels.min(axis=0)).T
    shape = rows.max() + 1, columns.max() + 1
    errors, there, scores = np.zeros(shape), np.zeros(shape), np.zeros((*shape, design.shape[1]))
    errors[rows, columns], there[rows, columns], scores[rows, columns] = rest, 1.0, design
    middle = np.zeros((design.shape[1], design.shape[1]))
    for down in range(-REACH, REACH + 1):
        for right in range(-REACH, REACH + 1):
            one, other = (_overlap(shape, sign * down, sign * right) for sign in (1, -1))
            pairs = float((there[one] * there[other]).sum())
            if pairs:
                alike = float((errors[one] * errors[other]).sum()) / pairs
                middle += alike * np.einsum("vua,vub->ab", scores[one], scores[other])
    inverse = np.linalg.pinv(design.T @ response)  # without slopes in one of them no error is known: not positive
    spare = len(rest) / (len(rest) - design.shape[1])
    return spare * inverse @ middle @ inverse.T


def _overlap(shape: tuple[int, int], down: int, right: int) -> tuple[slice, slice]:
    """The part of an array of `shape` that is left when it is moved so far."""
    (height, width) = shape
    return slice(max(down, 0), height + min(down, 0)), slice(max(right, 0), width + min(right, 0))
