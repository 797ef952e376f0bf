"""What a fused map is worth: the share and the residual of each view, errors against the truth, and whether the
confidence knows where the map errs.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ipcli import threads
from ipcli.measurements.accuracy import sparsification_curve, thinned_camera, thinning
from ipcli.measurements.views import View
from ipcli.models.fusion.confidence import view_angle
from ipcli.models.fusion.fuse import Fused
from ipcli.models.fusion.metrics import ause, compare
from ipcli.models.fusion.scenes import EstimatedMap, Scene

THUMBNAIL = 160  # pixels along the longer side
SHARES = 40  # of the pixels, at which sparsification curves are kept
AREAS = ("AUSE confidence", "AUSE uncertainty", "AUSE angle")
CURVES = (
    "kept_error",
    "kept_error_uncertainty",
    "kept_error_angle",
    "least_error",
)  # the order of pixels that each goes by: those of AREAS, the best


def view_table(fused: Fused, names: Sequence[str], views: Sequence[View]) -> dict[str, np.ndarray]:
    """The valid share of each view, the share of the reference it reached and its median distance from the fused map.

    Arrays (K,) for K views, by their names in the `fused-depth` artefact, and `thumbnails` of what each view said.
    """
    depth = fused.depth[:: fused.every, :: fused.every]

    def residual(layer: np.ndarray) -> float:
        hit = np.isfinite(layer) & np.isfinite(depth)
        return float(np.median(np.abs(layer[hit] - depth[hit]))) if hit.any() else np.nan

    step = -(-max(depth.shape) // THUMBNAIL)
    return {
        "views": np.array(list(names)),
        "view_valid": np.array(threads.each(lambda k: np.isfinite(views[k].depth).mean(), range(len(names)))),
        "view_overlap": np.isfinite(fused.layers).mean(axis=(1, 2)),
        "view_residual": np.array(threads.each(residual, list(fused.layers))),
        "thumbnails": np.ascontiguousarray(fused.layers[:, step // 2 :: step, step // 2 :: step]),
    }


def error_table(fused: Fused, reference: View, baseline_focal: float | None) -> dict[str, np.ndarray]:
    """Errors of the reference view, mean, median and fused map, if the truth is known; nothing if not.

    The fused map counts where something was observed, as the others do, and once more with what fills it. Whether
    its confidence knows where it errs is told beside what the mere angle of view (4.35) would know. Of a map beyond
    MOST_PIXELS of `measurements.accuracy` only so many-th rows and columns are looked at.
    """
    if reference.truth is None:
        return {}
    step = thinning(fused.depth.size)

    def thin(image: np.ndarray) -> np.ndarray:
        return np.ascontiguousarray(image[::step, ::step])

    truth, camera = thin(reference.truth), thinned_camera(reference.intrinsics, step)
    observed, depth = thin(fused.observations) > 0, thin(fused.depth)
    maps = {"reference": thin(reference.depth), "mean": thin(fused.mean), "median": thin(fused.median)}
    maps["fused"] = np.where(observed, depth, np.nan).astype(np.float32)
    if not observed.all():
        maps["fused, filled"] = depth
    own = {name: thin(fused.normals) for name in maps if name.startswith("fused")}
    columns, rows = compare(maps, truth, camera, baseline_focal, own)
    error = maps["fused"] - truth
    angle = view_angle(depth, camera)
    return {
        "truth": reference.truth,
        "metrics": rows,
        "metric_rows": np.array(list(maps)),
        "metric_columns": np.array(columns),
        "ause": np.array(ause(thin(fused.confidence), error)),
        "ause_uncertainty": np.array(ause(-thin(fused.uncertainty), error)),
        "ause_angle": np.array(ause(angle, error)),
    }


def sparsification(found: EstimatedMap, others: Sequence[EstimatedMap], scene: Scene) -> tuple[list[float], np.ndarray]:
    """AREAS of a map, and its CURVES (4, SHARES): mean error of the pixels kept, in mean errors.

    On the pixels that all maps have, as the other measures; NaN for a map without confidence.
    """
    if found.confidence is None or found.uncertainty is None:
        return [float("nan")] * len(AREAS), np.full((len(CURVES), SHARES), np.nan)
    common = np.isfinite(scene.truth) & np.isfinite([other.depth for other in others]).all(axis=0)
    error = np.abs(found.depth - scene.truth)[common].astype(np.float64)
    angle = view_angle(found.depth, scene.reference.intrinsics)
    trusted = [image[common] for image in (found.confidence, -found.uncertainty, angle)]
    shares = np.linspace(100 / SHARES, 100, SHARES)
    curves = [
        np.interp(shares, *sparsification_curve(error, key, SHARES)) / error.mean()
        for key in (*(-image for image in trusted), error)
    ]
    return [ause(image, error) for image in trusted], np.stack(curves)
