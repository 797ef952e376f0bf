"""The look of a material as sparse codes of its patches: a stacked sparse autoencoder (thesis 7.4.1).

A layer codes patches x as h = sigmoid(W x + b) and reads them back as V h + c. It is learnt by

    1/(2 m) sum |V h + c - x|^2 + beta sum_k KL(rho || mean h_k) + lambda (|W|_1 + |V|_1)

with OWL-QN; the next layer codes the codes. Patches are taken in batches, all of them at every step: memory holds one
batch, whatever their number. Only the divergence mixes batches, and by mean h_k alone: its gradient is that of mean h
times a factor that is known when all batches have been seen.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from ipcli.inverse.regularize.owl_qn import minimise
from ipcli.models.brdf.parameters import Coding

LEAST = 1e-4  # mean activation that the divergence of sparsity is held to
BATCH = 512  # patches; of some hundred numbers each, these stay in the cache

Batches = Callable[[], Iterator[np.ndarray]]  # (b, d) each, at every call the same from the start


def in_batches(rows: Any, size: int = BATCH) -> Batches:
    """What is sliced by rows (m, d), an array or a file's, `size` rows at a time."""
    return lambda: (np.asarray(rows[start : start + size]) for start in range(0, len(rows), size))


@dataclass(frozen=True, eq=False)
class Layer:
    """One layer: d inputs, k units."""

    weights: np.ndarray  # (d, k)
    bias: np.ndarray  # (k,)
    back: np.ndarray  # (k, d)
    back_bias: np.ndarray  # (d,)

    def code(self, x: np.ndarray) -> np.ndarray:
        """Activations (m, k) in (0, 1) of inputs (m, d)."""
        return 1 / (1 + np.exp(-np.clip(x @ self.weights + self.bias, -40, 40)))

    def read(self, codes: np.ndarray) -> np.ndarray:
        """Inputs (m, d) that codes (m, k) stand for."""
        return codes @ self.back + self.back_bias

    def vector(self) -> np.ndarray:
        """All numbers in one vector."""
        return np.concatenate([part.ravel() for part in (self.weights, self.bias, self.back, self.back_bias)])

    @classmethod
    def of(cls, vector: np.ndarray, inputs: int, units: int) -> Layer:
        """The inverse of `vector`."""
        ends = np.cumsum([inputs * units, units, units * inputs])
        w, b, v, c = np.split(vector, ends)
        return cls(w.reshape(inputs, units), b, v.reshape(units, inputs), c)


@dataclass(frozen=True, eq=False)
class Coder:
    """A stack of layers behind the mean and the spread of the patches."""

    mean: np.ndarray  # (d,)
    spread: float
    layers: tuple[Layer, ...]

    def code(self, patches: np.ndarray) -> np.ndarray:
        """Codes (m, k) of patches (m, d)."""
        h = (patches - self.mean) / self.spread
        for layer in self.layers:
            h = layer.code(h)
        return h

    def coded(self, batches: Batches) -> Batches:
        """The codes of patches that come in batches."""
        return lambda: map(self.code, batches())

    def error(self, patches: np.ndarray) -> np.ndarray:
        """Mean squared error (m,) of the patches that are read back, in variances of those it was learnt from."""
        h = self.code(patches)
        for layer in reversed(self.layers):
            h = layer.read(h)
        return (((patches - self.mean) / self.spread - h) ** 2).mean(axis=1)


def loss(vector: np.ndarray, batches: Batches, units: int, params: Coding) -> tuple[float, np.ndarray]:
    """The smooth part of the loss of a layer of inputs (m, d), and its gradient."""
    m, squares, total, by_mean = 0, 0.0, np.zeros(()), np.zeros(())
    for x in batches():
        layer = Layer.of(vector, x.shape[1], units)
        h = layer.code(x)
        off, steep = layer.read(h), h * (1 - h)
        off -= x
        inner = off @ layer.back.T * steep
        m, squares = m + len(x), squares + float(np.vdot(off, off))
        total = total + Layer(x.T @ inner, inner.sum(axis=0), h.T @ off, off.sum(axis=0)).vector()
        by_mean = by_mean + np.vstack([x.T @ steep, steep.sum(axis=0), h.sum(axis=0)])
    mean = by_mean[-1] / m
    use, rho = np.clip(mean, LEAST, 1 - LEAST), params.activation
    value = squares / (2 * m)
    value += params.sparsity * (rho * np.log(rho / use) + (1 - rho) * np.log((1 - rho) / (1 - use))).sum()
    pull = np.where(mean == use, params.sparsity * ((1 - rho) / (1 - use) - rho / use), 0.0)
    total[: by_mean[:-1].size] += (by_mean[:-1] * pull).ravel()  # weights, then bias, as in `Layer.vector`
    return float(value), total / m


def learn(batches: Batches, params: Coding, rng: np.random.Generator) -> Coder:
    """Learn a coder of patches (m, d) that come in batches, layer by layer."""
    mean, spread = moments(batches)
    coder = Coder(mean, spread, ())
    for units in params.units:
        layer = _layer(coder.coded(batches), units, params, rng)
        coder = Coder(mean, spread, (*coder.layers, layer))
    return coder


def moments(batches: Batches) -> tuple[np.ndarray, float]:
    """Mean (d,) of rows, and the spread of all their numbers."""
    origin = float(next(batches()).mean())  # keeps the digits of the squares
    m, total, squares = 0, np.zeros(()), 0.0
    for x in batches():
        away = x - origin
        m, total, squares = m + len(x), total + away.sum(axis=0), squares + float((away**2).sum())
    mean = total / m
    variance = squares / (m * len(mean)) - float(mean.mean()) ** 2
    return mean + origin, max(float(np.sqrt(max(variance, 0.0))), 1e-9)


def _layer(batches: Batches, units: int, params: Coding, rng: np.random.Generator) -> Layer:
    mean, _ = moments(batches)
    inputs = len(mean)
    reach = np.sqrt(6 / (inputs + units))
    start = Layer(
        rng.uniform(-reach, reach, (inputs, units)),
        np.full(units, np.log(params.activation / (1 - params.activation))),
        rng.uniform(-reach, reach, (units, inputs)),
        mean,
    )
    ones, free = np.full(inputs * units, params.l1), np.zeros(units)
    l1 = np.concatenate([ones, free, ones, np.zeros(inputs)])
    smooth = partial(loss, batches=batches, units=units, params=params)
    return Layer.of(minimise(smooth, start.vector(), l1, params.iterations), inputs, units)


def patches(picture: np.ndarray, mask: np.ndarray, side: int, most: int) -> np.ndarray:
    """Up to `most` patches (m, 3 side^2) of a linear picture (h, w, 3) that lie in its mask whole, evenly over it.

    log(1 + x) of the picture over its mean in the mask, so that highlights do not own the error.
    """
    from scipy.ndimage import minimum_filter

    scaled = np.log1p(np.maximum(picture, 0) / max(float(picture[mask].mean()), 1e-9))
    half = side // 2
    padded = np.pad(mask, side)
    whole = minimum_filter(padded, size=side)[side:-side, side:-side]
    rows, columns = np.nonzero(whole)
    count = min(most, len(rows))
    chosen = np.unique(np.linspace(0, max(len(rows) - 1, 0), count).astype(int))
    found = [
        scaled[r - half : r - half + side, c - half : c - half + side].ravel()
        for r, c in ((rows[i], columns[i]) for i in chosen)
    ]
    return np.array(found).reshape(-1, 3 * side * side)
