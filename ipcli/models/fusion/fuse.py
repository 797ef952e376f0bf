"""The fusion of the depth maps of several views into one depth map of a reference camera (thesis chapter 4)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ipcli.errors import NoSolution
from ipcli.geometry.cameras import View
from ipcli.inverse.regularize import tgv
from ipcli.inverse.regularize.fidelity import AbsoluteDeviations, Observations, SquaredDeviations
from ipcli.models.fusion import confidence as priors
from ipcli.models.fusion.alternation import ALGORITHMS, History, Problem, with_given_confidence
from ipcli.models.fusion.observations import Units, measure
from ipcli.models.fusion.parameters import METHODS, Fusion, Method
from ipcli.models.fusion.pyramid import start
from ipcli.models.fusion.reprojection import Layers, reproject_all

FIRST_PASS = 10.0  # the pass that only serves to find a first confidence may be this much less exact


@dataclass(frozen=True, eq=False)
class Fused:
    """A fused depth map and what it rests on; all images (h, w), in the reference camera."""

    depth: np.ndarray  # float32, in-painted where nothing was observed; NaN there for methods without regularisation
    confidence: np.ndarray  # float32, L of eq. (4.14), in inverse noise scales; 0 where nothing was observed
    observations: np.ndarray  # uint16
    mean: np.ndarray  # float32, NaN where nothing was observed
    median: np.ndarray  # float32, NaN where nothing was observed
    layers: np.ndarray  # (K, h, w) float32, reprojected depth of each view, NaN = nothing
    lam: float  # weight of the data
    noise_scale: float  # of the observations: in the unit of depth, or of its inverse
    history: np.ndarray  # (n, 5) round, iteration, energy, restricted gap, merit


def fuse(
    views: Sequence[View],
    reference: View,
    fusion: Fusion,
    *,
    inverse: bool,
    progress: Callable[[float, str], None] = lambda share, what: None,
) -> Fused:
    """Fuse the views, the reference among them if it is to count, in depth or in inverse depth.

    Planes are affine in inverse depth, and the noise of stereo is homogeneous there; depth sensors want depth. Raises
    NoSolution if no view reaches the reference camera.
    """
    progress(0.0, "reprojecting")
    layers = reproject_all(views, reference)
    units = measure(layers.depth, inverse=inverse)
    x = units.normalise(layers.depth)
    data = Observations.of(x, layers.confidence if fusion.confidence.given else None)
    if not data.count.any():
        raise NoSolution("the given confidence of every observation is 0: correct it, or ignore it with --no-given-confidence")
    method = METHODS[fusion.method]
    history = History()
    progress(0.2, "fusing")
    fused, problem = solve(x, data, method, fusion, units, reference, history)
    return Fused(
        depth=units.depth(fused),
        confidence=problem.best_confidence(fused),
        observations=data.count.astype(np.uint16),
        mean=units.depth(data.mean()),
        median=units.depth(data.median()),
        layers=np.where(np.isfinite(layers.depth), layers.depth, np.nan),
        lam=problem.lam,
        noise_scale=units.scale,
        history=np.array(history.rows, np.float64).reshape(-1, 5),
    )


def solve(
    x: np.ndarray, data: Observations, method: Method, fusion: Fusion, units: Units, reference: View, history: History
) -> tuple[np.ndarray, Problem]:
    """The fused image (h, w) of layers x (K, h, w) in units of the noise, and the problem it solves."""
    lam = balanced_lambda(data, method) if fusion.lam is None else fusion.lam
    if method.of_median:
        x = data.median()[None]
        data = Observations.of(x)
    problem = pose(data, lam, method, fusion)
    if method.order == 0:
        return (data.mean() if method.deviation == "squared" else data.median()), problem
    solver = fusion.solver
    weight = float(data.total.sum() / data.count.sum())  # of an observation, on average: the start takes them all alike
    iterate = start(x, lam * weight, problem.regulariser, solver, solver.levels)
    even = np.ones(iterate.x.shape, np.float32)
    if not (method.adaptive or method.normals or method.edges):
        with_given_confidence(problem, even, iterate, solver, history)
        return iterate.x, problem
    with_given_confidence(problem, even, iterate, replace(solver, tolerance=FIRST_PASS * solver.tolerance), history)
    prior = prior_confidence(iterate.x, method, fusion, units, reference)
    if not method.adaptive:
        with_given_confidence(problem, prior, iterate, solver, history)
        return iterate.x, problem
    problem = replace(problem, rate=problem.rate / prior)
    ALGORITHMS[fusion.algorithm](problem, iterate, solver, fusion.rounds, history)
    return iterate.x, problem


def balanced_lambda(data: Observations, method: Method) -> float:
    """The lambda at which, on the true image, chance pulls a pixel as hard as the regulariser can hold.

    There the K signs of x - d_k add up to a random walk of length sqrt(sum of w_k^2), in the units of the noise also for
    squares; the regulariser answers with at most about alpha1. So lambda = 1 / that length, in the median over pixels. The
    median of K observations pulls as one, but errs 1 / sqrt(K) as much.
    """
    walk = np.sqrt(data.count if data.weights is None else np.square(data.weights).sum(axis=1))
    length = float(np.median(walk[data.count > 0]))
    return length if method.of_median else 1 / length


def pose(data: Observations, lam: float, method: Method, fusion: Fusion) -> Problem:
    """Energy (4.3) of a method on sorted observations, the prior confidence even."""
    settings = fusion.confidence
    even = np.ones_like(data.total)
    if method.deviation == "squared":
        fidelity = SquaredDeviations.of(data, even)
    else:
        fidelity = AbsoluteDeviations(data, even, fusion.huber if method.deviation == "huber" else 0.0)
    b = np.full_like(even, settings.b) if settings.b else data.count + np.float32(settings.shape - 1)
    regulariser = replace(fusion.regulariser, order=method.order) if method.order else fusion.regulariser
    return Problem(fidelity, lam, regulariser, data.bounds, b, np.full_like(even, settings.rate))


def prior_confidence(x: np.ndarray, method: Method, fusion: Fusion, units: Units, reference: View) -> np.ndarray:
    """The heuristic confidence (h, w) that a method asks for, from a first fused image; 1 where it asks for none."""
    prior, settings = np.ones_like(x), fusion.confidence
    if method.normals:
        prior *= priors.view_angle(units.depth(x), reference.intrinsics)
    if method.edges and reference.image is not None:
        prior *= priors.image_edges(reference.image, settings.edge_gain, settings.edge_power, settings.edge_blur)
    return prior
