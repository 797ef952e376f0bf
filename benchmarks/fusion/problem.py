"""The problem all solvers are given, TGV2(x) + lambda sum_k |x - d_k|, and the one energy they are judged by."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.fusion import scene
from ipcli.inverse.regularize.operators import gradient, symmetrised_gradient
from ipcli.inverse.regularize.parameters import Regulariser
from ipcli.measurements.views import View
from ipcli.models.fusion.parameters import Fusion

LAMBDA = 0.3  # for all solvers; what `fuse-depth` takes for eleven observations a pixel, to one figure


@dataclass(frozen=True, eq=False)
class TgvProblem:
    """In units of the noise, as `fuse-depth` poses it with an even confidence."""

    layers: np.ndarray  # (K, h, w) float32, NaN = no observation
    lam: float = LAMBDA
    regulariser: Regulariser = Fusion().regulariser

    @property
    def shape(self) -> tuple[int, int]:
        """(h, w)."""
        return self.layers.shape[1:]

    def start(self) -> np.ndarray:
        """Where every solver starts (h, w): the median, that of the whole image where there is no observation."""
        from ipcli.inverse.regularize.fidelity import Observations
        from ipcli.models.fusion.pyramid import filled_median

        return filled_median(Observations.of(list(self.layers)))

    def crop(self, size: int) -> TgvProblem:
        """The middle of it, at most `size` pixels on a side."""
        rows, columns = (slice(max((n - size) // 2, 0), (n + size) // 2) for n in self.shape)
        return TgvProblem(np.ascontiguousarray(self.layers[:, rows, columns]), self.lam, self.regulariser)

    def energy(self, x: np.ndarray, v: np.ndarray) -> float:
        """alpha1 |grad x - v| + alpha0 |E v| + lambda sum_k |x - d_k| in double precision, by plain NumPy."""
        x, v = x.astype(np.float64), v.astype(np.float64)
        e = symmetrised_gradient(v)
        slope = np.sqrt(((gradient(x) - within(v)) ** 2).sum(axis=0)).sum()
        curvature = np.sqrt(e[0] ** 2 + e[1] ** 2 + 2 * e[2] ** 2).sum()
        data = sum(float(np.nansum(np.abs(x - layer))) for layer in self.layers)
        return float(self.regulariser.alpha1 * slope + self.regulariser.alpha0 * curvature + self.lam * data)

    def save(self, path: Path) -> Path:
        """For the processes that solve it."""
        np.savez(path, layers=self.layers, lam=self.lam)
        return path

    @classmethod
    def load(cls, path: Path) -> TgvProblem:
        """What `save` wrote."""
        with np.load(path) as arrays:
            return cls(arrays["layers"], float(arrays["lam"]))


def pose(views: list[View], reference: View, *, inverse: bool) -> TgvProblem:
    """The problem of fusing these views."""
    from ipcli.models.fusion.observations import measure
    from ipcli.models.fusion.reprojection import reproject_all

    layers = reproject_all(views, reference).depth
    return TgvProblem(measure(layers, inverse=inverse).normalise(layers))


def within(v: np.ndarray) -> np.ndarray:
    """Slopes (2, h, w) where the gradient exists, 0 in the last column and row: there the model has no grad x - v."""
    v = v.copy()
    v[0, :, -1] = v[1, -1] = 0
    return v


@dataclass(frozen=True, eq=False)
class FusionScene:
    """Views to fuse, one of them the reference."""

    views: list[View]
    reference: View
    inverse: bool  # fuse in inverse depth
    name: str


def open_scene(
    views: str | None = None,
    reference: str | None = None,
    count: int = 11,
    shape: tuple[int, int] = (480, 640),
    seed: int = 0,
) -> FusionScene:
    """`count` views of a `views` artefact around a reference, the middle one if not given; without one, generated from
    the seed.
    """
    if views is None:
        h, w = shape
        made = scene.views(count, (h, w), seed)
        return FusionScene(made, made[count // 2], False, f"generated, {w} x {h}, K = {count}, seed {seed}")
    from ipcli.io.views import layouts
    from ipcli.measurements.names import window

    sequence = layouts.open_views(Path(views))
    reference = reference or sequence.names[(len(sequence.names) - 1) // 2]
    loaded = {name: sequence.load(name) for name in window(sequence.names, reference, count)}
    h, w = loaded[reference].depth.shape
    name = f"{Path(views).name}, reference {reference}, {w} x {h}, K = {len(loaded)}"
    return FusionScene(list(loaded.values()), loaded[reference], sequence.measured == "disparity", name)
