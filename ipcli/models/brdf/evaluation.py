"""Errors of a surface as SIRFS' getError takes them (Barron and Malik, TPAMI 2015): normals in radians, heights in
pixels.
"""

from __future__ import annotations

import numpy as np

from ipcli.models.brdf.grid import normals


def angles(estimate: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """Angle (...) in radians between unit vectors (..., 3)."""
    return np.arccos(np.clip((estimate * truth).sum(axis=-1), -1, 1))


def normal_error(estimate: np.ndarray, truth: np.ndarray, where: np.ndarray) -> float:
    """N-MAE: mean angle, radians, over pixels where both are known; normals (h, w, 3)."""
    known = where & np.isfinite(estimate).all(axis=-1) & np.isfinite(truth).all(axis=-1)
    return float(angles(estimate[known], truth[known]).mean())


def height_error(estimate: np.ndarray, truth: np.ndarray, where: np.ndarray) -> float:
    """Z-MAE: mean |d - median d| of the differences of heights (h, w), in pixels; no scale is fitted."""
    known = where & np.isfinite(estimate) & np.isfinite(truth)
    difference = estimate[known] - truth[known]
    return float(np.abs(difference - np.median(difference)).mean())


def inside(mask: np.ndarray) -> np.ndarray:
    """A mask without the outermost pixels of the image, as getError has it."""
    kept = np.zeros_like(mask)
    kept[1:-1, 1:-1] = mask[1:-1, 1:-1]
    return kept


def of_height(height: np.ndarray, truth: np.ndarray, mask: np.ndarray) -> tuple[float, float]:
    """N-MAE and Z-MAE of heights (h, w) against true heights, NaN where unknown."""
    valid = mask & np.isfinite(truth)
    true_normals = normals(np.where(valid, truth, 0), valid)
    where = inside(valid)
    return normal_error(normals(height, mask), true_normals, where), height_error(height, truth, where)


COLUMNS = ("N-MAE (rad)", "N median (rad)", "Z-MAE (px)")


def errors(
    height: np.ndarray, mask: np.ndarray, true_normals: np.ndarray | None, true_height: np.ndarray | None
) -> list[float]:
    """`COLUMNS` of heights (h, w) against true normals (h, w, 3) or, without them, those of the true heights (h, w);
    NaN undefined.
    """
    where = inside(mask)
    if true_normals is None:
        assert true_height is not None
        valid = mask & np.isfinite(true_height)
        true_normals = normals(np.where(valid, true_height, 0), valid)
        where = inside(valid)
    estimate = normals(np.nan_to_num(height), mask)
    known = where & np.isfinite(true_normals).all(axis=-1)
    off = angles(estimate[known], true_normals[known])
    z = np.nan if true_height is None else height_error(height, true_height, where)
    return [float(off.mean()), float(np.median(off)), z]
