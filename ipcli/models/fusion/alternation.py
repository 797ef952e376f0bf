"""Depth and confidence together: the biconvex energy (4.3) and the algorithms that lower it.

In the units of the noise, with the data term and its prior weighed by lambda,

    E(x, L) = TGV(x) + lambda sum_i [ L_i D_i(x) + rate_i L_i - b_i log L_i ],   D_i(x) = sum_k w_ik |x_i - d_ik|,

where rate = 1/(2W). The best confidence of an image is L_i = b_i / (D_i(x) + rate_i), eq. (4.14); put in, it leaves

    F(x) = TGV(x) + lambda sum_i b_i log(D_i(x) + rate_i)   (+ terms without x),

the merit that every round of alternate convex search lowers (it minimises a majorant of F), and that stops it. By
default b_i = K_i + shape - 1 for K_i observations: the confidence is then the posterior mode of the precision of
Laplace noise under a Gamma(shape, rate) prior. The code published with the thesis never used L in ACS and AMA; see
docs/errata.md.

A confidence of every observation (there: "_sep") stands in for that of the pixel by L_ik in place of L_i and its prior
divided by K_i; all of the above then holds observation by observation, and where they deviate alike the two are the
same.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from ipcli.inverse.regularize import tgv
from ipcli.inverse.regularize.fidelity import AbsoluteDeviations, Anchored, Fidelity, Observations, SquaredDeviations
from ipcli.inverse.regularize.parameters import Regulariser, Solver

START = 30.0  # the first round may be this much less exact than the last
TIGHTEN = 4.0  # by how much each round is more exact than the one before
SETTLED = 1e-3  # a round that lowers the merit by less than this share of its regularised part was the last one
FAR = 1e3  # reach of a proximal term, in units of the noise, that no longer matters
BICONVEX_STEP = 0.1  # tau of the confidence in Algorithm 4.4


@dataclass(frozen=True, eq=False)
class Problem:
    """Energy (4.3) for one image; the confidence L, b and rate are (h, w) float32, or (h, K, w) with one for each
    observation.
    """

    fidelity: AbsoluteDeviations | SquaredDeviations  # its scale, or its weights, are set anew from the confidence
    lam: float
    regulariser: Regulariser | tgv.PixelwiseRegulariser
    bounds: tuple[float, float]
    b: np.ndarray
    rate: np.ndarray

    @property
    def data(self) -> Observations:
        """The observations one by one, which a data term of absolute deviations keeps."""
        if not isinstance(self.fidelity, AbsoluteDeviations):
            raise TypeError("squared deviations keep no single observations")
        return self.fidelity.data

    @property
    def has_confidence_of_each(self) -> bool:
        """Whether each observation has a confidence of its own."""
        return self.b.ndim == 3

    @property
    def observed(self) -> np.ndarray:
        """Where there is something to be confident of: (h, w), or (h, K, w)."""
        return np.isfinite(self.data.stack) if self.has_confidence_of_each else self.fidelity.total > 0

    def at(self, confidence: np.ndarray) -> AbsoluteDeviations | SquaredDeviations:
        """The data term lambda L D of a given confidence, of pixels (h, w) or of observations (h, K, w)."""
        if confidence.ndim == 3:
            scale = np.full(confidence.shape[::2], self.lam, np.float32)
            return AbsoluteDeviations(self.data.reweighted(confidence), scale)
        return replace(self.fidelity, scale=(self.lam * confidence).astype(np.float32))

    def deviations(self, x: np.ndarray) -> np.ndarray:
        """D of an image (h, w): of each pixel, or of each observation."""
        return self.data.deviations(x) if self.has_confidence_of_each else self.fidelity.deviation(x)

    def best_confidence(self, x: np.ndarray) -> np.ndarray:
        """L of an image, eq. (4.14); 0 where nothing was observed."""
        return np.where(self.observed, self.b / (self.deviations(x) + self.rate), 0).astype(np.float32)

    def of_pixels(self, confidence: np.ndarray) -> np.ndarray:
        """A confidence as one of pixels (h, w): the mean over their observations."""
        if confidence.ndim == 2:
            return confidence
        data = self.data
        return (data.reweighted(confidence).total / np.maximum(data.total, np.finfo(np.float32).tiny)).astype(
            np.float32
        )

    def merit(self, iterate: tgv.Iterate) -> float:
        """F at an iterate, with its own slopes in place of the best ones."""
        data = self.b * np.log(self.deviations(iterate.x) + self.rate, dtype=np.float64)
        return tgv.value(iterate.x, iterate.v, self.regulariser) + self.lam * float(data.sum(where=self.observed))

    def with_prior(self, prior: np.ndarray) -> Problem:
        """The same under a prior confidence (h, w)."""
        return replace(self, rate=self.rate / (prior[:, None] if self.has_confidence_of_each else prior))

    def regularised_by(self, weights: np.ndarray) -> Problem:
        """The same with the first-order term weighted (h, w), times the weights that it has."""
        own = self.regulariser
        return replace(self, regulariser=tgv.PixelwiseRegulariser(own.order, own.alpha1 * weights, own.alpha0))

    def for_each(self) -> Problem:
        """The same with a confidence for each observation in place of one for each pixel, whose prior they
        share out.
        """
        count = np.maximum(self.data.count, 1)
        shape = self.data.stack.shape
        b, rate = (np.broadcast_to((prior / count)[:, None], shape) for prior in (self.b, self.rate))
        return replace(self, b=b, rate=rate)


@dataclass
class History:
    """Rows (round, iteration, energy, restricted gap, merit) of a fusion; the merit stands in the last row of its
    round.
    """

    rows: list[tuple[float, float, float, float, float]] = field(default_factory=list)

    def add(self, checks: list[tgv.GapCheck], merit: float = np.nan) -> None:
        """Append one round: its checks of the gap, and its final merit."""
        round, start = (self.rows[-1][0] + 1, self.rows[-1][1]) if self.rows else (0, 0)
        self.rows += [(round, start + check.iteration, check.energy, check.gap, np.nan) for check in checks]
        self.mark(merit)

    def mark(self, merit: float) -> None:
        """Put the merit in where the last round ended."""
        self.rows[-1] = (*self.rows[-1][:4], merit)


def with_given_confidence(
    problem: Problem, confidence: np.ndarray, iterate: tgv.Iterate, solver: Solver, history: History
) -> None:
    """Algorithm 4.3 by the fast solver: the depth for a confidence that stays as it is."""
    history.add(tgv.minimise(problem.at(confidence), problem.regulariser, iterate, problem.bounds, solver))


def alternate_convex_search(
    problem: Problem, iterate: tgv.Iterate, solver: Solver, rounds: int, history: History
) -> None:
    """Algorithm 4.1: the best confidence of the depth, then the best depth of the confidence, until the merit settles.

    A round is only over once its energy is no higher than where it began; with the best confidence there, this makes
    the merit fall.
    """
    merit = problem.merit(iterate)
    history.mark(merit)
    for inner in solver_of_rounds(solver, rounds):
        before, merit = merit, _round(problem, problem.at(problem.best_confidence(iterate.x)), iterate, inner, history)
        if inner.tolerance == solver.tolerance and has_settled(before - merit, problem, iterate):
            break


def alternate_minimisation(
    problem: Problem, iterate: tgv.Iterate, solver: Solver, rounds: int, history: History
) -> None:
    """Algorithm 4.2: as alternate convex search, each step held near the last by a proximal term that reaches further
    each round.

    The reach starts at 1/K, where the joint problem is convex (K-semiconvexity; the thesis' sqrt(N) is not needed), and
    ends at FAR, where it holds nothing back. A round that gains little says nothing before that: it was not let go.
    """
    nearest = 1.0 / max(float(problem.fidelity.total.max()), 1.0)
    confidence = problem.best_confidence(iterate.x)
    history.mark(problem.merit(iterate))
    for inner, share in zip(
        solver_of_rounds(solver, rounds), np.linspace(0, 1, rounds) if rounds > 1 else [1.0], strict=True
    ):
        reach = float(nearest ** (1 - share) * FAR**share)
        confidence = confidence_step(confidence, problem, iterate.x, reach)
        anchored = Anchored(problem.at(confidence), iterate.x.copy(), reach)
        _round(problem, anchored, iterate, inner, history)


def biconvex_primal_dual(problem: Problem, iterate: tgv.Iterate, solver: Solver, rounds: int, history: History) -> None:
    """Algorithm 4.4: one proximal step of the confidence in every iteration of the depth.

    Its K dual images are replaced by their optimum, the exact proximal map. Not proven to converge; the history shows
    it.
    """
    confidence, solver = problem.best_confidence(iterate.x), iterate.balanced(solver)
    history.mark(problem.merit(iterate))
    for _ in range(rounds):
        for _ in range(solver.check - 1):
            confidence = confidence_step(confidence, problem, iterate.x, BICONVEX_STEP)
            iterate.advance(problem.at(confidence), problem.regulariser, solver, [1.0])
        quick = replace(solver, iterations=1, check=1)
        checks = tgv.minimise(problem.at(confidence), problem.regulariser, iterate, problem.bounds, quick)
        history.add([replace(checks[0], iteration=solver.check)], problem.merit(iterate))


def confidence_step(confidence: np.ndarray, problem: Problem, x: np.ndarray, step: float) -> np.ndarray:
    """Proximal step of the confidence, eqs. (4.15)-(4.17): the positive root of L^2 - a L - b step = 0."""
    a = confidence - step * (problem.deviations(x) + problem.rate)
    half = (np.abs(a) + np.sqrt(a * a + 4 * problem.b * step)) / 2
    root = np.where(a > 0, half, problem.b * step / half)  # each without cancellation
    return np.where(problem.observed, root, 0).astype(np.float32)


def solver_of_rounds(solver: Solver, rounds: int) -> list[Solver]:
    """The solver of each round after the first pass: loose while the confidence is rough, at the end as exact as asked
    for.
    """
    shares = [START / TIGHTEN ** (round + 1) for round in range(rounds - 1)] + [1.0]
    return [replace(solver, tolerance=max(share, 1.0) * solver.tolerance) for share in shares]


def has_settled(gain: float, problem: Problem, iterate: tgv.Iterate) -> bool:
    """Whether a round that lowered the merit by `gain` was not worth another one."""
    return gain <= SETTLED * tgv.value(iterate.x, iterate.v, problem.regulariser)


def _round(problem: Problem, fidelity: Fidelity, iterate: tgv.Iterate, solver: Solver, history: History) -> float:
    """Minimise for one confidence, to an energy no higher than at the start; the merit there.

    Out of iterations above it, the image goes back to where it was.
    """
    ceiling = iterate.energy(fidelity, problem.regulariser)
    x, v = iterate.x.copy(), iterate.v.copy()
    checks = tgv.minimise(fidelity, problem.regulariser, iterate, problem.bounds, solver, ceiling=ceiling)
    if checks[-1].energy > ceiling:
        iterate.x[:], iterate.v[:] = x, v
    merit = problem.merit(iterate)
    history.add(checks, merit)
    return merit


ALGORITHMS: dict[str, Callable[[Problem, tgv.Iterate, Solver, int, History], None]] = {
    "acs": alternate_convex_search,
    "ama": alternate_minimisation,
    "biconvex": biconvex_primal_dual,
}
