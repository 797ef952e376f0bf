"""Solvers of one energy: Gauss-Newton against SciPy's L-BFGS, and the convex refinement, whose terms differ.

python -m benchmarks.brdf.solvers             a vase of 32 and of 72 pixels
python -m benchmarks.brdf.solvers --quick     one of 24
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from benchmarks.kit.arguments import parser_of
from benchmarks.kit.measure import Clock, isolated
from benchmarks.kit.publish import publish
from ipcli.models.brdf import energy, evaluation, refine, solid
from ipcli.models.brdf.energy import ShadedProblem
from ipcli.models.brdf.light import key_and_fill
from ipcli.models.brdf.materials import Plastic
from ipcli.models.brdf.parameters import Refinement, Solid
from ipcli.models.brdf.reflectance import Map, charts
from ipcli.models.brdf.scenes import cropped, photograph
from ipcli.models.brdf.surfaces import ImplicitSurface, march

SIDES, QUICK_SIDES = (32, 72), (24,)
STEPS = (2, 4, 8, 16, 32)  # of Gauss-Newton
ITERATIONS = (64, 128, 256, 512, 1024, 2048)  # of L-BFGS
NEAR = 1.01  # times the least energy that any of them finds
RED = Plastic((0.45, 0.06, 0.05), 1.5, 0.3)

Solve = Callable[[int], np.ndarray]  # heights (n,) after so many steps


def solvers(side: int) -> list[dict[str, Any]]:
    """A row a solver: energy and error in the end, and what it took to come within NEAR of the least of all."""
    made, problem, reflects, omega = case(side)
    ours = path(lambda n: energy.gauss_newton(problem, reflects, omega, problem.prior, n), STEPS)
    peer = path(lambda n: lbfgs(problem, reflects, omega, n), ITERATIONS)
    convex = path(lambda _: tgv(problem, reflects, omega), (Refinement().iterations * Refinement().rounds,))
    found = {"Gauss-Newton": ours, "L-BFGS (SciPy)": peer, "convex, with TGV": convex}
    energies = {name: [energy.energy(problem, reflects, omega, z) for _, _, z in line] for name, line in found.items()}
    least = min(min(values) for values in energies.values())
    rows: list[dict[str, Any]] = []
    for name, line in found.items():
        there = [k for k, value in enumerate(energies[name]) if value <= NEAR * least]
        steps, seconds, _ = line[there[0] if there else -1]
        row = {"pixels": side, "solver": name, "energy": energies[name][-1], "N-MAE [rad]": error(line[-1][2], made)}
        rows.append(row | {"near the least": "yes" if there else "no", "steps": steps, "CPU s": seconds})
    return [row | {"times": row["CPU s"] / rows[0]["CPU s"]} for row in rows]


def case(side: int) -> tuple[ImplicitSurface, ShadedProblem, Map, float]:
    """A vase of coated plastic; given the map that self-calibration finds, the problem and the weight of shading."""
    from experiments.brdf import scenes

    made = cropped(march(scenes.solids()["vase"], side))
    rng = np.random.default_rng(0)
    taken = photograph(made, charts(RED, [key_and_fill(rng)], coarse=17)[0], rng)
    picture = solid.pictured(taken, made.mask, max(made.mask.shape))
    found = solid.solid(picture, Solid(albedos=1))
    n0 = energy.cell_normals(picture.grid, picture.inflated)
    problem = ShadedProblem(picture.grid, picture.intensity, picture.inflated, n0, Solid().weights)
    return made, problem, found.reflectance, found.omega


def path(solve: Solve, counts: Sequence[int]) -> list[tuple[int, float, np.ndarray]]:
    """For each number of steps, from the start each time: that number, the processor's seconds and the heights (n,)."""
    clock, found = Clock(), []
    for count in counts:
        with clock:
            heights = solve(count)
        found.append((count, clock.processor, heights))
    return found


def lbfgs(problem: ShadedProblem, reflects: Map, omega: float, iterations: int) -> np.ndarray:
    """The same energy by its exact gradient alone."""
    from scipy.optimize import minimize

    def smooth(heights: np.ndarray) -> tuple[float, np.ndarray]:
        here = energy.linearise(problem, reflects, omega, heights)
        return here.energy, here.gradient

    options = {"maxiter": iterations, "maxfun": 10 * iterations, "ftol": 0.0, "gtol": 0.0, "maxcor": 20}
    return np.asarray(minimize(smooth, problem.prior, jac=True, method="L-BFGS-B", options=options).x)


def tgv(problem: ShadedProblem, reflects: Map, omega: float) -> np.ndarray:
    """The convex refinement from the same start, with the weights that `--refine convex` gives it."""
    grid, weights = problem.grid, Refinement()
    height = grid.image(problem.prior, 0.0)
    pixels = np.nan_to_num(grid.to_pixels(problem.intensity))
    params = Refinement(normal=problem.weights.normal, photo=omega * weights.photo)
    prior = refine.forward_normals(height, grid.mask)
    return refine.refine(height, prior, grid.image(pixels, 0.0), grid.mask, reflects, params)[grid.mask]


def error(heights: np.ndarray, made: ImplicitSurface) -> float:
    """N-MAE of heights (n,)."""
    image = np.full(made.mask.shape, np.nan)
    image[made.mask] = heights
    return evaluation.errors(image, made.mask, made.normals, None)[0]


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, write and print."""
    given = parser_of(__doc__, "a small object").parse_args(arguments)
    sides = QUICK_SIDES if given.quick else SIDES
    rows = [row for side in sides for row in isolated("benchmarks.brdf.solvers:solvers", 1, side=side)]
    publish("brdf_solvers", "Solvers of the energy of a surface", {"Solvers": rows}, {"threads": 1}, given.output)


if __name__ == "__main__":
    main()
