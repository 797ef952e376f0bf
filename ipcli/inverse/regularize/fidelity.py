"""Data terms scale * sum_k w_k rho(x - d_k) of K observations a pixel, for rho = |r|, r^2 / 2 or Huber's, missing ones
left out.

All arrays are float32 and C-contiguous. A new data term is a class with the methods of `Fidelity`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ipcli import threads
from ipcli.kernels import fidelity as kernels
from ipcli.kernels import iteration

Step = float | np.floating


class ImageSequence(Protocol):
    """K images (h, w) by number, each made when it is asked for; an array (K, h, w) is one too."""

    def __len__(self) -> int:
        """K."""

    def __getitem__(self, k: int, /) -> np.ndarray:
        """Image k (h, w)."""


class Fidelity(Protocol):
    """What `tgv.minimise` asks of a data term f on images (h, w), a sum over pixels."""

    def rows(self, top: int, bottom: int) -> Fidelity:
        """The same data term on these rows of the image."""

    def prox(self, x: np.ndarray, x_bar: np.ndarray, y: np.ndarray, tau: Step, rho: Step) -> None:
        """With z = prox_{tau f}(y): x_bar <- 2 z - x, then x <- x + rho (z - x), in place."""

    def l1_terms(self) -> tuple[np.ndarray, np.ndarray | None, np.ndarray, np.ndarray] | None:
        """(stack, weights, total, scale) where f is sum_i scale_i sum_k w_ik |x_i - d_ik|, whose iterations have a
        kernel, or None.
        """

    def energy(self, x: np.ndarray) -> np.ndarray:
        """f(x), summed over each row: (h,) float64."""

    def lowest(self, tilt: np.ndarray, low: float, high: float, x: np.ndarray) -> np.ndarray:
        """Per row (h,) a lower bound of min f(z) + <tilt, z> over low <= z <= high, exact if it can be; x is the
        present image.
        """


@dataclass(frozen=True, eq=False)
class Observations:
    """K sorted observations a pixel; see `ipcli.kernels.fidelity` for the layout."""

    stack: np.ndarray  # (h, K, w) ascending, +inf where there is none
    weights: np.ndarray | None  # (h, K, w), 0 where there is none; None: all 1
    total: np.ndarray  # (h, w) sum of the weights
    count: np.ndarray  # (h, w) number of observations

    @classmethod
    def of(cls, layers: ImageSequence, weights: ImageSequence | None = None) -> Observations:
        """Sort K layers (h, w), NaN or inf where there is no observation; K weights (h, w) >= 0, where 0 means none
        too.

        The layers are asked for one by one, so that they need not all be in memory beside the stack.
        """
        stack, sorted_weights = as_stack(layers), None if weights is None else as_stack(weights)

        def sort(rows: slice) -> np.ndarray:
            if sorted_weights is None:
                kernels.sort_stack(stack[rows])
            else:
                kernels.sort_weighted_stack(stack[rows], sorted_weights[rows])
            return kernels.count_observations(stack[rows])

        blocks = [slice(top, bottom) for top, bottom in threads.blocks(len(stack))]
        count = np.concatenate(threads.each(sort, blocks))
        return cls(stack, sorted_weights, count if sorted_weights is None else sorted_weights.sum(axis=1), count)

    def rows(self, top: int, bottom: int) -> Observations:
        """The observations of these rows of the image."""
        weights = None if self.weights is None else self.weights[top:bottom]
        return Observations(self.stack[top:bottom], weights, self.total[top:bottom], self.count[top:bottom])

    def reweighted(self, weights: np.ndarray) -> Observations:
        """The same observations with their weights times these (h, K, w) float32, in the order of the stack, 0 where
        there is none.
        """
        weights = weights if self.weights is None else self.weights * weights
        return Observations(self.stack, weights, weights.sum(axis=1), self.count)

    def deviations(self, x: np.ndarray) -> np.ndarray:
        """w_k |x - d_k| of an image (h, w), each by itself: (h, K, w) float32, 0 where there is none."""
        apart = np.abs(x[:, None] - self.stack)
        apart[~np.isfinite(apart)] = 0
        return apart if self.weights is None else apart * self.weights

    @property
    def bounds(self) -> tuple[float, float]:
        """Least and greatest observation."""
        greatest = (layer.max(where=np.isfinite(layer), initial=-np.inf) for layer in np.moveaxis(self.stack, 1, 0))
        return float(self.stack[:, 0].min()), float(max(greatest))

    def median(self) -> np.ndarray:
        """Weighted median (h, w), the middle of the two when the weights tie; NaN where nothing was observed."""
        below = self.half_weight_index(strict=False)
        above = self.half_weight_index(strict=True)
        low, high = (np.take_along_axis(self.stack, index[:, None], axis=1)[:, 0] for index in (below, above))
        return np.where(self.count > 0, (low + high) / 2, np.nan).astype(np.float32)

    def half_weight_index(self, *, strict: bool) -> np.ndarray:
        """Index (h, w) of the first observation up to which the weight reaches (strictly: exceeds) half the total."""
        if self.weights is None:
            index = self.count // 2 if strict else (self.count - 1) // 2
            return np.clip(index, 0, self.stack.shape[1] - 1).astype(np.intp)
        reached = np.cumsum(self.weights, axis=1, dtype=np.float64)
        half = reached[:, -1:] / 2
        return np.argmax(reached > half if strict else reached >= half, axis=1)

    def mean(self) -> np.ndarray:
        """Weighted mean (h, w); NaN where nothing was observed."""
        total = np.zeros(self.count.shape, np.float32)
        for k in range(self.stack.shape[1]):
            layer = self.stack[:, k]
            values = np.where(np.isfinite(layer), layer, np.float32(0))
            total += values if self.weights is None else values * self.weights[:, k]
        with np.errstate(invalid="ignore"):
            return total / self.total


def as_stack(layers: ImageSequence) -> np.ndarray:
    """Copy K layers (h, w) into a stack (h, K, w) float32."""
    layer = layers[0]
    stack = np.empty((layer.shape[0], len(layers), layer.shape[1]), np.float32)
    stack[:, 0] = layer
    for k in range(1, len(layers)):
        stack[:, k] = layers[k]
    return stack


@dataclass(frozen=True, eq=False)
class AbsoluteDeviations:
    """sum_i scale_i sum_k w_ik huber(x_i - d_ik); width 0, the default, means |x_i - d_ik|."""

    data: Observations
    scale: np.ndarray  # (h, w) float32
    width: float = 0.0

    @property
    def total(self) -> np.ndarray:
        """Sum of the weights (h, w)."""
        return self.data.total

    def rows(self, top, bottom):
        return AbsoluteDeviations(self.data.rows(top, bottom), self.scale[top:bottom], self.width)

    def prox(self, x, x_bar, y, tau, rho):
        d, tau, rho = self.data, np.float32(tau), np.float32(rho)
        if self.width:
            width = np.float32(self.width)
            kernels.prox_huber(x, x_bar, y, d.stack, d.weights, d.total, d.count, self.scale, width, tau, rho)
        else:
            iteration.prox_l1(x, x_bar, y, d.stack, d.weights, d.total, self.scale, tau, rho)

    def l1_terms(self):
        d = self.data
        return None if self.width else (d.stack, d.weights, d.total, self.scale)

    def deviation(self, x: np.ndarray) -> np.ndarray:
        """sum_k w_k huber(x - d_k), (h, w): the data term without its scale."""
        return kernels.deviation(x, self.data.stack, self.data.weights, np.float32(self.width))

    def energy(self, x):
        return (self.scale * self.deviation(x)).sum(axis=1, dtype=np.float64)

    def lowest(self, tilt, low, high, x):
        d = self.data
        if self.width:
            width = np.float32(self.width)
            return kernels.lowest_huber_rows(tilt, d.stack, d.weights, d.count, self.scale, width, low, high)
        return kernels.lowest_l1_rows(tilt, d.stack, d.weights, d.total, self.scale, low, high)


@dataclass(frozen=True, eq=False)
class SquaredDeviations:
    """sum_i scale_i sum_k w_ik (x_i - d_ik)^2 / 2: the fidelity of Rudin, Osher and Fatemi for several observations."""

    mean: np.ndarray  # (h, w) weighted mean of the observations, any number where there is none
    total: np.ndarray  # (h, w) sum of the weights
    spread: np.ndarray  # (h, w) sum_k w_k (d_k - mean)^2 / 2
    scale: np.ndarray  # (h, w) float32

    @classmethod
    def of(cls, data: Observations, scale: np.ndarray) -> SquaredDeviations:
        mean = np.nan_to_num(data.mean())
        spread = np.zeros_like(mean)
        for k in range(data.stack.shape[1]):
            layer = data.stack[:, k]
            squares = np.where(np.isfinite(layer), layer - mean, 0) ** 2 / 2
            spread += squares if data.weights is None else squares * data.weights[:, k]
        return cls(mean, data.total, spread, scale)

    def rows(self, top, bottom):
        return SquaredDeviations(*(plane[top:bottom] for plane in (self.mean, self.total, self.spread, self.scale)))

    def prox(self, x, x_bar, y, tau, rho):
        kernels.prox_l2(x, x_bar, y, self.mean, self.total, self.scale, np.float32(tau), np.float32(rho))

    def l1_terms(self):
        return None

    def deviation(self, x: np.ndarray) -> np.ndarray:
        """sum_k w_k (x - d_k)^2 / 2, (h, w): the data term without its scale."""
        return self.total * (x - self.mean) ** 2 / 2 + self.spread

    def energy(self, x):
        return (self.scale * self.deviation(x)).sum(axis=1, dtype=np.float64)

    def lowest(self, tilt, low, high, x):
        stiffness = self.scale * self.total
        with np.errstate(divide="ignore", invalid="ignore"):
            z = np.where(stiffness > 0, self.mean - tilt / stiffness, np.where(tilt > 0, low, high))
        z = np.clip(z, low, high).astype(np.float32)
        return self.energy(z) + _products(tilt, z)


@dataclass(frozen=True, eq=False)
class Anchored:
    """Another data term plus |x - anchor|^2 / (2 step): the proximal step of alternating minimisation
    (Algorithm 4.2).
    """

    inner: Fidelity
    anchor: np.ndarray  # (h, w) float32
    step: float

    def rows(self, top, bottom):
        return Anchored(self.inner.rows(top, bottom), self.anchor[top:bottom], self.step)

    def prox(self, x, x_bar, y, tau, rho):
        share = np.float32(self.step / (self.step + tau))
        y *= share
        y += (1 - share) * self.anchor
        self.inner.prox(x, x_bar, y, float(share) * tau, rho)

    def l1_terms(self):
        return None

    def energy(self, x):
        return self.inner.energy(x) + self._distance(x)

    def lowest(self, tilt, low, high, x):
        # Split the tilt so that the square alone is lowest at x: valid for any split, and tight at the solution.
        pull = (self.anchor - x) / np.float32(self.step)
        return self.inner.lowest(tilt - pull, low, high, x) + self._distance(x) + _products(pull, x)

    def _distance(self, x: np.ndarray) -> np.ndarray:
        return _products(x - self.anchor, x - self.anchor) / (2 * self.step)


def _products(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Inner products of the rows, (h,) float64."""
    return np.einsum("ij,ij->i", a, b, dtype=np.float64)
