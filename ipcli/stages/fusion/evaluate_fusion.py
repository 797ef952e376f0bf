"""evaluate-fusion: a scene with known truth -> the errors of every method, at the automatic lambda and at the tuned
one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ipcli.errors import ParameterError
from ipcli.params import Run, option
from ipcli.progress import Progress, silent
from ipcli.stages.fusion.scenes import Judged, Scene, Trials, Variant, open_scene, parse
from ipcli.stages.fusion.tune_fusion import best_lambdas

if TYPE_CHECKING:
    import numpy as np

    from ipcli.measurements.views import View
    from ipcli.stages.kit.artefact import Outcome

POINTS = 40  # of a sparsification curve
AREAS = ("AUSE confidence", "AUSE uncertainty", "AUSE angle")
CURVES = (
    "kept_error",
    "kept_error_uncertainty",
    "kept_error_angle",
    "least_error",
)  # the order of pixels that each goes by: those of AREAS, the best
GIVEN = ("reference", "mean", "median")  # what a fusion starts from: no lambda, and the same for every method


@dataclass(frozen=True)
class Params(Trials):
    """Which maps to keep beside the figures."""

    keep: tuple[str, ...] = option(
        ("tgv-l1", "l1-heuristic", "l1-adapt", "adapt-hprior"),
        "Methods whose maps are kept, to be looked at.",
        flag="--keep",
    )


@dataclass(frozen=True, eq=False)
class Row:
    """What one method at one lambda came to."""

    label: str
    rule: str  # "none", "automatic" or "tuned"
    lam: float  # NaN for none
    found: Judged


def run(
    source: Path,
    output: Path,
    params: Params,
    run: Run,
    tuning: Path | None = None,
    progress: Progress = silent,
) -> Outcome:
    """Write the `trials` artefact and beside it a page (.html). Methods that `tuning` has not are not shown at a tuned
    lambda.
    """
    from ipcli.stages.kit.artefact import Job, make
    from ipcli.stages.kit.pages import page

    if params.fusion.lam is not None:
        raise ParameterError("lambda is the automatic one or that of --tuning: leave out --lambda")
    lambdas = best_lambdas(tuning) if tuning else {}
    inputs = (source, tuning) if tuning else (source,)
    job = Job(output, "fusion-trials", "evaluate-fusion", params, inputs, page(output, "fusion-trials"))
    return make(job, lambda: trials(open_scene(source, params), params, lambdas, progress), run)


def trials(scene: Scene, params: Params, lambdas: Mapping[str, float], progress: Progress) -> dict[str, np.ndarray]:
    """The arrays of the artefact."""
    import numpy as np

    rows = fused_rows(scene, params, lambdas, progress)
    columns, values = scene.errors({f"{row.label} {row.rule}": row.found for row in rows})
    judged = [sparsified(row, rows, scene.reference) for row in rows]
    kept = [row for row in rows if row.rule != "tuned" and row.label in kept_labels(params)]
    return {
        "methods": np.array([row.label for row in rows]),
        "rules": np.array([row.rule for row in rows]),
        "lambdas": np.array([row.lam for row in rows]),
        "columns": np.array([*columns, *AREAS]),
        "values": np.column_stack([values, np.array([areas for areas, _ in judged])]),
        **dict(zip(CURVES, np.stack([curves for _, curves in judged], axis=1), strict=True)),
        "maps": np.array([row.label for row in kept]),
        "depth": np.stack([row.found.depth for row in kept]),
        "confidence": np.stack([row.found.confidence_or_none for row in kept]),
        "truth": scene.reference.truth,
        "intrinsics": scene.reference.intrinsics,
        "unit": np.array(scene.unit),
    }


def fused_rows(scene: Scene, params: Params, lambdas: Mapping[str, float], progress: Progress) -> list[Row]:
    """The maps that are given, then every method by the automatic lambda and by the tuned one."""
    tasks: list[tuple[Variant, str, float | None]] = []
    for variant in params.variants:
        if variant.is_regularised:
            tasks.append((variant, "automatic", None))
            tasks += [(variant, "tuned", lambdas[variant.label])] if variant.label in lambdas else []
    rows: list[Row] = []
    for done, (variant, rule, lam) in enumerate(tasks or [(Variant("median", None), "none", None)], start=1):
        fused = scene.fuse(variant, params.fusion, lam)
        if not rows:
            rows += [Row(name, "none", float("nan"), Judged(depth)) for name, depth in given(scene, fused).items()]
        if rule != "none":
            rows.append(Row(variant.label, rule, float(fused.lam), Judged.of(fused)))
        progress(done / max(len(tasks), 1), variant.label)
    return rows


def given(scene: Scene, fused: Any) -> dict[str, np.ndarray]:
    """The maps named GIVEN."""
    return dict(zip(GIVEN, (scene.reference.depth, fused.mean, fused.median), strict=True))


def kept_labels(params: Params) -> set[str]:
    """Labels of the rows whose maps are kept; what is given always is."""
    return {*GIVEN, *(variant.label for text in params.keep for variant in parse(text))}


def sparsified(row: Row, rows: list[Row], reference: View) -> tuple[list[float], np.ndarray]:
    """AREAS of a row, and its CURVES (4, k): mean error of the pixels kept, in mean errors. NaN without confidence.

    On the pixels that all rows have, as the other measures.
    """
    import numpy as np

    from ipcli.models.fusion.confidence import view_angle
    from ipcli.models.fusion.metrics import ause
    from ipcli.report.fusion.accuracy import sparsification

    found = row.found
    if found.confidence is None:
        return [float("nan")] * len(AREAS), np.full((len(CURVES), POINTS), np.nan)
    common = np.isfinite(reference.truth) & np.isfinite([other.found.depth for other in rows]).all(axis=0)
    error = np.abs(found.depth - reference.truth)[common].astype(np.float64)
    trusted = [
        image[common] for image in (found.confidence, -found.uncertainty, view_angle(found.depth, reference.intrinsics))
    ]
    curves = [
        np.interp(shares(), *sparsification(error, key, POINTS)) / error.mean()
        for key in (*(-t for t in trusted), error)
    ]
    return [ause(t, error) for t in trusted], np.stack(curves)


def shares() -> np.ndarray:
    """The shares of pixels, in %, at which sparsification curves are kept."""
    import numpy as np

    return np.linspace(100 / POINTS, 100, POINTS)
