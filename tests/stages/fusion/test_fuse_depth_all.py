"""fuse-depth --all: every view of a sequence in turn, anywhere, again only what is missing."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from ipcli.cli.main import main
from ipcli.errors import ParameterError
from ipcli.executor import ItemsFailed
from ipcli.inverse.regularize.parameters import Solver
from ipcli.io.files import h5
from ipcli.models.fusion.parameters import Fusion
from ipcli.params import Run
from ipcli.stages.fusion import fuse_depth
from ipcli.stages.fusion.parameters import FuseDepth
from ipcli.stages.kit.artefact import Outcome
from tests.fixtures.fusion_scenes import scene, write

EACH = FuseDepth(every=True, window=3, fusion=Fusion(solver=Solver(iterations=40), rounds=1))


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    return write(tmp_path_factory.mktemp("views") / "scene.views.h5", scene())


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.glob("*.h5")}


@pytest.fixture(scope="module")
def whole(source, tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    outcomes = fuse_depth.run_all(source, folder, EACH, Run())
    assert outcomes == {folder / f"0{i}.fused.h5": Outcome.DONE for i in range(5)}
    return folder


def plain_folder(path, views):
    """The views as a plain folder, a file each, so that one can be broken."""
    (path / "depth").mkdir(parents=True)
    for view in views:
        np.save(path / "depth" / f"{view.name}.npy", view.depth)
    poses = [" ".join([view.name, *map(str, view.cam_from_world[:3].ravel())]) for view in views]
    (path / "poses.txt").write_text("\n".join(poses) + "\n")
    k = views[0].intrinsics
    given = (k[0, 0], k[1, 1], k[0, 2], k[1, 2])
    hints = {"format": "folder", "unit": "m", "pose": "cam_from_world", "intrinsics": tuple(map(float, given))}
    return replace(EACH, source=replace(EACH.source, **hints))


def test_each_file_is_what_its_view_alone_as_reference_gives(source, whole, tmp_path):
    single = replace(EACH, every=False, reference="03")
    fuse_depth.run(source, tmp_path / "03.fused.h5", single, Run())
    assert (tmp_path / "03.fused.h5").read_bytes() == contents(whole)["03.fused.h5"]
    for i, names in enumerate(["012", "012", "123", "234", "234"]):
        assert list(h5.read(whole / f"0{i}.fused.h5", "fused-depth").arrays["views"]) == [f"0{name}" for name in names]


def test_processes_give_the_bytes_of_serial(source, whole, tmp_path):
    fuse_depth.run_all(source, tmp_path, EACH, Run(executor="processes:2"))
    assert contents(tmp_path) == contents(whole)


def test_a_second_run_makes_only_what_is_missing(source, whole):
    before = contents(whole)
    made = {path: path.stat().st_mtime_ns for path in whole.glob("*.h5")}
    lost = whole / "02.fused.h5"
    lost.unlink()
    outcomes = fuse_depth.run_all(source, whole, EACH, Run())
    assert {path for path, outcome in outcomes.items() if outcome is Outcome.DONE} == {lost}
    assert contents(whole) == before
    assert {path for path in made if path.stat().st_mtime_ns != made[path]} == {lost}


def test_a_step_leaves_views_out_as_references_and_changes_nothing_else(source, whole, tmp_path):
    fuse_depth.run_all(source, tmp_path, replace(EACH, step=2), Run())
    assert contents(tmp_path) == {name: data for name, data in contents(whole).items() if name[1] in "024"}


def test_a_broken_file_fails_only_the_windows_it_is_in_and_repaired_only_those_are_made(tmp_path):
    views = scene(6)
    each = replace(plain_folder(tmp_path / "in", views), step=4)  # windows 00 01 02 and 03 04 05
    broken = tmp_path / "in" / "depth" / "04.npy"
    sound = broken.read_bytes()
    broken.write_bytes(sound[:100])
    with pytest.raises(ItemsFailed, match="1 of 2 items failed .*04.npy") as caught:
        fuse_depth.run_all(tmp_path / "in", tmp_path / "out", each, Run())
    assert list(caught.value.failed) == ["04"]
    assert set(contents(tmp_path / "out")) == {"00.fused.h5"}
    broken.write_bytes(sound)
    outcomes = fuse_depth.run_all(tmp_path / "in", tmp_path / "out", each, Run())
    assert list(outcomes.values()) == [Outcome.UP_TO_DATE, Outcome.DONE]


@pytest.mark.parametrize("change", [{"reference": "01"}, {"camera": "c.toml"}])
def test_all_views_and_one_exclude_each_other(source, tmp_path, change):
    with pytest.raises(ParameterError, match="leave out --reference and --camera"):
        fuse_depth.run_all(source, tmp_path, replace(EACH, **change), Run())


def test_a_step_needs_all(source, tmp_path):
    with pytest.raises(ParameterError, match="--step goes with --all"):
        fuse_depth.run(source, tmp_path / "x.h5", replace(EACH, every=False, step=2), Run())


def test_the_command_line_prints_the_folder_or_each_outcome_and_ends_with_1_if_one_failed(source, tmp_path, capsys):
    arguments = [
        "fuse-depth",
        str(source),
        "--all",
        "--window",
        "3",
        "--step",
        "2",
        "-o",
        str(tmp_path / "out"),
        "--method",
        "median",
    ]
    assert main(arguments) == 0
    assert capsys.readouterr().out.startswith(f"{tmp_path / 'out'}\noutputs: 3 done\nnoise: ")
    assert main([*arguments, "--json", "-q"]) == 0
    told = json.loads(capsys.readouterr().out)["outputs"]
    assert told == {str(tmp_path / "out" / f"0{i}.fused.h5"): "up to date" for i in (0, 2, 4)}
    (tmp_path / "out" / "02.fused.h5").write_bytes(b"something else")
    (tmp_path / "out" / "04.fused.h5").unlink()
    assert main([*arguments, "-q"]) == 1
    error = capsys.readouterr().err
    assert error.startswith("Error: 1 of 3 items failed (02: ")
    assert (tmp_path / "out" / "04.fused.h5").exists()


def test_the_maps_of_a_sequence_are_summed_up(whole):
    paths = sorted(whole.glob("*.h5"))
    told = fuse_depth.summary_of_all(whole, dict.fromkeys(paths, Outcome.UP_TO_DATE))
    scales = [float(h5.read(path, "fused-depth").arrays["noise_scale"]) for path in paths]
    assert told["noise"].value["scale"] == pytest.approx(np.mean(scales))
    assert str(told["outputs"]) == "5 up to date"
    assert f"{min(scales):.3g} to {max(scales):.3g}" in str(told["noise"])
    assert 0.9 < told["observed"].value <= 1
    assert list(fuse_depth.summary_of_all(whole, {whole / "none.h5": Outcome.WOULD_RUN})) == ["output", "outputs"]
