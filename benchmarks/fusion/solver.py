"""Solvers for the fusion of depth maps side by side.

    python -m benchmarks.fusion.solver [--views FILE.h5] [--quick]

Each solver minimises the same energy from the same start, in its own process; see README.md for what the tables say.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.fusion.problem import TgvProblem, open_scene, pose
from benchmarks.fusion.solvers import NEEDS, RATIOS, SOLVERS
from benchmarks.kit.arguments import add_generated, parser_of, size_of
from benchmarks.kit.measure import Clock, forget_peak, installed, isolated, peak_memory
from benchmarks.kit.publish import publish, save, say

FIRST_LOOKS = (10, 20, 30, 40, 50, 70, 100, 130, 160, 200, 250, 300, 400, 500, 600, 700, 850)
LOOKS = (*FIRST_LOOKS, 1000, 1300, 1600, 2000, 2500, 3000)  # iterations after which the energy is taken
SHOWN = (100, 300, 1000)  # iterations
TARGETS = (1e-2, 1e-3)  # relative energy gaps
TUNING = {"size": 160, "iterations": 300}  # the crop on which a step ratio is chosen, and for how many iterations
REFERENCE = 4000  # iterations for the best known minimum
ROWS = {  # name: (solver, threads)
    "ipcli, 2 threads": ("ours", 2),
    "ipcli, 1 thread": ("ours", 1),
    "thesis Algorithm 4.3, NumPy": ("thesis", 2),
    "pyproximal, stacked operators": ("pyproximal", 2),
    "pyproximal, sparse matrix, our prox": ("pyproximal-tuned", 2),
    "ODL pdhg": ("odl", 2),
}


def best_ratio(path: str, solver: str, size: int, iterations: int) -> float:
    """The step ratio with the lowest energy on a crop of the problem."""
    crop = TgvProblem.load(Path(path)).crop(size)

    def energy(ratio: float) -> float:
        at_work = SOLVERS[solver](crop, ratio)
        at_work.run(iterations)
        return crop.energy(*at_work.solution())

    return min(RATIOS, key=energy)


def solve(path: str, solver: str, ratio: float | None, iterations: int) -> dict[str, Any]:
    """Iterations, seconds and energy at each look, and peak memory above that of the data, in MB.

    `ratio` is None for ours, which chooses its steps itself.
    """
    problem = TgvProblem.load(Path(path))
    SOLVERS[solver](problem.crop(64), ratio or 1.0).run(20)  # compiles, imports
    before = forget_peak()
    at_work, clock, done, curve = SOLVERS[solver](problem, ratio or 1.0), Clock(), 0, []
    peaks = []  # the first is the one that holds: afterwards the energy has taken memory of its own
    for look in [look for look in LOOKS if look <= iterations]:
        with clock:
            at_work.run(look - done)
        peaks.append(peak_memory() - before)
        curve.append((look, clock.last / (look - done), clock.total, problem.energy(*at_work.solution())))
        done = look
    return {"curve": curve, "memory": peaks[0]}


def reference(path: str, iterations: int) -> dict[str, float]:
    """The lowest energy that our solver finds from the coarse-to-fine start, and its lower bound."""
    from ipcli.inverse.regularize.parameters import Solver

    problem = TgvProblem.load(Path(path))
    iterate, fidelity = _from_coarse(problem)
    energies, bounds = [], []
    for _ in range(8):
        iterate.advance(fidelity, problem.regulariser, Solver(), [Solver().relaxation] * (iterations // 8) + [1.0])
        energies.append(problem.energy(iterate.x, iterate.v))
        bounds.append(iterate.bound(fidelity, problem.regulariser, *fidelity.data.bounds))
    return {"energy": min(energies), "bound": max(bounds)}


def certified(path: str, tolerance: float) -> dict[str, float]:
    """Iterations and seconds, looks included, from the coarse-to-fine start to a small restricted gap."""
    from dataclasses import replace

    from ipcli.inverse.regularize import tgv
    from ipcli.inverse.regularize.parameters import Solver

    problem = TgvProblem.load(Path(path))
    solver = replace(Solver(), tolerance=tolerance, iterations=5000)
    _from_coarse(problem.crop(128))[0]
    start, descent = Clock(), Clock()
    with start:
        iterate, fidelity = _from_coarse(problem)
    with descent:
        looks = tgv.minimise(fidelity, problem.regulariser, iterate, fidelity.data.bounds, solver)
    found = {"iterations": looks[-1].iteration, "gap": looks[-1].gap, "energy": problem.energy(iterate.x, iterate.v)}
    return found | {"start": start.total, "descent": descent.total}


def _from_coarse(problem: TgvProblem):
    from ipcli.inverse.regularize.fidelity import AbsoluteDeviations, Observations
    from ipcli.inverse.regularize.parameters import Solver
    from ipcli.models.fusion.pyramid import start

    fidelity = AbsoluteDeviations(
        Observations.of(list(problem.layers)), np.full(problem.shape, problem.lam, np.float32)
    )
    iterate = start(problem.layers, problem.lam, problem.regulariser, Solver(), Solver().levels)
    return iterate, fidelity


def race(path: Path, iterations: int) -> Iterator[tuple[str, dict[str, Any]]]:
    """What `solve` found for each row of the table, with its step ratio, as soon as it is known."""
    ratios: dict[str, float | None] = {"ours": None}
    for name, (solver, threads) in ROWS.items():
        if not installed(name, NEEDS.get(solver, "ipcli")):
            continue
        say(name)
        if solver not in ratios:
            tuning = TUNING | {"iterations": min(TUNING["iterations"], iterations)}
            ratios[solver] = isolated(
                "benchmarks.fusion.solver:best_ratio", threads, path=str(path), solver=solver, **tuning
            )
        settings = {"path": str(path), "solver": solver, "ratio": ratios[solver], "iterations": iterations}
        yield name, isolated("benchmarks.fusion.solver:solve", threads, **settings) | {"ratio": ratios[solver]}


def rows_of(runs: dict[str, dict[str, Any]], lowest: float) -> list[dict[str, Any]]:
    """The table of the solvers; gaps are relative to the lowest energy known."""
    ours = {
        f"times ours, {threads} thread{'s' * (threads > 1)}": _milliseconds(runs[name])
        for name, (solver, threads) in ROWS.items()
        if solver == "ours" and name in runs
    }
    return [_row(name, run, lowest, ours) for name, run in runs.items()]


def _row(name: str, run: dict[str, Any], lowest: float, ours: dict[str, float]) -> dict[str, Any]:
    curve = [(look, total, energy / lowest - 1) for look, _, total, energy in run["curve"]]
    own = _milliseconds(run)
    row: dict[str, Any] = {"solver": name, "step ratio": run["ratio"] or "own", "ms / iteration": own}
    row |= {column: own / milliseconds for column, milliseconds in ours.items()}
    row |= {f"gap at {look}": next((gap for n, _, gap in curve if n == look), None) for look in SHOWN}
    for target in TARGETS:
        n, seconds = _reached(curve, target)
        row |= {
            f"iterations to {target:g}": n or f"> {curve[-1][0]}",
            f"s to {target:g}": seconds or f"> {curve[-1][1]:.3g}",
        }
    return row | {"peak MB": run["memory"]}


def _milliseconds(run: dict[str, Any]) -> float:
    return 1e3 * float(np.median([seconds for _, seconds, _, _ in run["curve"]]))


def _reached(curve: list[tuple[int, float, float]], target: float) -> tuple[int | None, float | None]:
    """Iterations and seconds from which on the gap stays below the target."""
    above = [index for index, (_, _, gap) in enumerate(curve) if gap > target]
    first = above[-1] + 1 if above else 0
    return curve[first][:2] if first < len(curve) else (None, None)


def start_rows(path: Path, lowest: float) -> list[dict[str, Any]]:
    """From the coarse-to-fine start to a certified gap, for 1 and 2 threads."""
    rows = []
    for threads in (1, 2):
        for tolerance in (1e-3, 1e-4):
            say(f"certified gap {tolerance:g}, threads: {threads}")
            found = isolated("benchmarks.fusion.solver:certified", threads, path=str(path), tolerance=tolerance)
            row = {"threads": threads, "restricted gap asked for": tolerance, "found": found["gap"]}
            row |= {"true gap": found["energy"] / lowest - 1, "fine iterations": found["iterations"]}
            rows.append(row | {"s, coarse levels and sorting": found["start"], "s, fine level": found["descent"]})
    return rows


def main(arguments: list[str] | None = None) -> None:
    """Measure, write whatever is measured, print."""
    options = parse(arguments)
    views = str(options.views) if options.views else None
    scene = open_scene(views, options.reference, options.count, options.size[::-1])
    problem = pose(scene.views, scene.reference, inverse=scene.inverse)
    title, tables, runs = "Fusion: solvers", {}, {}
    with tempfile.TemporaryDirectory() as folder:
        path = problem.save(Path(folder) / "problem.npz")
        say("best known minimum")
        known = isolated("benchmarks.fusion.solver:reference", 2, path=str(path), iterations=REFERENCE)
        facts = {"scene": scene.name, "lambda": problem.lam, "step ratios tried for the others": str(RATIOS)}
        for name, run in race(path, options.iterations):
            runs[name] = run
            lowest = min(known["energy"], *(energy for run in runs.values() for *_, energy in run["curve"]))
            facts |= {"lowest energy known": lowest, "proven within": (lowest - known["bound"]) / lowest}
            tables["Solvers of one energy, from the median"] = rows_of(runs, lowest)
            save("fusion_solver", title, tables, facts, options.output)
        tables["ipcli from its coarse-to-fine start"] = start_rows(path, lowest)
    publish("fusion_solver", title, tables, facts, options.output)


def parse(arguments: list[str] | None) -> argparse.Namespace:
    """The command line; --quick is a quarter of the pixels and a third of the iterations."""
    parser = parser_of(__doc__, "320 240 and 300 unless given otherwise")
    parser.add_argument("--views", type=Path, help="a views artefact in place of the generated scene")
    parser.add_argument("--reference", help="its reference view; the middle one if not given")
    parser.add_argument("--iterations", type=int, help="of each solver; 1000")
    add_generated(parser)
    options = parser.parse_args(arguments)
    options.size = size_of(options)
    options.iterations = options.iterations or (300 if options.quick else 1000)
    return options


if __name__ == "__main__":
    main()
