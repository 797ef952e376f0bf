"""Disparities of both cameras of a rectified pair, by OpenCV's semi-global matching (Hirschmüller 2008)."""

from __future__ import annotations

from typing import Any

import numpy as np

SUBPIXEL = 16.0  # OpenCV gives disparities as integers in sixteenths of a pixel


def semi_global(
    left: np.ndarray,
    right: np.ndarray,
    *,
    disparities: int = 160,
    block: int = 5,
    small_step: int = 4,
    large_step: int = 32,
    uniqueness: int = 5,
    speckle_size: int = 100,
    speckle_range: int = 2,
    mode: str = "hh",
    consistency: float | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Disparities (h, w) float32 > 0 of the left and of the right image, NaN where there is none.

    Images are (h, w) or (h, w, 3) uint8. ``disparities`` is the length of the search, a multiple of 16; ``small_step``
    and ``large_step`` penalise changes of one and of more disparities, per pixel of the block. ``consistency`` drops
    pixels whose match in the other image points back to elsewhere, by more than so many pixels; None keeps them.
    """
    import cv2

    size = block * block * (left.shape[2] if left.ndim == 3 else 1)
    choices = {"sgbm": cv2.STEREO_SGBM_MODE_SGBM, "hh": cv2.STEREO_SGBM_MODE_HH, "3way": cv2.STEREO_SGBM_MODE_SGBM_3WAY}
    matcher = cv2.StereoSGBM.create(
        minDisparity=0,
        numDisparities=disparities,
        blockSize=block,
        P1=small_step * size,
        P2=large_step * size,
        disp12MaxDiff=1,
        uniquenessRatio=uniqueness,
        speckleWindowSize=speckle_size,
        speckleRange=speckle_range,
        mode=choices[mode],
    )
    of_left = _match(matcher, left, right, disparities)
    of_right = _flip(_match(matcher, _flip(right), _flip(left), disparities))
    if consistency is None:
        return of_left, of_right
    return consistent(of_left, of_right, consistency), _flip(consistent(_flip(of_right), _flip(of_left), consistency))


def consistent(of_left: np.ndarray, of_right: np.ndarray, tolerance: float) -> np.ndarray:
    """``of_left`` without what ``of_right`` does not confirm: |d_L(u) - d_R(u - d_L(u))| > tolerance, or no d_R."""
    height, width = of_left.shape
    v, u = np.indices((height, width))
    target = u - np.nan_to_num(of_left, nan=0.0)
    column = np.clip(np.rint(target), 0, width - 1).astype(np.intp)
    confirmed = np.abs(of_left - of_right[v, column]) <= tolerance
    return np.where(confirmed, of_left, np.nan).astype(np.float32)


def _flip(image: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(image[:, ::-1])


def _match(matcher: Any, image: np.ndarray, other: np.ndarray, disparities: int) -> np.ndarray:
    """Disparity of ``image``. OpenCV searches only where the whole range fits in, so both images are extended."""
    import cv2

    padded = (cv2.copyMakeBorder(picture, 0, 0, disparities, 0, cv2.BORDER_REPLICATE) for picture in (image, other))
    disparity = matcher.compute(*padded)[:, disparities:] / SUBPIXEL
    inside = (disparity > 0) & (disparity <= np.arange(image.shape[1]))
    return np.where(inside, disparity, np.nan).astype(np.float32)
