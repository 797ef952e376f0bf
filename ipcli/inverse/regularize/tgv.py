"""Total generalised variation of order 2 (order 1: total variation) with any data term: min_x f(x) + TGV_alpha(x).

TGV(x) = min_v alpha1 |grad x - v| + alpha0 |E v| (thesis eq. 2.43; Bredies, Kunisch and Pock 2010). The saddle point of

    f(x) + <grad x - v, p> + <E v, q>,   |p| <= alpha1, |q| <= alpha0 at every pixel,

is found by the over-relaxed primal-dual method (Condat, JOTA 2013), whose half steps are fused kernels, and certified
by a primal-dual gap restricted to a box, which stays finite where there are no data. v is not bounded by the problem:
the certificate holds as long as no solution has a slope steeper than `SLOPE_MARGIN` times the sum of the mean slope of
the iterate and its steepest one in the `NEIGHBOURHOOD` of the pixel.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import numpy as np

from ipcli import threads
from ipcli.inverse.regularize.fidelity import Fidelity
from ipcli.inverse.regularize.operators import NORM
from ipcli.inverse.regularize.parameters import Regulariser, Solver
from ipcli.kernels import iteration
from ipcli.kernels import tgv as kernels

SLOPE_MARGIN = 1.5
NEIGHBOURHOOD = 31  # pixels
BALANCE = 150.0  # step ratio times spread that does best, within a factor of two, on indoor, stereo and generated depth
TOGETHER = 16  # iterations that a block of rows does by itself, with as many rows of its neighbours
AT_ONCE = 8  # of them, in one pass over the rows: few enough that the rows in between stay in the cache


@dataclass(frozen=True, eq=False)
class PixelwiseRegulariser:
    """A regulariser whose first-order term has a weight of its own in each pixel."""

    order: int  # 2: TGV, 1: TV
    alpha1: np.ndarray  # (h, w) float32
    alpha0: float


@dataclass(eq=False)
class Iterate:
    """The point the iteration stands at, warm from one call of `minimise` to the next."""

    x: np.ndarray  # (h, w) float32, the image
    v: np.ndarray  # (2, h, w), its slopes
    p: np.ndarray  # (2, h, w), dual of grad x - v
    q: np.ndarray  # (3, h, w), dual of E v

    @classmethod
    def at(cls, x: np.ndarray) -> Iterate:
        """Start from an image (h, w)."""
        return cls(x.astype(np.float32), *(np.zeros((c, *x.shape), np.float32) for c in (2, 2, 3)))

    def balanced(self, solver: Solver) -> Solver:
        """The solver with its primal weight chosen, if it has none: images of any unit then converge alike."""
        if solver.primal_weight:
            return solver
        low, high = np.percentile(self.x, (2, 98))
        return replace(solver, primal_weight=BALANCE / (float(high - low) or 1.0))

    def advance(
        self,
        fidelity: Fidelity,
        regulariser: Regulariser | PixelwiseRegulariser,
        solver: Solver,
        relaxations: Sequence[float],
    ) -> None:
        """Do one iteration for each of the relaxations, in place.

        What a row becomes depends, an iteration later, on its two neighbours. A block of rows that starts with n more
        rows on each side can therefore do n iterations alone before it needs its neighbours' rows again; the result is
        the same, bit by bit, for any number of blocks.
        """
        solver = self.balanced(solver)
        weights = plane(regulariser.alpha1, self.x.shape)
        pixelwise = PixelwiseRegulariser(regulariser.order, weights, regulariser.alpha0)
        bounds = threads.blocks(self.x.shape[0], least=2 * TOGETHER)
        blocks = threads.each(
            lambda rows: _Block(self, fidelity, *rows, halo=TOGETHER if len(bounds) > 1 else 0), bounds
        )
        for start in range(0, len(relaxations), TOGETHER):
            together = relaxations[start : start + TOGETHER]
            threads.each(partial(_Block.iterate, regulariser=pixelwise, solver=solver, relaxations=together), blocks)
            for above, below in pairwise(blocks):
                above.meet(below)
        threads.each(lambda block: block.return_to(self), blocks)

    @property
    def planes(self) -> tuple[np.ndarray, ...]:
        """All of it as views (c, h, w)."""
        return self.x[None], self.v, self.p, self.q

    def energy(self, fidelity: Fidelity, regulariser: Regulariser | PixelwiseRegulariser) -> float:
        """f(x) + alpha1 |grad x - v| + alpha0 |E v| at the present slopes: an upper bound of f(x) + TGV(x)."""
        data = _by_rows(lambda top, bottom: fidelity.rows(top, bottom).energy(self.x[top:bottom]), self.x)
        return data + value(self.x, self.v, regulariser)

    def bound(
        self, fidelity: Fidelity, regulariser: Regulariser | PixelwiseRegulariser, low: float, high: float
    ) -> float:
        """A lower bound of the minimal energy over images in [low, high]; p and q must be feasible."""
        tilt = np.empty_like(self.x)
        residual = float(kernels.dual_residual_rows(tilt, self.p, self.q, steepest_slopes(self.v)).sum())
        data = _by_rows(
            lambda top, bottom: fidelity.rows(top, bottom).lowest(tilt[top:bottom], low, high, self.x[top:bottom]),
            self.x,
        )
        return data - residual


class _Block:
    """Rows top to bottom of an iterate, and `halo` more on each side that go stale by one row an iteration."""

    def __init__(self, whole: Iterate, fidelity: Fidelity, top: int, bottom: int, halo: int):
        self.halo, self.top, self.bottom = halo, top, bottom
        self.first, last = max(top - halo, 0), min(bottom + halo, whole.x.shape[0])
        rows = [planes[:, self.first : last] for planes in whole.planes]
        x, *duals = (planes.copy() if halo else planes for planes in rows)
        self.part = Iterate(x[0], *duals)
        self.fidelity = fidelity.rows(self.first, last) if halo else fidelity
        self.y, self.x_bar, self.v_bar = np.empty_like(x[0]), np.empty_like(x[0]), np.empty_like(duals[0])

    def iterate(self, regulariser: PixelwiseRegulariser, solver: Solver, relaxations: Sequence[float]) -> None:
        """Do an iteration for each of the relaxations, at the steps tau = 1 / (|K| weight) and sigma = weight / |K|."""
        tau, sigma = np.float32(0.99 / (NORM * solver.primal_weight)), np.float32(0.99 * solver.primal_weight / NORM)
        tau_v = tau if regulariser.order == 2 else np.float32(0)  # order 1: v never leaves zero
        x, v, p, q = self.part.x, self.part.v, self.part.p, self.part.q
        alpha1, alpha0 = regulariser.alpha1[self.first : self.first + len(x)], np.float32(regulariser.alpha0)
        l1 = self.fidelity.l1_terms()
        if l1 is not None:
            for start in range(0, len(relaxations), AT_ONCE):
                rhos = np.array(relaxations[start : start + AT_ONCE], np.float32)
                iteration.sweep_l1(x, v, p, q, *l1, (tau, tau_v, sigma), alpha1, alpha0, rhos)
            return
        for rho in map(np.float32, relaxations):
            iteration.primal_descent(self.y, v, self.v_bar, x, p, q, tau, tau_v, rho)
            self.fidelity.prox(x, self.x_bar, self.y, tau, rho)
            iteration.dual_ascent(p, q, self.x_bar, self.v_bar, sigma, alpha1, alpha0, rho)

    def meet(self, below: _Block) -> None:
        """Renew the rows that this block and the one below it keep of each other."""
        edge = self.bottom
        for mine, theirs in zip(self.part.planes, below.part.planes, strict=True):
            mine[:, edge - self.first :] = theirs[:, edge - below.first : edge - below.first + self.halo]
            theirs[:, : edge - below.first] = mine[:, edge - self.halo - self.first : edge - self.first]

    def return_to(self, whole: Iterate) -> None:
        """Write the rows that are this block's own."""
        for planes, mine in zip(whole.planes, self.part.planes, strict=True):
            if self.halo:
                planes[:, self.top : self.bottom] = mine[:, self.top - self.first : self.bottom - self.first]


def plane(alpha1: float | np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """The weight of the first-order term as an image (h, w) float32."""
    image = np.empty(shape, np.float32)
    image[:] = alpha1
    return image


def _by_rows(sums: Callable[[int, int], np.ndarray], image: np.ndarray) -> float:
    """The sum of a quantity that sums(top, bottom) gives row by row."""
    return float(np.concatenate(threads.each(lambda rows: sums(*rows), threads.blocks(image.shape[0]))).sum())


def value(x: np.ndarray, v: np.ndarray, regulariser: Regulariser | PixelwiseRegulariser) -> float:
    """alpha1 |grad x - v| + alpha0 |E v| for an image (h, w) and a slope field (2, h, w), float32."""
    return float(kernels.value_rows(x, v, plane(regulariser.alpha1, x.shape), regulariser.alpha0).sum())


def steepest_slopes(v: np.ndarray) -> np.ndarray:
    """Bound (h, w) that the certificate puts on the slopes of a solution, from those of an iterate (2, h, w)."""
    import cv2

    size = np.abs(v).max(axis=0)
    return np.float32(SLOPE_MARGIN) * (
        cv2.dilate(size, np.ones((NEIGHBOURHOOD, NEIGHBOURHOOD), np.uint8)) + size.mean()
    )


@dataclass(frozen=True)
class GapCheck:
    """The energy and the primal-dual gap of an iterate, taken every `Solver.check` iterations."""

    iteration: int
    energy: float
    gap: float  # (energy - bound) / energy


def minimise(
    fidelity: Fidelity,
    regulariser: Regulariser | PixelwiseRegulariser,
    iterate: Iterate,
    bounds: tuple[float, float],
    solver: Solver,
    *,
    ceiling: float = np.inf,
    watch: Callable[[GapCheck], None] = lambda check: None,
) -> list[GapCheck]:
    """Move the iterate to a minimiser of fidelity + regulariser, in place, and return the checks of its gap in order.

    Stops when the restricted gap is at most `solver.tolerance` and the energy at most `ceiling`, or after
    `solver.iterations`. `bounds` are the least and greatest value the minimiser can take.
    """
    checks: list[GapCheck] = []
    solver, smallest = iterate.balanced(solver), float(np.finfo(np.float32).tiny)
    while not checks or checks[-1].iteration < solver.iterations:
        done = checks[-1].iteration if checks else 0
        # The last step is a plain one: it ends at feasible duals.
        iterate.advance(fidelity, regulariser, solver, [solver.relaxation] * (solver.check - 1) + [1.0])
        energy = iterate.energy(fidelity, regulariser)
        gap = (energy - iterate.bound(fidelity, regulariser, *bounds)) / max(energy, smallest)
        checks.append(GapCheck(done + solver.check, energy, gap))
        watch(checks[-1])
        if gap <= solver.tolerance and energy <= ceiling:
            break
    return checks
