"""A scene whose truth is known, fused by one method after another: which errors, and at which lambda the least."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ipcli.errors import ParameterError, nearest
from ipcli.measurements.accuracy import mean_over_scenes
from ipcli.measurements.views import View
from ipcli.models.fusion.fuse import Fused, fuse
from ipcli.models.fusion.metrics import compare
from ipcli.models.fusion.parameters import Fusion, Variant
from ipcli.progress import Progress, silent

INITIAL = ("reference", "mean", "median")  # maps a fusion starts from: no lambda, and the same for every method


@dataclass(frozen=True, eq=False)
class EstimatedMap:
    """A depth map to be held against the truth, and what its method says of it besides."""

    depth: np.ndarray  # (h, w), NaN where nothing was observed
    normals: np.ndarray | None = None  # (h, w, 3), if not those of the depth
    confidence: np.ndarray | None = None  # (h, w)
    uncertainty: np.ndarray | None = None  # (h, w)
    filled: np.ndarray | None = None  # (h, w) the depth with what stands in its holes, if the method has a say there

    @classmethod
    def of(cls, fused: Fused) -> EstimatedMap:
        """The fused map, without depth where nothing was observed."""
        depth = np.where(fused.observations > 0, fused.depth, np.nan).astype(np.float32)
        return cls(depth, fused.normals, fused.confidence, fused.uncertainty, fused.depth)

    @property
    def confidence_or_zero(self) -> np.ndarray:
        """The confidence (h, w), 0 everywhere if there is none."""
        return np.zeros(self.depth.shape, np.float32) if self.confidence is None else self.confidence


@dataclass(frozen=True, eq=False)
class Scene:
    """Views in memory, the one to fuse into, the true depth (h, w) there, and the quantity to fuse."""

    views: Sequence[View]
    reference: View
    truth: np.ndarray
    inverse: bool
    baseline_focal: float | None
    unit: str

    def fuse(self, variant: Variant, fusion: Fusion, lam: float | None = None) -> Fused:
        """The fused map of one method; the automatic lambda if none is given."""
        return fuse(self.views, self.reference, variant.settings(fusion, lam), inverse=self.inverse)

    def errors(self, maps: Mapping[str, EstimatedMap]) -> tuple[list[str], np.ndarray]:
        """Columns and rows of the error measures of maps, all taken on the pixels that every one of them has."""
        depths = {name: one.depth for name, one in maps.items()}
        own = {name: one.normals for name, one in maps.items() if one.normals is not None}
        filled = {name: one.filled for name, one in maps.items() if one.filled is not None}
        return compare(depths, self.truth, self.reference.intrinsics, self.baseline_focal, own, filled)


@dataclass(frozen=True, eq=False)
class Trial:
    """One method tried at one lambda, and the map that it found."""

    label: str
    rule: str  # "none", "automatic" or "tuned": where lambda came from
    lam: float  # NaN for none
    map: EstimatedMap


def run_trials(
    scene: Scene,
    variants: Sequence[Variant],
    fusion: Fusion,
    tuned: Mapping[str, float],
    progress: Progress = silent,
) -> list[Trial]:
    """The INITIAL maps, then every regularised method at the automatic lambda and, by its label, at the tuned one."""
    tasks: list[tuple[Variant, str, float | None]] = []
    for variant in variants:
        if variant.is_regularised:
            tasks.append((variant, "automatic", None))
            tasks += [(variant, "tuned", tuned[variant.label])] if variant.label in tuned else []
    trials: list[Trial] = []
    for done, (variant, rule, lam) in enumerate(tasks or [(Variant("median", None), "none", None)], start=1):
        fused = scene.fuse(variant, fusion, lam)
        if not trials:
            initial = zip(INITIAL, (scene.reference.depth, fused.mean, fused.median), strict=True)
            trials += [Trial(name, "none", float("nan"), EstimatedMap(depth)) for name, depth in initial]
        if rule != "none":
            trials.append(Trial(variant.label, rule, float(fused.lam), EstimatedMap.of(fused)))
        progress(done / max(len(tasks), 1), variant.label)
    return trials


def sweep_lambdas(
    scene: Scene, variants: Sequence[Variant], fusion: Fusion, lambdas: Sequence[float]
) -> dict[str, np.ndarray]:
    """Errors of the m regularised methods at the automatic lambda (m, c) and at each of n given ones (m, n, c).

    Keys: `columns` (c,), `automatic_lambda` (m,), `automatic` and `values`. The errors of a method are taken on the
    pixels that all its maps have.
    """
    columns: list[str] = []
    automatic_lambda, automatic, values = [], [], []
    for variant in variants:
        if variant.is_regularised:
            fused = [scene.fuse(variant, fusion, lam) for lam in (None, *lambdas)]
            columns, rows = scene.errors({str(index): EstimatedMap.of(one) for index, one in enumerate(fused)})
            automatic_lambda.append(float(fused[0].lam))
            automatic.append(rows[0])
            values.append(rows[1:])
    return {
        "columns": np.array(columns),
        "automatic_lambda": np.array(automatic_lambda),
        "automatic": np.stack(automatic),
        "values": np.stack(values),
    }


def best_lambdas(values: np.ndarray, columns: Sequence[str], measure: str, lambdas: np.ndarray) -> np.ndarray:
    """The lambda (m,) at which the mean over the scenes of a measure is least, of errors (s, m, n, c) at n lambdas.

    ParameterError for a measure that is no column.
    """
    names = [str(column) for column in columns]
    if measure not in names:
        raise ParameterError(f"no measure '{measure}'{nearest(measure, names)}")
    return lambdas[mean_over_scenes(values, names)[..., names.index(measure)].argmin(axis=1)]
