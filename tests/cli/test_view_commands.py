"""import-views and kitti-views from the command line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from ipcli.cli.main import main
from ipcli.io.views import layouts

SHAPES = Path(__file__).parents[2] / "sample_data" / "shapes"


def test_import_views_writes_a_window_of_the_sample_and_prints_its_path(tmp_path, capsys):
    output = tmp_path / "x.views.h5"
    arguments = [
        "import-views",
        str(SHAPES),
        "-o",
        str(output),
        "--reference",
        "005",
        "--window",
        "3",
        "--noise",
        "gauss:0.01",
    ]
    assert main(arguments) == 0
    assert capsys.readouterr().out.splitlines()[:2] == [str(output), "views: 3"]
    sequence = layouts.open_views(output)
    assert sequence.names == ("004", "005", "006")
    assert sequence.load("005").truth is not None
    assert main([*arguments, "--json"]) == 0  # up to date
    told = json.loads(capsys.readouterr().out)
    assert told == {"output": str(output), "views": 3, "measured": "depth", "unit": str(sequence.unit)}


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["--views", "05"], 2, "no view '05' among the 11 there are; did you mean '005'?"),
        (["--noise", "much"], 2, "noise 'much': expected laplace:SCALE"),
        (["--depth-scale", "-1"], 2, "source.depth_scale"),
        (["--set", "source.depth=geometric"], 2, "'depth' means nothing to depth/ and poses.txt"),
        (["--format", "tum"], 1, "depth.txt: no such file"),
    ],
)
def test_import_views_fails_in_one_line_with_the_right_code(tmp_path, capsys, arguments, code, message):
    assert main(["import-views", str(SHAPES), "-o", str(tmp_path / "x.h5"), *arguments]) == code
    captured = capsys.readouterr()
    assert captured.out == ""
    assert message in captured.err
    assert captured.err.count("\n") == 1
    assert not any(tmp_path.iterdir())


def test_kitti_views_reports_every_scene(tmp_path, capsys, monkeypatch):
    from ipcli.stages.fusion import kitti_views
    from ipcli.stages.kit.artefact import Outcome

    seen = {}

    def run(folder, poses, output, params, run, progress):
        seen.update(folder=folder, poses=poses, scenes=params.scenes, block=params.sgbm.block)
        return {output / "000027.views.h5": Outcome.DONE, output / "000074.views.h5": Outcome.UP_TO_DATE}

    monkeypatch.setattr(kitti_views, "run", run)
    arguments = ["kitti-views", "in", "--poses", "p.npz", "-o", "out", "--scenes", "27,74", "--set", "sgbm.block=3"]
    assert main(arguments) == 0
    assert capsys.readouterr().out == "out\noutputs: 1 done, 1 up to date\n"
    assert seen == {"folder": Path("in"), "poses": Path("p.npz"), "scenes": "27,74", "block": 3}
    assert main([*arguments, "--json"]) == 0
    outputs = json.loads(capsys.readouterr().out)["outputs"]
    assert outputs == {str(Path("out") / "000027.views.h5"): "done", str(Path("out") / "000074.views.h5"): "up to date"}
