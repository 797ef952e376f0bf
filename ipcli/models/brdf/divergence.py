"""How far the patches of a picture are from a material in the codes of its autoencoder: Itakura-Saito (thesis 7.2).

Printed is D(s, h) = sum_k s_k / h_k - log(s_k / h_k) - 1 with s the arithmetic mean of the codes h of the material. But
the arithmetic mean is what minimises sum_i D(h_i, s), the other order, and that one does not blow up where a sparse
unit is silent: it is the default.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipcli.models.brdf.autoencoder import Batches, Coder, moments

FLOOR = 1e-4
ORDERS = ("fixed", "printed")


def itakura_saito(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Mean (...) over the last axis of a / b - log(a / b) - 1; both are held to `FLOOR`."""
    ratio = np.maximum(a, FLOOR) / np.maximum(b, FLOOR)
    return (ratio - np.log(ratio) - 1).mean(axis=-1)


@dataclass(frozen=True, eq=False)
class Look:
    """A material: its coder, the mean of its codes, and how far its own held-out pictures are from it."""

    coder: Coder
    mean: np.ndarray  # (k,)
    own: dict[str, tuple[float, float]]  # mean and spread of each measure on held-out pictures

    def far(self, patches: np.ndarray, measure: str) -> float:
        """How far patches (m, d) are: `fixed`, `printed` or `error`, in spreads from the material's own."""
        mean, spread = self.own[measure]
        return (raw(self.coder, self.mean, patches, measure) - mean) / spread


def raw(coder: Coder, mean: np.ndarray, patches: np.ndarray, measure: str) -> float:
    """The measure before it is standardised: a divergence in either order, or the log of the error of reading back."""
    if measure == "error":
        return float(np.log(np.maximum(coder.error(patches).mean(), 1e-12)))
    codes = coder.code(patches)
    return float((itakura_saito(codes, mean) if measure == "fixed" else itakura_saito(mean, codes)).mean())


def look(coder: Coder, taught: Batches, held: list[np.ndarray]) -> Look:
    """A material by the patches its coder was taught on, in batches, and those (m, d) of held-out pictures of it."""
    mean = np.maximum(moments(coder.coded(taught))[0], FLOOR)
    own = {}
    for measure in (*ORDERS, "error"):
        values = np.array([raw(coder, mean, patches, measure) for patches in held])
        own[measure] = (float(values.mean()), max(float(values.std()), 1e-6))
    return Look(coder, mean, own)
