"""The observations of a fusion in the quantity whose noise is homogeneous, measured in units of that noise.

TGV with absolute deviations does not care about units, but the confidence, its prior, Huber's width and the step sizes
do; in units of the noise a scene in millimetres gives the same picture as the same scene in metres.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipcli.errors import NoSolution
from ipcli.inverse.regularize.fidelity import Observations

MAD_TO_SIGMA = 1.4826  # of a normal distribution; for a Laplace distribution of scale b the result is 1.03 b
# Of K = 2, 3, ... values, what their median absolute deviation from their own median, pooled over many such samples,
# falls short
# by (an odd K has a deviation of 0); simulated, midway between Laplace and normal noise. K / (K - 1) for more.
SMALL_SAMPLE = np.array([1.31, 2.03, 1.32, 1.32, 1.235, 1.185, 1.165])
SAMPLE = 50_000  # pixels, in whole rows, are enough to measure by
SMALLEST_NOISE = 1e-6  # of the median value: what float32 can tell apart, for data without noise


@dataclass(frozen=True)
class Units:
    """z <-> x = (q - centre) / scale, where q is the depth z or its inverse."""

    inverse: bool
    centre: float
    scale: float
    floor: float  # least q that is turned into a depth: in-painted inverse depths may not cross zero

    def normalise(self, depth: np.ndarray) -> np.ndarray:
        """Depth, NaN or inf where there is none, to x, NaN there; float32."""
        depth = np.where(np.isfinite(depth), depth, np.nan)
        q = 1 / depth if self.inverse else depth
        return ((q - self.centre) / self.scale).astype(np.float32)

    def slopes(self, x: np.ndarray) -> np.ndarray:
        """|dz / dx| (h, w) float32: what a difference in x is worth in depth, at x."""
        q = np.maximum(x.astype(np.float64) * self.scale + self.centre, self.floor)
        return (self.scale / q**2 if self.inverse else np.full(x.shape, self.scale)).astype(np.float32)

    def depth(self, x: np.ndarray) -> np.ndarray:
        """x to depth, float32."""
        q = np.maximum(x.astype(np.float64) * self.scale + self.centre, self.floor)
        return (1 / q if self.inverse else q).astype(np.float32)


@dataclass(frozen=True, eq=False)
class Normalised:
    """Depth layers (K, h, w), NaN or inf where there is none, in these units: one at a time, when it is asked for.

    With weights (K, h, w), there is none where the weight is 0.
    """

    units: Units
    depth: np.ndarray
    weights: np.ndarray | None = None

    @property
    def shape(self) -> tuple[int, int, int]:
        """(K, h, w)."""
        return self.depth.shape

    def __len__(self) -> int:
        return len(self.depth)

    def __getitem__(self, k: int) -> np.ndarray:
        """Layer k (h, w) float32, NaN where there is none."""
        depth = self.depth[k] if self.weights is None else np.where(self.weights[k] > 0, self.depth[k], np.nan)
        return self.units.normalise(depth)


def measure(layers: np.ndarray, weights: np.ndarray | None = None, *, inverse: bool) -> Units:
    """Units of depth layers (K, h, w), inf = nothing; with weights (K, h, w), weight 0 = nothing too.

    NoSolution if no pixel of the reference was observed.
    """
    lowest = floor(layers, weights, inverse=inverse)
    step = max(layers[0].size // SAMPLE, 1)
    sample = _seen(layers[:, ::step], None if weights is None else weights[:, ::step])
    sample = sample if np.isfinite(sample).any() else _seen(layers, weights)
    q = 1 / sample if inverse else sample
    centre = float(np.nanmedian(q))
    return Units(inverse, centre, max(noise_scale(q), SMALLEST_NOISE * abs(centre)), lowest)


def floor(layers: np.ndarray, weights: np.ndarray | None = None, *, inverse: bool) -> float:
    """Half the least depth, or inverse depth, of layers as those of `measure`; NoSolution if there is none."""
    least = min(_extreme(layers[k], None if weights is None else weights[k], inverse) for k in range(len(layers)))
    if not np.isfinite(least):
        raise NoSolution(
            "no view has a valid depth inside the reference view: check the poses, their direction and the unit"
        )
    return least / 2


def _seen(layers: np.ndarray, weights: np.ndarray | None) -> np.ndarray:
    """Layers with NaN where there is nothing."""
    seen = np.isfinite(layers) if weights is None else np.isfinite(layers) & (weights > 0)
    return np.where(seen, layers, np.nan)


def _extreme(layer: np.ndarray, weights: np.ndarray | None, inverse: bool) -> float:
    """The least depth, or the least inverse depth, of a layer; infinite if it has none."""
    seen = np.isfinite(layer) if weights is None else np.isfinite(layer) & (weights > 0)
    if not inverse:
        return float(layer.min(where=seen, initial=np.inf))
    furthest = float(layer.max(where=seen, initial=0))
    return 1 / furthest if furthest else np.inf


def noise_scale(q: np.ndarray) -> float:
    """Robust standard deviation of layers (K, h, w), NaN = nothing, about the median of their pixel.

    Of the pixels with at least two observations, each corrected for the share of the noise that its median took up;
    with fewer than 1 % of such pixels, of the second differences along rows of the single observations.
    """
    observations = Observations.of(q)
    several = observations.count >= 2
    if several.mean() < 0.01:
        second = np.diff(q, n=2, axis=2)
        return MAD_TO_SIGMA * float(np.nanmedian(np.abs(second))) / np.sqrt(6) if np.isfinite(second).any() else 0.0
    count = observations.count[several]
    residual = np.abs(q[:, several] - observations.median()[several]) * _shortfall(count)
    return MAD_TO_SIGMA * float(np.nanmedian(residual))


def _shortfall(count: np.ndarray) -> np.ndarray:
    few = SMALL_SAMPLE[np.minimum(count.astype(np.intp) - 2, len(SMALL_SAMPLE) - 1)]
    return np.where(count < 2 + len(SMALL_SAMPLE), few, count / (count - 1))
