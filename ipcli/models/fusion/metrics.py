"""Errors of depth maps against ground truth: plain ones, those of the thesis' tables, and those of the KITTI
benchmark.
"""

from __future__ import annotations

import numpy as np

from ipcli import threads
from ipcli.geometry.surface import normals
from ipcli.models.fusion.holes import interpolate_background

DEPTH_COLUMNS = ("density %", "RMSE", "MAE", "centred RMSE", "Z-MAE", "N-MAE rad")
DISPARITY_COLUMNS = ("out-3 %", "D-avg px", "out-3 seen %")


def compare(
    maps: dict[str, np.ndarray],
    truth: np.ndarray,
    intrinsics: np.ndarray,
    baseline_focal: float | None,
    own_normals: dict[str, np.ndarray] | None = None,
    own_filling: dict[str, np.ndarray] | None = None,
) -> tuple[list[str], np.ndarray]:
    """Columns and a row of figures for each depth map (h, w), NaN = nothing, against the truth (h, w), NaN = unknown.

    Depth errors are taken where every map has a value, so that no map gains by leaving the hard pixels out; the density
    says how much of the truth each covers by itself. centred RMSE and Z-MAE are those of the thesis' tables, after
    subtracting the mean and the median error; N-MAE is the mean angle between the normals in radians, a missing normal
    counting 90 degrees; of the maps in `own_normals` those (h, w, 3) are judged, of others those of the map. With
    baseline_focal (pixels times unit) follow the share of disparities that are off by more than 3 px and the mean
    disparity error on every pixel of the truth, which takes the map (h, w) in `own_filling` where there is one and else
    the background interpolation of the KITTI benchmark; and that share of the pixels alone where every map has a value.
    """
    known = np.isfinite(truth)
    everywhere = known & np.isfinite(np.stack(list(maps.values()))).all(axis=0)
    true_normals = normals(truth, intrinsics)

    def row(name: str) -> list[float]:
        depth = maps[name]
        own = own_normals[name] if own_normals and name in own_normals else normals(depth, intrinsics)
        angle = normal_error(own, true_normals, everywhere)
        disparity = []
        if baseline_focal:
            found, true = baseline_focal / depth, baseline_focal / truth
            seen, _ = disparity_errors(found, np.where(everywhere, true, np.nan))
            own_map = own_filling.get(name) if own_filling else None
            full = interpolate_background(found if own_map is None else baseline_focal / own_map)
            disparity = [*disparity_errors(full, true), seen]
        return [100 * np.isfinite(depth[known]).mean(), *depth_errors(depth, truth, everywhere), angle, *disparity]

    rows = threads.each(row, list(maps))
    return list(DEPTH_COLUMNS + (DISPARITY_COLUMNS if baseline_focal else ())), np.array(rows)


def depth_errors(depth: np.ndarray, truth: np.ndarray, where: np.ndarray) -> list[float]:
    """RMSE, MAE, RMSE about the mean error and MAE about the median error over the pixels of `where`; NaN
    without any.
    """
    if not where.any():
        return [float("nan")] * 4
    error = (depth[where] - truth[where]).astype(np.float64)
    return [
        float(np.sqrt((error**2).mean())),
        float(np.abs(error).mean()),
        float(error.std()),
        float(np.abs(error - np.median(error)).mean()),
    ]


def normal_error(n: np.ndarray, true_n: np.ndarray, where: np.ndarray) -> float:
    """Mean angle in radians between normals (h, w, 3) where the true one is defined; a missing one counts pi / 2."""
    where = where & np.isfinite(true_n).all(axis=-1)
    if not where.any():
        return float("nan")
    cosine = np.clip((n[where].astype(np.float64) * true_n[where]).sum(axis=-1), -1, 1)
    return float(np.where(np.isfinite(cosine), np.arccos(cosine), np.pi / 2).mean())


def disparity_errors(disparity: np.ndarray, truth: np.ndarray, tolerance: float = 3.0) -> list[float]:
    """Percentage of the pixels of the truth off by more than `tolerance`, and mean error, in pixels; NaN
    without any.
    """
    known = np.isfinite(truth)
    if not known.any():
        return [float("nan")] * 2
    error = np.abs(disparity[known] - truth[known])
    return [float(100 * (error > tolerance).mean()), float(error.mean())]


def ause(confidence: np.ndarray, error: np.ndarray) -> float:
    """Area under the sparsification error, in mean errors: how much the order of a confidence (h, w) differs from the
    best.

    The sparsification curve is the mean absolute error of the share s of most confident pixels, 0 < s <= 1; the area is
    that between it and the curve of the pixels in the order of their errors (h, w) themselves. 0 is perfect; pixels of
    equal confidence count as in random order. NaN without a pixel that has both, 0 without any error (Ilg et al., ECCV
    2018).
    """
    known = np.isfinite(confidence) & np.isfinite(error)
    error = np.abs(error[known]).astype(np.float64)
    if not error.size:
        return float("nan")
    _, group, size = np.unique(-confidence[known], return_inverse=True, return_counts=True)
    expected = np.repeat(np.bincount(group, error) / size, size)
    kept = np.arange(1, error.size + 1)
    area = ((expected.cumsum() - np.sort(error).cumsum()) / kept).mean()
    return float(area / error.mean()) if error.any() else 0.0
