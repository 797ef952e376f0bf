"""The fusion of the depth maps of several views into one depth map of a reference camera (thesis chapter 4)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ipcli.errors import NoSolution
from ipcli.geometry.surface import normals, normals_of_slopes
from ipcli.inverse.regularize import tgv
from ipcli.inverse.regularize.fidelity import AbsoluteDeviations, Observations, SquaredDeviations
from ipcli.measurements.views import View
from ipcli.models.fusion import confidence as priors
from ipcli.models.fusion.alternation import ALGORITHMS, START, History, Problem, with_given_confidence
from ipcli.models.fusion.edges import first_order_weights, image_weights
from ipcli.models.fusion.holes import SEEN, UNSEEN, fill_holes, normals_of_filled, support
from ipcli.models.fusion.observations import Normalised, Units, floor, measure
from ipcli.models.fusion.parameters import METHODS, Fusion, Method
from ipcli.models.fusion.pyramid import start
from ipcli.models.fusion.reassociation import reassociate
from ipcli.models.fusion.reprojection import Layers, reproject_all
from ipcli.progress import Progress, silent


@dataclass(frozen=True, eq=False)
class Fused:
    """A fused depth map and what it rests on; all images (h, w), in the reference camera."""

    depth: np.ndarray  # float32, filled where nothing supports it; NaN there for methods without regularisation
    filled: np.ndarray  # uint8, SEEN, UNSEEN or UNBELIEVED of `holes`
    confidence: np.ndarray  # float32, L of eq. (4.14), in inverse noise scales; 0 where nothing was observed
    uncertainty: (
        np.ndarray
    )  # float32, the error to expect up to a factor, in the unit of depth; NaN where nothing was observed
    normals: np.ndarray  # (h, w, 3) float32, by the slopes of TGV if there are any
    observations: np.ndarray  # uint16
    mean: np.ndarray  # float32, of the forward projected observations, NaN where there are none
    median: np.ndarray  # float32, likewise
    layers: np.ndarray  # (K, h / every, w / every) float32, what each view said in the end, NaN = nothing
    lam: float  # weight of the data
    noise_scale: float  # of the observations: in the unit of depth, or of its inverse
    history: np.ndarray  # (n, 5) round, iteration, energy, restricted gap, merit; of the last pass
    every: int = 1  # so many-th rows and columns are in `layers`


@dataclass(frozen=True)
class PassScale:
    """The units of the noise and the weight of the data in one pass, measured on the whole image."""

    units: Units
    lam: float


def fuse(
    views: Sequence[View], reference: View, fusion: Fusion, *, inverse: bool, progress: Progress = silent
) -> Fused:
    """As `fuse_unfilled`, and what stands where no view supports the map is as `fusion.holes` says."""
    unfilled = fuse_unfilled(views, reference, fusion, inverse=inverse, progress=progress)
    return with_holes_filled(unfilled, reference, fusion, inverse=inverse)


def with_holes_filled(fused: Fused, reference: View, fusion: Fusion, *, inverse: bool) -> Fused:
    """The same map, its holes filled as `fusion.holes` says; without a regulariser they stay empty."""
    holes = fusion.holes
    if holes.fill == "regulariser" or not METHODS[fusion.method].order:
        return replace(fused, filled=np.where(fused.filled == UNSEEN, UNSEEN, SEEN).astype(np.uint8))
    depth = fill_holes(fused.depth, fused.filled, holes.reach * fused.noise_scale, inverse=inverse)
    own = normals_of_filled(fused.normals, depth, fused.filled, reference.intrinsics)
    return replace(fused, depth=depth, normals=own)


def fuse_unfilled(
    views: Sequence[View],
    reference: View,
    fusion: Fusion,
    *,
    inverse: bool,
    progress: Progress = silent,
    scales: Sequence[PassScale] | None = None,
) -> Fused:
    """Fuse the views, the reference among them if it is to count, in depth or in inverse depth.

    Planes are affine in inverse depth, and the noise of stereo is homogeneous there; depth sensors want depth. Methods
    with regularisation then look their observations up anew by the map that they found, `fusion.reassociate` times;
    mean and median stay those of the forward projection (4.34). `scales`, one for each pass, are measured if not given.
    Raises NoSolution if no view reaches the reference camera.
    """
    progress(0.0, "reprojecting")
    forward = reproject_all(views, reference)
    passes = passes_after_first(fusion)
    known: Sequence[PassScale | None] = scales or [None] * (passes + 1)
    progress(0.2, "fusing")
    last = fuse_layers(forward, reference, first_pass(fusion) if passes else fusion, inverse=inverse, scale=known[0])
    mean, median = (last.units.depth(image) for image in (last.data.mean(), last.data.median()))
    for done in range(1, passes + 1):
        progress(0.2 + 0.7 * done / (passes + 1), "fusing again, by the map so far")
        before = last.end
        del last  # its observations need not be in memory beside the next ones
        layers = reassociate(before.depth, views, reference, forward, before.units, in_place=done == passes)
        settings = fusion if done == passes else first_pass(fusion)
        last = fuse_layers(layers, reference, settings, inverse=inverse, before=before, scale=known[done])
    said = last.layers
    said[~np.isfinite(said)] = np.nan
    return Fused(
        depth=last.end.depth,
        filled=support(last.x, last.data, fusion.holes.believed),
        confidence=last.problem.of_pixels(last.problem.best_confidence(last.x)),
        uncertainty=last.uncertainty(),
        normals=last.normals(reference.intrinsics, METHODS[fusion.method]),
        observations=last.data.count.astype(np.uint16),
        mean=mean,
        median=median,
        layers=said,
        lam=last.problem.lam,
        noise_scale=last.units.scale,
        history=np.array(last.history.rows, np.float64).reshape(-1, 5),
    )


@dataclass(frozen=True, eq=False)
class PassEnd:
    """The iterate at the end of a pass, without the observations."""

    iterate: tgv.Iterate  # in these units
    units: Units

    @property
    def depth(self) -> np.ndarray:
        """The fused depth (h, w) float32."""
        return self.units.depth(self.iterate.x)

    def iterate_in(self, units: Units) -> tgv.Iterate:
        """The iterate in other units: the duals have none."""
        x, v = units.normalise(self.depth), self.iterate.v * np.float32(self.units.scale / units.scale)
        return tgv.Iterate(x, v, self.iterate.p, self.iterate.q)


@dataclass(frozen=True, eq=False)
class Pass:
    """The result of one fusion of given layers: data, problem, and the iterate that solves it."""

    layers: np.ndarray  # (K, h, w) float32, +inf = nothing
    units: Units
    data: Observations  # in these units
    problem: Problem
    iterate: tgv.Iterate  # in these units
    history: History

    @property
    def x(self) -> np.ndarray:
        """The fused image (h, w) float32, in these units."""
        return self.iterate.x

    def uncertainty(self) -> np.ndarray:
        """The error to expect in depth, up to a factor (h, w) float32; NaN where nothing was observed."""
        absolute = AbsoluteDeviations(self.data, np.ones_like(self.x)).deviation(self.x)
        error = priors.uncertainty(self.x, absolute, self.data.count) * self.units.slopes(self.x)
        return np.where(self.data.count > 0, error, np.nan).astype(np.float32)

    def normals(self, intrinsics: np.ndarray, method: Method) -> np.ndarray:
        """Unit normals (h, w, 3) float32: TGV's slopes are the smooth part of the gradient of its image."""
        depth = self.units.depth(self.x)
        if method.order < 2:
            return normals(depth, intrinsics)
        v = self.iterate.v.copy()  # between a pixel and the next
        v[0, :, 1:-1] = (v[0, :, 1:-1] + v[0, :, :-2]) / 2
        v[1, 1:-1] = (v[1, 1:-1] + v[1, :-2]) / 2
        sign = -1 if self.units.inverse else 1
        return normals_of_slopes(depth, sign * v * self.units.slopes(self.x), intrinsics)

    @property
    def end(self) -> PassEnd:
        """Where it ended, without the observations."""
        return PassEnd(self.iterate, self.units)


def fuse_layers(
    layers: Layers,
    reference: View,
    fusion: Fusion,
    *,
    inverse: bool,
    before: PassEnd | None = None,
    scale: PassScale | None = None,
) -> Pass:
    """One fusion of observations that are where they belong, from where a pass before ended or from a coarse grid.

    NoSolution if there are no observations, or all have weight 0.
    """
    weights = layers.confidence if fusion.confidence.given else None
    if weights is not None and np.isfinite(layers.depth).any() and not (weights[np.isfinite(layers.depth)] > 0).any():
        raise NoSolution(
            "the given confidence of every observation is 0: correct it, or ignore it with --no-given-confidence"
        )
    if scale is None:
        units = measure(layers.depth, weights, inverse=inverse)
    else:
        units = replace(scale.units, floor=floor(layers.depth, weights, inverse=inverse))
    x: Normalised | np.ndarray = Normalised(units, layers.depth, weights)
    data = Observations.of(x, weights)
    method = METHODS[fusion.method]
    lam = scale.lam if scale else balanced_lambda(data, method) if fusion.lam is None else fusion.lam
    if method.of_median:
        x = data.median()[None]
    problem = build_problem(Observations.of(x) if method.of_median else data, lam, method, fusion)
    history = History()
    if method.order == 0:
        iterate = tgv.Iterate.at(data.mean() if method.deviation == "squared" else data.median())
        return Pass(layers.depth, units, data, problem, iterate, history)
    if fusion.edges.image and reference.image is not None:
        problem = problem.regularised_by(image_weights(reference.image, fusion.edges.image))
    weight = float(data.total.sum() / data.count.sum())  # of an observation, on average: the start takes them all alike
    levels = fusion.solver.levels
    iterate = before.iterate_in(units) if before else start(x, lam * weight, problem.regulariser, fusion.solver, levels)
    if before and method.order == 2 and fusion.edges.gain:
        problem = problem.regularised_by(first_order_weights(iterate.x, iterate.v, data.count, fusion.edges))
    problem = solve(problem, iterate, method, fusion, units, reference, history)
    return Pass(layers.depth, units, data, problem, iterate, history)


def passes_after_first(fusion: Fusion) -> int:
    """How often observations are looked up by the map so far."""
    return fusion.reassociate if METHODS[fusion.method].order else 0


def first_pass(fusion: Fusion) -> Fusion:
    """The settings of a fusion whose map only serves to associate the next: quick ones."""
    return replace(fusion, rounds=1, solver=replace(fusion.solver, tolerance=START * fusion.solver.tolerance))


def solve(
    problem: Problem,
    iterate: tgv.Iterate,
    method: Method,
    fusion: Fusion,
    units: Units,
    reference: View,
    history: History,
) -> Problem:
    """Move the iterate to the solution by the algorithm of the method; the problem with its prior confidence put in."""
    solver, even = fusion.solver, np.ones(iterate.x.shape, np.float32)
    if not (method.adaptive or method.normals or method.edges):
        with_given_confidence(problem, even, iterate, solver, history)
        return problem
    with_given_confidence(problem, even, iterate, replace(solver, tolerance=START * solver.tolerance), history)
    prior = prior_confidence(iterate.x, method, fusion, units, reference)
    if not method.adaptive:
        with_given_confidence(problem, prior, iterate, solver, history)
        return problem
    problem = problem.with_prior(prior)
    ALGORITHMS[fusion.algorithm](problem, iterate, solver, fusion.rounds, history)
    return problem


def balanced_lambda(data: Observations, method: Method) -> float:
    """The lambda at which, on the true image, chance pulls a pixel as hard as the regulariser can hold.

    There the K signs of x - d_k add up to a random walk of length sqrt(sum of w_k^2), in the units of the noise also
    for squares; the regulariser answers with at most about alpha1. So lambda = 1 / that length, in the pixel of the
    median observation: a wide margin of pixels that few views reach does not count for much. The median of K
    observations pulls as one, but errs 1 / sqrt(K) as much.
    """
    walk = np.sqrt(data.count if data.weights is None else np.square(data.weights).sum(axis=1)).ravel()
    order = np.argsort(walk, kind="stable")
    reached = np.cumsum(data.count.ravel()[order], dtype=np.float64)
    length = float(walk[order[np.searchsorted(reached, reached[-1] / 2)]])
    return length if method.of_median else 1 / length


def build_problem(data: Observations, lam: float, method: Method, fusion: Fusion) -> Problem:
    """Energy (4.3) of a method on sorted observations, the prior confidence even."""
    settings = fusion.confidence
    even = np.ones_like(data.total)
    fidelity: AbsoluteDeviations | SquaredDeviations
    if method.deviation == "squared":
        fidelity = SquaredDeviations.of(data, even)
    else:
        fidelity = AbsoluteDeviations(data, even, fusion.huber if method.deviation == "huber" else 0.0)
    b = np.full_like(even, settings.b) if settings.b else data.count + np.float32(settings.shape - 1)
    regulariser = replace(fusion.regulariser, order=method.order) if method.order else fusion.regulariser
    problem = Problem(fidelity, lam, regulariser, data.bounds, b, np.full_like(even, settings.rate))
    return problem.for_each() if method.each_view else problem


def prior_confidence(x: np.ndarray, method: Method, fusion: Fusion, units: Units, reference: View) -> np.ndarray:
    """The heuristic confidence (h, w) that a method asks for, from a first fused image; 1 where it asks for none."""
    prior, settings = np.ones_like(x), fusion.confidence
    if method.normals:
        prior *= priors.view_angle(units.depth(x), reference.intrinsics)
    if method.edges and reference.image is not None:
        prior *= priors.image_edges(reference.image, settings.edge_gain, settings.edge_power, settings.edge_blur)
    return prior
