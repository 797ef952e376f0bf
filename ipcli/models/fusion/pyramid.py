"""A coarse-to-fine start for the fusion: what is far apart, such as the two sides of a hole, meets on a coarse grid."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ipcli.inverse.regularize import tgv
from ipcli.inverse.regularize.fidelity import AbsoluteDeviations, ImageSequence, Observations
from ipcli.inverse.regularize.parameters import Regulariser, Solver
from ipcli.models.fusion.observations import Normalised

SMALLEST = 24  # pixels along the shorter side of the coarsest level


def start(
    layers: np.ndarray | Normalised,
    lam: float,
    regulariser: Regulariser | tgv.PixelwiseRegulariser,
    solver: Solver,
    levels: int,
) -> tgv.Iterate:
    """An iterate (h, w) near the minimiser of TGV + lambda sum_k |x - d_k| for layers (K, h, w), NaN = nothing.

    Solves at half the size and enlarges the solution; the coarsest level starts at the median. One pixel of half the
    size stands for four and is twice as wide, so half the energy of the image is TGV with alpha0 halved plus twice
    lambda: the duals p then carry over as they are and q doubled.
    """
    shape = layers.shape[1:]
    if levels == 1 or min(shape) < 2 * SMALLEST:
        return tgv.Iterate.at(filled_median(Observations.of(layers)))
    half = halved(layers)
    regulariser_half = _halved_regulariser(regulariser)
    coarse = start(half, 2 * lam, regulariser_half, solver, levels - 1)
    scale = np.full(half.shape[1:], 2 * lam, np.float32)
    fidelity = AbsoluteDeviations(Observations.of(half), scale)
    coarse.advance(fidelity, regulariser_half, solver, [solver.relaxation] * solver.level_iterations)
    return _enlarged(coarse, shape)


def filled_median(data: Observations) -> np.ndarray:
    """Median of the observations (h, w), the median of all of it where there is none."""
    median = data.median()
    return np.where(data.count > 0, median, np.nanmedian(median)).astype(np.float32)


def _halved_regulariser(
    regulariser: Regulariser | tgv.PixelwiseRegulariser,
) -> Regulariser | tgv.PixelwiseRegulariser:
    alpha0 = regulariser.alpha0 / 2
    if isinstance(regulariser, tgv.PixelwiseRegulariser):
        return replace(regulariser, alpha1=_halved(regulariser.alpha1), alpha0=alpha0)
    return replace(regulariser, alpha0=alpha0)


def halved(layers: ImageSequence) -> np.ndarray:
    """K layers (h, w) at half the size (K, h, w), the last odd row or column dropped: means of the up to four
    observations.
    """
    return np.stack([_halved(layers[k]) for k in range(len(layers))])


def _halved(layer: np.ndarray) -> np.ndarray:
    h, w = layer.shape
    blocks = layer[: h // 2 * 2, : w // 2 * 2].reshape(h // 2, 2, w // 2, 2)
    quarters = np.stack([blocks[:, i, :, j] for i in (0, 1) for j in (0, 1)])
    present = np.isfinite(quarters)
    with np.errstate(invalid="ignore"):
        return np.where(present, quarters, 0).sum(axis=0) / present.sum(axis=0, dtype=np.float32)


def _enlarged(coarse: tgv.Iterate, shape: tuple[int, int]) -> tgv.Iterate:
    import cv2

    def enlarge(planes: np.ndarray, factor: float) -> np.ndarray:
        return np.float32(factor) * np.stack(
            [cv2.resize(plane, shape[::-1], interpolation=cv2.INTER_LINEAR) for plane in planes]
        )

    p, q = enlarge(coarse.p, 1), enlarge(coarse.q, 2)
    p[0, :, -1] = p[1, -1] = q[0, :, 0] = q[1, 0] = q[2, 0] = q[2, :, 0] = 0  # differences that do not exist
    return tgv.Iterate(enlarge(coarse.x[None], 1)[0], enlarge(coarse.v, 0.5), p, q)
