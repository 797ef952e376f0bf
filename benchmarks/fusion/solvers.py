"""The solvers. Each is made for a problem and a step ratio, runs on for some iterations, and shows its x and v.

The step ratio w gives tau = 0.99 / (L w) and sigma = 0.99 w / L for the norm L of its operator;
w is looked for on `RATIOS`. All compute in float32.

The K data terms can be dualised, one image each, as by the thesis and by anyone without a proximal map of their sum
(L^2 = 12 + K), or stay in the primal step by that map (L^2 = 12).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from benchmarks.fusion.problem import TgvProblem, within
from ipcli.inverse.regularize.operators import (
    NORM,
    gradient,
    gradient_adjoint,
    symmetrised_gradient,
    symmetrised_gradient_adjoint,
)

RATIOS = (0.3, 1.0, 3.0, 10.0, 30.0)
SHARE = 0.99  # of the longest steps that are proven to converge


class SolverAtWork(Protocol):
    """A solver at work."""

    def run(self, iterations: int) -> None:
        """So many iterations more."""

    def solution(self) -> tuple[np.ndarray, np.ndarray]:
        """x (h, w) and v (2, h, w)."""


def steps(norm: float, ratio: float) -> tuple[float, float]:
    """(tau, sigma)."""
    return float(SHARE / (norm * ratio)), float(SHARE * ratio / norm)


def dualised_norm(problem: TgvProblem) -> float:
    """Of (x, v) -> (grad x - v, E v, x, ..., x)."""
    return float(np.sqrt(NORM**2 + len(problem.layers)))


class Ours:
    """`inverse.regularize.tgv` as it comes: it chooses its steps itself."""

    def __init__(self, problem: TgvProblem, ratio: float | None = None):
        from ipcli.inverse.regularize.fidelity import AbsoluteDeviations, Observations
        from ipcli.inverse.regularize.parameters import Solver as Settings
        from ipcli.inverse.regularize.tgv import Iterate

        scale = np.full(problem.shape, problem.lam, np.float32)
        self.fidelity = AbsoluteDeviations(Observations.of(list(problem.layers)), scale)
        self.regulariser = problem.regulariser
        self.iterate = Iterate.at(problem.start())
        self.settings = self.iterate.balanced(Settings())

    def run(self, iterations: int) -> None:
        relaxations = [self.settings.relaxation] * (iterations - 1) + [1.0]
        self.iterate.advance(self.fidelity, self.regulariser, self.settings, relaxations)

    def solution(self) -> tuple[np.ndarray, np.ndarray]:
        return self.iterate.x, self.iterate.v


class Thesis:
    """Algorithm 4.3: the K data terms dualised, in NumPy, from `operators` and `pdhg`."""

    def __init__(self, problem: TgvProblem, ratio: float):
        self.present = np.isfinite(problem.layers)
        self.data = np.where(self.present, problem.layers, np.float32(0))
        self.lam, self.regulariser = problem.lam, problem.regulariser
        self.x = np.concatenate([problem.start()[None], np.zeros((2, *problem.shape), np.float32)])
        self.y = np.zeros((5 + len(self.data), *problem.shape), np.float32)
        self.tau, self.sigma = steps(dualised_norm(problem), ratio)

    def forward(self, x):
        return np.concatenate([gradient(x[0]) - within(x[1:]), symmetrised_gradient(x[1:]), self.present * x[0]])

    def adjoint(self, y):
        image = gradient_adjoint(y[:2]) + (self.present * y[5:]).sum(axis=0)
        return np.concatenate([image[None], symmetrised_gradient_adjoint(y[2:5]) - within(y[:2])])

    def prox_conjugate(self, y, sigma):
        from ipcli.inverse.regularize.proximal import project_balls

        p = project_balls(y[:2], self.regulariser.alpha1, (1, 1))
        q = project_balls(y[2:5], self.regulariser.alpha0, (1, 1, 2))
        return np.concatenate([p, q, np.clip(y[5:] - sigma * self.data, -self.lam, self.lam)])

    def run(self, iterations: int) -> None:
        from ipcli.inverse.regularize.pdhg import pdhg

        self.x, self.y = pdhg(
            self.forward,
            self.adjoint,
            lambda x, tau: x,
            self.prox_conjugate,
            self.x,
            self.y,
            tau=self.tau,
            sigma=self.sigma,
            iterations=iterations,
        )

    def solution(self) -> tuple[np.ndarray, np.ndarray]:
        return self.x[0], self.x[1:]


class _Pyproximal:
    """pyproximal's PrimalDual on the flat vector (x, v1, v2)."""

    def __init__(self, problem, ratio, operator, norm, of_primal, of_dual):
        from pyproximal.optimization.cls_primaldual import PrimalDual

        tau, sigma = steps(norm, ratio)
        self.shape = problem.shape
        start = np.zeros((3, *self.shape), np.float32)
        start[0] = problem.start()
        self.solver = PrimalDual()
        self.state = self.solver.setup(of_primal, of_dual, operator, start.ravel(), tau, sigma, gfirst=False)

    def run(self, iterations: int) -> None:
        self.state = self.solver.run(*self.state, niter=self.solver.iiter + iterations)

    def solution(self) -> tuple[np.ndarray, np.ndarray]:
        x = self.state[0].reshape(3, *self.shape)
        return x[0], x[1:]


class PyproximalStacked(_Pyproximal):
    """As its documentation builds such a problem: pylops operators in blocks, its own L21 and L1 for all terms."""

    def __init__(self, problem: TgvProblem, ratio: float):
        import pylops
        import pyproximal

        k, n = len(problem.layers), problem.layers[0].size
        present = np.isfinite(problem.layers)
        image = pylops.Identity(n, dtype=np.float32)
        data = [[image, pylops.Zero(n, 2 * n, dtype=np.float32)]] * k
        operator = pylops.Block([*_pylops_tgv(problem.shape), *data], dtype=np.float32)
        weights = (problem.lam * present).astype(np.float32).ravel()
        deviations = pyproximal.L1(weights, np.where(present, problem.layers, np.float32(0)).ravel())
        of_dual = pyproximal.VStack([*_pyproximal_tgv(problem), deviations], [2 * n, 3 * n, k * n])
        super().__init__(problem, ratio, operator, dualised_norm(problem), _nothing(), of_dual)


class PyproximalTuned(_Pyproximal):
    """The same solver given what it lacks: a sparse matrix and its transpose, both by rows, for the operator, our
    sorted proximal map in NumPy, and a stack that asks its parts for their dual maps instead of Moreau's identity for
    all.
    """

    def __init__(self, problem: TgvProblem, ratio: float):
        import pylops
        import pyproximal

        n, matrix = problem.layers[0].size, sparse_tgv(problem.shape)
        transposed = matrix.T.tocsr()
        operator = pylops.FunctionOperator(matrix.dot, transposed.dot, *matrix.shape, dtype=np.float32)

        class Stack(pyproximal.VStack):
            def proxdual(self, x, tau):
                parts = np.split(x, self.xin[1:])
                return np.concatenate(
                    [part_of.proxdual(part, tau) for part_of, part in zip(self.ops, parts, strict=True)]
                )

        of_dual = Stack(_pyproximal_tgv(problem), [2 * n, 3 * n])
        of_primal = pyproximal.VStack([_sorted_deviations(problem), _nothing()], [n, 2 * n])
        super().__init__(problem, ratio, operator, float(NORM), of_primal, of_dual)


def _pylops_tgv(shape):
    """Rows of blocks [on x, on v] of grad x - v and E v, the mixed entry weighed so that a plain norm is Frobenius'."""
    import pylops

    n = shape[0] * shape[1]

    def difference(axis, kind):
        return pylops.FirstDerivative(shape, axis=axis, kind=kind, edge=False, dtype=np.float32)

    inner = pylops.Diagonal(mixed_weight(shape).ravel(), dtype=np.float32)
    slope = pylops.VStack([difference(1, "forward"), difference(0, "forward")], dtype=np.float32)
    nothing = pylops.Zero(n, n, dtype=np.float32)
    curvature = pylops.Block(
        [
            [difference(1, "backward"), nothing],
            [nothing, difference(0, "backward")],
            [inner * difference(0, "backward"), inner * difference(1, "backward")],
        ],
        dtype=np.float32,
    )
    exists = pylops.Diagonal(-within(np.ones((2, *shape), np.float32)).ravel(), dtype=np.float32)
    return [[slope, exists], [pylops.Zero(3 * n, n, dtype=np.float32), curvature]]


def mixed_weight(shape: tuple[int, int]) -> np.ndarray:
    """sqrt(2) / 2 where the mixed derivative exists, 0 in the first row and column."""
    weight = np.zeros(shape, np.float32)
    weight[1:, 1:] = np.sqrt(0.5)
    return weight


def sparse_tgv(shape: tuple[int, int]):
    """(x, v1, v2) -> (grad x - v, E v) as one sparse matrix (5n, 3n), the mixed entry weighed by `mixed_weight`."""
    from scipy import sparse

    h, w = shape

    def forward(n):
        return sparse.diags_array([np.r_[-np.ones(n - 1), 0], np.ones(n - 1)], offsets=[0, 1])

    def backward(n):
        return sparse.diags_array([np.r_[0, np.ones(n - 1)], -np.ones(n - 1)], offsets=[0, -1])

    def along(difference):
        return sparse.kron(sparse.identity(h), difference(w)), sparse.kron(difference(h), sparse.identity(w))

    (ahead, down), (back, up) = along(forward), along(backward)
    mixed = sparse.diags_array(mixed_weight(shape).ravel())
    v1_exists, v2_exists = (sparse.diags_array(plane.ravel()) for plane in within(np.ones((2, h, w))))
    rows = [
        [ahead, -v1_exists, None],
        [down, None, -v2_exists],
        [None, back, None],
        [None, None, up],
        [None, mixed @ up, mixed @ back],
    ]
    return sparse.csr_array(sparse.block_array(rows), dtype=np.float32)


def _pyproximal_tgv(problem):
    import pyproximal

    return [pyproximal.L21(2, sigma=problem.regulariser.alpha1), pyproximal.L21(3, sigma=problem.regulariser.alpha0)]


def _nothing():
    """The functional 0."""
    from pyproximal.ProxOperator import ProxOperator

    class Nothing(ProxOperator):
        def __init__(self):
            super().__init__(None, False)

        def __call__(self, x):
            return 0.0

        def prox(self, x, tau):
            return x

    return Nothing()


def _sorted_deviations(problem):
    """lambda sum_k |x - d_k| by the median formula of `inverse.regularize.proximal`, the data sorted beforehand."""
    from pyproximal.ProxOperator import ProxOperator

    data = np.sort(
        np.where(np.isfinite(problem.layers), problem.layers, np.inf).reshape(len(problem.layers), -1), axis=0
    )
    count = np.isfinite(data).sum(axis=0, dtype=np.float32)

    class SortedDeviations(ProxOperator):
        def __init__(self):
            super().__init__(None, False)

        def __call__(self, x):
            return float("nan")  # asked for once, when the solver is set up; nothing depends on it

        def prox(self, y, tau):
            step = np.float32(tau * problem.lam)
            x = y + step * count
            for k, d in enumerate(data, 1):
                np.minimum(x, np.maximum(d, y + step * (count - np.float32(2 * k))), out=x)
            return x

    return SortedDeviations()


class Odl:
    """ODL's pdhg, the problem from its operators and functionals."""

    def __init__(self, problem: TgvProblem, ratio: float):
        import odl

        h, w = problem.shape
        pixels = odl.uniform_discr([0, 0], [h, w], [h, w], dtype="float32")
        self.operator, terms = _odl_terms(pixels, problem)
        self.of_dual = odl.functionals.SeparableSum(*terms)
        self.of_primal = odl.functionals.ZeroFunctional(self.operator.domain)
        self.x = self.operator.domain.zero()
        self.x[0].assign(pixels.element(problem.start()))
        self.x_relax, self.y = self.x.copy(), self.operator.range.zero()
        self.tau, self.sigma = steps(dualised_norm(problem), ratio)

    def run(self, iterations: int) -> None:
        from odl.solvers import pdhg

        resume = {"x_relax": self.x_relax, "y": self.y}
        pdhg(self.x, self.of_primal, self.of_dual, self.operator, iterations, self.tau, self.sigma, **resume)

    def solution(self) -> tuple[np.ndarray, np.ndarray]:
        image, *slopes = (part.asarray() for part in self.x)
        return image, np.stack(slopes)


def _odl_terms(pixels, problem):
    """The operator on (x, v1, v2), and a functional for each of its parts."""
    import odl

    x, v1, v2 = (odl.ComponentProjection(pixels**3, i) for i in range(3))

    def difference(axis, method):
        return odl.PartialDerivative(pixels, axis=axis, method=method, pad_mode="symmetric")

    ahead, down, back, up = (
        difference(1, "forward"),
        difference(0, "forward"),
        difference(1, "backward"),
        difference(0, "backward"),
    )
    mixed = odl.MultiplyOperator(pixels.element(mixed_weight(problem.shape)))
    v1_exists, v2_exists = (
        odl.MultiplyOperator(pixels.element(plane)) for plane in within(np.ones((2, *problem.shape), np.float32))
    )
    slope = odl.BroadcastOperator(ahead * x - v1_exists * v1, down * x - v2_exists * v2)
    curvature = odl.BroadcastOperator(back * v1, up * v2, mixed * (up * v1 + back * v2))
    present = np.isfinite(problem.layers)
    masks = [odl.MultiplyOperator(pixels.element(layer.astype(np.float32))) * x for layer in present]
    deviation = problem.lam * odl.functionals.L1Norm(pixels)
    data = [deviation.translated(pixels.element(layer)) for layer in np.where(present, problem.layers, np.float32(0))]
    norms = [
        problem.regulariser.alpha1 * odl.functionals.GroupL1Norm(slope.range),
        problem.regulariser.alpha0 * odl.functionals.GroupL1Norm(curvature.range),
    ]
    return odl.BroadcastOperator(slope, curvature, *masks), [*norms, *data]


SOLVERS: dict[str, Callable[[TgvProblem, float], SolverAtWork]] = {
    "ours": Ours,
    "thesis": Thesis,
    "pyproximal": PyproximalStacked,
    "pyproximal-tuned": PyproximalTuned,
    "odl": Odl,
}
NEEDS = {"pyproximal": "pyproximal", "pyproximal-tuned": "pyproximal", "odl": "odl"}  # the package of a peer
