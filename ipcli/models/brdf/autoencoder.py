"""The look of a material as sparse codes of its patches: a stacked sparse autoencoder (thesis 7.4.1).

A layer codes patches x as h = sigmoid(W x + b) and reads them back as V h + c. It is learnt by

    1/(2 m) sum |V h + c - x|^2 + beta sum_k KL(rho || mean h_k) + lambda (|W|_1 + |V|_1)

with OWL-QN; the next layer codes the codes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipcli.inverse.regularize.owl_qn import minimise
from ipcli.models.brdf.parameters import Coding

LEAST = 1e-4  # mean activation that the divergence of sparsity is held to


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

    def error(self, patches: np.ndarray) -> np.ndarray:
        """Mean squared error (m,) of the patches that are read back, in variances of those it was learnt from."""
        h = self.code(patches)
        for layer in reversed(self.layers):
            h = layer.read(h)
        return (((patches - self.mean) / self.spread - h) ** 2).mean(axis=1)


def loss(vector: np.ndarray, x: np.ndarray, units: int, params: Coding) -> tuple[float, np.ndarray]:
    """The smooth part of the loss of a layer of inputs (m, d), and its gradient."""
    layer, m = Layer.of(vector, x.shape[1], units), len(x)
    h = layer.code(x)
    off = layer.read(h) - x
    mean = h.mean(axis=0)
    use, rho = np.clip(mean, LEAST, 1 - LEAST), params.activation
    value = (off**2).sum() / (2 * m)
    value += params.sparsity * (rho * np.log(rho / use) + (1 - rho) * np.log((1 - rho) / (1 - use))).sum()
    pull = np.where(mean == use, params.sparsity * ((1 - rho) / (1 - use) - rho / use), 0.0)
    inner = (off @ layer.back.T + pull) / m * h * (1 - h)
    parts = Layer(x.T @ inner, inner.sum(axis=0), h.T @ off / m, off.sum(axis=0) / m)
    return float(value), parts.vector()


def learn(patches: np.ndarray, params: Coding, rng: np.random.Generator) -> Coder:
    """Learn a coder of patches (m, d), layer by layer."""
    mean, spread = patches.mean(axis=0), max(float(patches.std()), 1e-9)
    x, layers = (patches - mean) / spread, []
    for units in params.units:
        layers.append(_layer(x, units, params, rng))
        x = layers[-1].code(x)
    return Coder(mean, spread, tuple(layers))


def _layer(x: np.ndarray, units: int, params: Coding, rng: np.random.Generator) -> Layer:
    inputs = x.shape[1]
    reach = np.sqrt(6 / (inputs + units))
    start = Layer(
        rng.uniform(-reach, reach, (inputs, units)),
        np.full(units, np.log(params.activation / (1 - params.activation))),
        rng.uniform(-reach, reach, (units, inputs)),
        x.mean(axis=0),
    )
    ones, free = np.full(inputs * units, params.l1), np.zeros(units)
    l1 = np.concatenate([ones, free, ones, np.zeros(inputs)])
    return Layer.of(minimise(lambda v: loss(v, x, units, params), start.vector(), l1, params.iterations), inputs, units)


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
