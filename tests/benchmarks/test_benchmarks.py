"""The benchmarks run from end to end at the smallest size, and the solvers that they compare solve the same problem."""

from importlib.util import find_spec
import json

import numpy as np
import pytest

from benchmarks import bayes_gibbs, fusion_baselines, fusion_problem, fusion_scaling, fusion_solver, fusion_solvers, measure


@pytest.fixture(scope="module")
def problem():
    scene = fusion_problem.open_scene(count=3, shape=(24, 32))
    return fusion_problem.pose(scene.views, scene.reference, inverse=False)


def skip_without(package):
    if find_spec(package) is None:
        pytest.skip(f"{package} is not installed")


@pytest.mark.parametrize("solver", fusion_solvers.SOLVERS)
def test_every_solver_comes_to_the_same_energy(problem, solver):
    skip_without(fusion_solvers.NEEDS.get(solver, "numpy"))
    best = fusion_solvers.Ours(problem)
    best.run(4000)
    at_work = fusion_solvers.SOLVERS[solver](problem, 3.0)
    for _ in range(3):
        at_work.run(200)
    assert problem.energy(*at_work.solution()) == pytest.approx(problem.energy(*best.solution()), rel=4e-3)


def test_the_energy_of_the_benchmark_is_that_of_the_solver(problem):
    ours = fusion_solvers.Ours(problem)
    ours.run(30)
    expected = ours.iterate.energy(ours.fidelity, problem.regulariser)
    assert problem.energy(*ours.solution()) == pytest.approx(expected, rel=1e-5)


def test_a_run_of_pieces_is_one_run(problem):
    pieces, whole = fusion_solvers.Thesis(problem, 1.0), fusion_solvers.Thesis(problem, 1.0)
    for _ in range(3):
        pieces.run(5)
    whole.run(15)
    np.testing.assert_array_equal(pieces.solution()[0], whole.solution()[0])


def test_memory_of_a_fresh_process_is_its_own():
    """Not that of the parent at the moment of the fork."""
    ballast = np.ones(30_000_000)
    assert measure.isolated("benchmarks.measure:peak_memory", 1) < ballast.nbytes / 1e6


def test_an_exponent_is_that_of_the_law():
    assert fusion_scaling._slope([1, 2, 8], [3, 12, 192]) == pytest.approx(2)


@pytest.mark.slow
def test_the_comparison_of_solvers_has_all_its_rows(tmp_path):
    fusion_solver.main(["--size", "64", "48", "--count", "3", "--iterations", "20", "--output", str(tmp_path)])
    tables = json.loads((tmp_path / "fusion_solver.json").read_text())["tables"]
    solvers, start, baselines = tables.values()
    here = [
        name for name, (solver, _) in fusion_solver.ROWS.items() if find_spec(fusion_solvers.NEEDS.get(solver, "numpy"))
    ]
    assert [row["solver"] for row in solvers] == here
    assert all(row["ms / iteration"] > 0 for row in solvers)
    assert [row["threads"] for row in start] == [1, 1, 2, 2] and all(
        row["found"] <= row["restricted gap asked for"] for row in start
    )
    methods = {row["method"] for row in baselines}
    assert methods <= set(fusion_baselines.METHODS) and {"ipcli l1-adapt", "ipcli tgv-l1", "median"} <= methods
    assert all(f"| {name} |" in (tmp_path / "fusion_solver.md").read_text() for name in here)


@pytest.mark.slow
def test_the_growth_has_all_its_rows(tmp_path):
    fusion_scaling.main(["--pixels", "0.003", "0.006", "--observations", "3", "--output", str(tmp_path)])
    cases, growth, bandwidth, tiled = json.loads((tmp_path / "fusion_scaling.json").read_text())["tables"].values()
    assert [(row["Mpx"], row["K"]) for row in tiled] == [(0.006, 3)] and tiled[0]["mean error, 1e-3"] < 30
    assert [(row["Mpx"], row["K"], row["threads"]) for row in cases] == [
        (0.003, 3, 1),
        (0.003, 3, 2),
        (0.006, 3, 1),
        (0.006, 3, 2),
    ]
    assert not any("failed" in row for row in cases)
    assert len(growth) == 6 and [row["threads"] for row in bandwidth] == [1, 2]


@pytest.mark.slow
def test_the_mixtures_have_all_their_rows_and_ours_finds_the_planted_clusters(tmp_path):
    bayes_gibbs.main(["--quick", "--output", str(tmp_path)])
    case, many, density = json.loads((tmp_path / "bayes_gibbs.json").read_text())["tables"].values()
    rows = {row["method"]: row for row in case}
    assert not any("failed" in row for row in case)
    assert rows["ipcli, whole fit"]["VI to the truth"] < 0.2
    assert [row["executor"] for row in many] == ["serial", "processes:2"]
    assert [row["draws"] for row in density] == list(bayes_gibbs.DRAWS)
