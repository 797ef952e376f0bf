"""The benchmarks run from end to end at the smallest size, and the solvers that they compare solve the same problem."""

import json
from dataclasses import replace
from importlib.util import find_spec

import numpy as np
import pytest

from benchmarks.fusion import baselines, cloud, problem, scaling, scene, shifts, solver, solvers, tiles, tsdf
from ipcli.io.files import h5
from ipcli.io.views import artefact
from ipcli.measurements.views import View
from tests.fixtures import fusion_scenes


@pytest.fixture(scope="module")
def posed():
    scene = problem.open_scene(count=3, shape=(24, 32))
    return problem.pose(scene.views, scene.reference, inverse=False)


def skip_without(package):
    if find_spec(package) is None:
        pytest.skip(f"{package} is not installed")


@pytest.mark.parametrize("solver", solvers.SOLVERS)
def test_every_solver_comes_to_the_same_energy(posed, solver):
    skip_without(solvers.NEEDS.get(solver, "numpy"))
    best = solvers.Ours(posed)
    best.run(4000)
    at_work = solvers.SOLVERS[solver](posed, 3.0)
    for _ in range(3):
        at_work.run(200)
    assert posed.energy(*at_work.solution()) == pytest.approx(posed.energy(*best.solution()), rel=4e-3)


def test_the_energy_of_the_benchmark_is_that_of_the_solver(posed):
    ours = solvers.Ours(posed)
    ours.run(30)
    expected = ours.iterate.energy(ours.fidelity, posed.regulariser)
    assert posed.energy(*ours.solution()) == pytest.approx(expected, rel=1e-5)


def test_a_run_of_pieces_is_one_run(posed):
    pieces, whole = solvers.Thesis(posed, 1.0), solvers.Thesis(posed, 1.0)
    for _ in range(3):
        pieces.run(5)
    whole.run(15)
    np.testing.assert_array_equal(pieces.solution()[0], whole.solution()[0])


@pytest.mark.slow
def test_the_comparison_of_solvers_has_all_its_rows(tmp_path):
    solver.main(["--size", "64", "48", "--count", "3", "--iterations", "20", "--output", str(tmp_path)])
    tables = json.loads((tmp_path / "fusion_solver.json").read_text())["tables"]
    rows, start = tables.values()
    here = [name for name, (kind, _) in solver.ROWS.items() if find_spec(solvers.NEEDS.get(kind, "numpy"))]
    assert [row["solver"] for row in rows] == here
    assert all(row["ms / iteration"] > 0 for row in rows)
    assert [row["threads"] for row in start] == [1, 1, 2, 2]
    assert all(row["found"] <= row["restricted gap asked for"] for row in start)
    for column, name in (("times ours, 1 thread", "ipcli, 1 thread"), ("times ours, 2 threads", "ipcli, 2 threads")):
        assert next(row[column] for row in rows if row["solver"] == name) == 1
    assert all(f"| {name} |" in (tmp_path / "fusion_solver.md").read_text() for name in here)


def test_the_volume_of_clean_views_is_the_surface_they_see():
    """Neither half a pixel nor half a voxel off."""
    views = [replace(view, depth=view.truth) for view in scene.views(3, (60, 80))]
    grid = tsdf.volume(views, 0.03, 4.0)
    error = tsdf.depth(grid, views[1], 1.0) - views[1].truth
    assert np.isfinite(error).mean() > 0.9
    assert abs(np.nanmedian(error)) < 0.001
    assert np.nanmedian(np.abs(error)) < 0.003
    assert not len(tsdf.points(grid, 9.0, 0.01))
    assert np.isnan(tsdf.depth(grid, views[1], 9.0)).all()
    normals, offsets = scene.PLANES[:, :3], scene.PLANES[:, 3]
    distance = np.abs((offsets - tsdf.points(grid, 1.0, 0.01) @ normals.T) / np.linalg.norm(normals, axis=1)).min(
        axis=1
    )
    on_a_plane = distance < 0.02
    assert on_a_plane.mean() > 0.5
    assert np.median(distance[on_a_plane]) < 0.002


def test_errors_are_taken_where_all_full_maps_have_a_value():
    truth = np.ones((10, 10), np.float32)
    good, holed, empty = (np.full((10, 10), value, np.float32) for value in (1.002, 1.001, 1.0))
    good[0], holed[1, :5], empty[2:] = 2.0, np.nan, np.nan
    good[1, :5] = 3.0
    found = {"good": [(1.0, good)], "holed": [(1.0, holed), (1.0, empty)]}
    rows = baselines.errors(found, truth)
    assert rows["good"][0]["MAE"] == pytest.approx((10 * 1000 + 85 * 2) / 95, rel=1e-3)
    assert rows["holed"][0]["MAE"] == pytest.approx(1, rel=1e-3)
    assert np.isnan(rows["holed"][1]["MAE"])
    assert rows["holed"][0]["density %"] == pytest.approx(95)


@pytest.mark.slow
def test_the_baselines_are_tuned_on_one_scene_and_reported_on_others(tmp_path):
    baselines.main(["--size", "64", "48", "--count", "3", "--output", str(tmp_path)])
    found = json.loads((tmp_path / "fusion_baselines.json").read_text())
    report, tuning = found["tables"].values()
    here = [name for name, method in baselines.METHODS.items() if find_spec(method.package)]
    assert [row["method"] for row in report] == here
    assert len(tuning) == sum(len(baselines.METHODS[name].settings()) for name in here)
    assert [row["method"] for row in tuning if row["taken"]] == here
    assert "seed 1" in found["facts"]["tuned on"]
    assert "seed 1" not in found["facts"]["reported on"]
    rows = {row["method"]: row for row in report}
    assert rows["ipcli l1-adapt"]["MAE"] < rows["median"]["MAE"]
    assert rows["median"]["MAE, deviation"] > 0


def test_precision_and_recall_of_a_cloud_are_those_of_its_points():
    """Half of the truth, the other half of it 20 mm nearer from where it is."""
    view = scene.views(1, (48, 64))[0]
    truth = cloud.TrueSurface([view])
    there, away = (
        truth.sample[::2],
        truth.sample[1::2] * (1 - 0.02 / np.linalg.norm(truth.sample[1::2], axis=1, keepdims=True)),
    )
    assert len(truth.sample) == 48 * 64
    assert truth.judge(truth.sample)["F-score %"] == pytest.approx(100)
    assert truth.judge(truth.sample)["mean"] == pytest.approx(0, abs=1e-3)
    half = truth.judge(there)
    assert half["precision %"] == 100
    assert half["median"] == pytest.approx(0, abs=1e-3)
    mixed = truth.judge(np.concatenate([there, away]))
    assert mixed["precision %"] == pytest.approx(50, abs=2)
    p, r = mixed["precision %"], mixed["recall %"]
    assert mixed["F-score %"] == pytest.approx(2 * p * r / (p + r))
    assert truth.judge(np.empty((0, 3)))["F-score %"] == 0


@pytest.mark.slow
def test_clouds_of_a_sequence_have_all_their_rows(tmp_path, monkeypatch):
    skip_without("open3d")
    monkeypatch.setattr(cloud, "GRIDS", dict.fromkeys(cloud.GRIDS, ((0.04, 0.08), (4.0,), (1.0, 3.0))))
    for name, seed in (("development", 1), ("report", 2)):
        arrays = artefact.views_arrays(scene.views(6, (48, 64), seed), unit="m", measured="depth")
        h5.write(tmp_path / f"{name}.views.h5", "views", arrays, {})
    files = ["--tune", str(tmp_path / "development.views.h5"), "--views", str(tmp_path / "report.views.h5")]
    cloud.main([*files, "--window", "3", "--step", "1", "--output", str(tmp_path)])
    rows, *tuning = json.loads((tmp_path / "fusion_cloud.json").read_text())["tables"].values()
    assert [row["method"] for row in rows] == ["ipcli", cloud.VIEWS, cloud.MAPS]
    assert all(0 < row["F-score %"] <= 100 and row["seconds"] > 0 for row in rows)
    assert [len(table) for table in tuning] == [4, 4]


@pytest.mark.slow
def test_the_growth_has_all_its_rows(tmp_path):
    scaling.main(["--pixels", "0.003", "0.006", "--observations", "3", "--output", str(tmp_path)])
    cases, growth, bandwidth, tiled = json.loads((tmp_path / "fusion_scaling.json").read_text())["tables"].values()
    assert [(row["Mpx"], row["K"]) for row in tiled] == [(0.006, 3)]
    assert tiled[0]["mean error, 1e-3"] < 30
    assert [(row["Mpx"], row["K"], row["threads"]) for row in cases] == [
        (0.003, 3, 1),
        (0.003, 3, 2),
        (0.006, 3, 1),
        (0.006, 3, 2),
    ]
    assert not any("failed" in row for row in cases)
    assert len(growth) == 6
    assert [row["threads"] for row in bandwidth] == [1, 2]


def test_the_gains_of_shifted_poses_are_those_that_the_warning_goes_by(tmp_path):
    intrinsics, views = fusion_scenes.camera((60, 80)), []
    turns = np.random.default_rng(0).normal(0, 0.06, 16)  # a camera that moves evenly shows no shift
    for k, turn in enumerate(turns):
        pose = fusion_scenes.pose_at((0.05 * k, 0.0, 0.0), turn)
        depth = fusion_scenes.cast((60, 80), intrinsics, pose).astype(np.float32)
        views.append(View(f"{k:02d}", depth, intrinsics, pose))
    found = shifts.row(views[:8], 1)
    assert found["sound, greatest"] < 1 < found["shifted, least"]
    assert 0.8 < found["shifted, warned of"] <= 1
    h5.write(tmp_path / "a.views.h5", "views", artefact.views_arrays(views, unit="m", measured="depth"), {})
    shifts.main([str(tmp_path / "a.views.h5"), "--quick", "--output", str(tmp_path)])
    (rows,) = json.loads((tmp_path / "fusion_shifts.json").read_text())["tables"].values()
    assert [row["every"] for row in rows] == [3]


def test_a_map_in_tiles_stands_beside_that_at_once():
    whole, tiled = tiles.rows_of((60, 80), (32,))
    assert (whole["side"], tiled["side"]) == (0, 32)
    assert tiled["apart, median"] <= tiled["99 %"] <= tiled["greatest"]
    assert tiled["apart, median"] < 0.1
    assert tiled["error"] == pytest.approx(whole["error"], rel=0.1)
    assert tiled["views read, times"] > 1
