"""fuse-depth from the command line: exit codes, and one line for whatever goes wrong."""

from __future__ import annotations

import json
import logging
from dataclasses import replace

import numpy as np
import pytest

from ipcli.cli.main import fuse_depth, main
from ipcli.io.files import h5
from tests.fixtures.fusion_scenes import damage, pose_at, scene, write

QUICK = ["--set", "fusion.solver.iterations=100", "--rounds", "1"]


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    return write(tmp_path_factory.mktemp("views") / "scene.views.h5", scene())


@pytest.fixture
def tell(tmp_path, capsys):
    """Run fuse-depth on a source; the exit code, stdout and stderr."""

    def run(source, *arguments):
        code = main(["fuse-depth", str(source), "-o", str(tmp_path / "out" / "x.fused.h5"), *QUICK, *arguments])
        return code, *capsys.readouterr()

    return run


def fails(told, code, *messages):
    """Exit code, nothing on stdout, and one line on stderr that holds the messages."""
    assert told[0] == code
    assert told[1] == ""
    assert told[2].count("\n") == 1
    assert told[2].startswith("Error: ")
    for message in messages:
        assert message in told[2]


def test_the_path_is_printed_first_with_the_figures_below_and_a_second_run_is_up_to_date(source, tell, tmp_path):
    output = tmp_path / "out" / "x.fused.h5"
    code, first, err = tell(source)
    assert (code, err, first.splitlines()[0]) == (0, "", str(output))
    assert "fused into: 02" in first
    assert {path.name for path in output.parent.iterdir()} == {
        "x.fused.h5",
        "x.fused.ply",
        "x.fused.html",
        "x.fused.run.json",
        "x.fused.turn.html",
    }
    code, out, err = tell(source)
    assert code == 0
    assert out == first
    assert {line.split(":")[0] for line in out.splitlines()[1:]} >= {"fused into", "noise", "overlap", "observed"}
    assert err == f"{output}: up to date\n"
    code, out, _ = tell(source, "--json")
    assert code == 0
    told = json.loads(out)
    assert (told["output"], told["fused_into"], told["views"]) == (str(output), "02", 5)
    fails(tell(source, "--lambda", "0.5"), 1, "--overwrite")
    assert tell(source, "--lambda", "0.5", "--overwrite")[0] == 0
    assert float(h5.read(output, "fused-depth").arrays["lambda"]) == 0.5


def test_the_console_script_is_the_same_command(source, tmp_path, capsys):
    assert fuse_depth([str(source), "-o", str(tmp_path / "x.h5"), *QUICK, "-n"]) == 0
    assert "run, since it does not exist" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_no_overlap_is_exit_3_with_every_view_in_one_line(tell, tmp_path):
    away = [replace(view, cam_from_world=pose_at((50.0 * i, 0, 0))) for i, view in enumerate(scene(3))]
    told = tell(write(tmp_path / "away.views.h5", away))
    fails(told, 3, "no view overlaps the reference view '01'", "00: ", "01: ", "02: ", "% valid, reaches 0.0 %")
    assert "direction of the poses" in told[2]
    assert not (tmp_path / "out").exists()


def test_no_depth_at_all_is_exit_3(tell, tmp_path):
    blind = [replace(view, depth=np.full_like(view.depth, np.nan)) for view in scene(2)]
    fails(tell(write(tmp_path / "blind.views.h5", blind)), 3, "no view has a valid depth")


@pytest.mark.parametrize(
    ("arguments", "messages"),
    [
        (["--reference", "2"], ["no view '2' among the 5 there are", "did you mean '02'?"]),
        (["--window", "-1"], ["window", "-1"]),
        (["--method", "tgv"], ["method", "tgv", "tgv-l1"]),
        (["--lambda", "much"], ["lam", "much"]),
        (["--set", "fusion.solver.iteration=3"], ["fusion.solver.iteration", "fusion.solver.iterations"]),
        (["--set", "fusion.regulariser.order=3"], ["fusion.regulariser.order", "3"]),
        (["--lamda", "1"], ["--lamda", "--lambda"]),
    ],
)
def test_wrong_usage_is_exit_2_and_names_what_was_meant(source, tell, arguments, messages):
    fails(tell(source, *arguments), 2, *messages)


def test_an_unknown_key_of_the_configuration_names_file_and_nearest_key(source, tell, tmp_path):
    config = tmp_path / "mine.toml"
    config.write_text("[fusion]\nmethods = 'tgv-l1'\n")
    fails(tell(source, "--config", str(config)), 2, "mine.toml", "fusion.methods", "fusion.method")


def test_a_flag_beats_the_environment_beats_the_configuration(source, tell, tmp_path, monkeypatch):
    config, output = tmp_path / "mine.toml", tmp_path / "out" / "x.fused.h5"
    config.write_text("reference = '00'\nwindow = 2\n[fusion]\nlam = 0.7\n")
    monkeypatch.setenv("IPCLI_WINDOW", "3")
    assert tell(source, "--config", str(config), "--reference", "01")[0] == 0
    found = h5.read(output, "fused-depth").arrays
    assert list(found["views"]) == ["00", "01", "02"]
    assert float(found["lambda"]) == 0.7


@pytest.mark.parametrize("share", [0.0, 0.3, 0.97])
def test_a_truncated_views_file_is_exit_1(source, tell, tmp_path, share):
    whole = source.read_bytes()
    broken = tmp_path / "broken.views.h5"
    broken.write_bytes(whole[: int(share * len(whole))])
    fails(tell(broken), 1, "broken.views.h5")


def test_a_file_that_is_not_there_and_one_of_another_kind_are_exit_1(source, tell, tmp_path):
    fails(tell(tmp_path / "nothing.h5"), 1, "nothing.h5: no such file")
    assert tell(source)[0] == 0
    fails(tell(tmp_path / "out" / "x.fused.h5", "--overwrite"), 1, "x.fused.h5", "depth", "views")


def test_a_pose_that_is_not_rigid_is_exit_1_and_names_the_view(tell, tmp_path):
    bad = damage(write(tmp_path / "bad.views.h5", scene(3)), "views/00/cam_from_world", np.diag([1.1, 1.1, 1.1, 1]))
    fails(tell(bad), 1, "views/00/cam_from_world", "a rigid pose")


def test_one_view_alone_and_a_window_of_one_are_fused(source, tell, tmp_path):
    assert tell(write(tmp_path / "one.views.h5", scene(1)))[0] == 0
    assert tell(source, "--window", "1", "--overwrite")[0] == 0


def test_quiet_is_quiet_and_verbose_tells_why_it_runs(source, tell):
    assert tell(source, "-q")[2] == ""
    assert "run, since --overwrite is given" in tell(source, "-v", "--overwrite")[2]
    logging.getLogger("ipcli").setLevel(logging.WARNING)
