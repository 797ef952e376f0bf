"""What `import ipcli` offers: the same results as the commands, described in one line, and never in place of a file."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

import ipcli
from ipcli.cli.main import main
from ipcli.errors import FormatError, OutputExists, ParameterError
from ipcli.io.files import h5
from tests.fixtures import fusion_scenes, mocap_clips

ROOT = Path(__file__).parents[1]
QUICK = {"frames": 60, "mixture": {"sweeps": 8, "burn_in": 4, "thin": 2}}


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    folder = tmp_path_factory.mktemp("api")
    fusion_scenes.write(folder / "scene.views.h5", fusion_scenes.scene(k=3, shape=(36, 48)))
    mocap_clips.write(folder / "all.clips.h5", mocap_clips.every(repeats=1))
    mocap_clips.write_groups(folder / "groups.toml")
    return folder


def same(result, path):
    stored = h5.read(path, result.kind)
    assert result.arrays.keys() == stored.arrays.keys()
    for name, array in stored.arrays.items():
        np.testing.assert_array_equal(result[name], array, err_msg=name)


def test_fusion_is_that_of_the_command(place, tmp_path):
    settings = ["--method", "tgv-l1", "--set", "fusion.solver.iterations=60"]
    output = tmp_path / "x.fused.h5"
    assert main(["fuse-depth", str(place / "scene.views.h5"), "--reference", "00", "-o", str(output), *settings]) == 0
    views = ipcli.open(place / "scene.views.h5")
    result = ipcli.fuse(views, "00", method="tgv-l1", solver={"iterations": 60})
    same(result, output)
    assert result.provenance["params"] == h5.read(output, "fused-depth").provenance["params"]


def test_learning_and_recognition_are_those_of_the_commands(place, tmp_path):
    groups = ["--groups", str(place / "groups.toml")]
    model, told = tmp_path / "m.h5", tmp_path / "t.h5"
    clips = str(place / "all.clips.h5")
    assert main(["mocap-train", clips, "-o", str(model), "--actors", "ann,bob", *groups, *mocap_clips.QUICK]) == 0
    assert main(["mocap-classify", str(model), clips, "-o", str(told), "--actors", "cyd", "--window", "0.3"]) == 0
    known = ipcli.open(clips)
    learnt = ipcli.learn(known, groups=str(place / "groups.toml"), actors=("ann", "bob"), **QUICK)
    same(learnt, model)
    same(learnt.recognise(known, actors=("cyd",), window=0.3), told)
    same(ipcli.recognise(model, clips, actors=("cyd",), window=0.3), told)


def test_descriptions_are_one_line(place):
    views, clips = ipcli.open(place / "scene.views.h5"), ipcli.open(place / "all.clips.h5")
    assert repr(views) == "Views(3: '00' ... '02'; depth in m)"
    assert repr(clips).startswith(f"Clips(12 of 4 people, {len(clips.skeleton.joints)} joints; actions: ")
    result = ipcli.fuse(views, solver={"iterations": 5})
    assert repr(result).startswith("Result(fused-depth: ")
    assert max(map(len, map(repr, (views, clips, result)))) < 200


def test_a_notebook_shows_the_page(place):
    result = ipcli.fuse(place / "scene.views.h5", solver={"iterations": 5})
    html = result._repr_html_()
    assert html.startswith("<iframe srcdoc=")
    assert "<script>" not in html
    assert html.count("<iframe") == 1


def test_saving_writes_the_artefact_once_and_replaces_nothing(place, tmp_path):
    result = ipcli.fuse(place / "scene.views.h5", solver={"iterations": 5})
    path = result.save(tmp_path / "new" / "x.h5")
    same(ipcli.read(path), path)
    before = path.read_bytes()
    with pytest.raises(OutputExists):
        result.save(path)
    assert path.read_bytes() == before
    with pytest.raises(ParameterError, match=r"written as X\.h5"):
        result.save(tmp_path / "x.ply")


def test_what_cannot_be_is_said(place, tmp_path):
    views = ipcli.open(place / "scene.views.h5")
    with pytest.raises(ParameterError, match="unknown setting 'methd'; did you mean 'fusion.method'"):
        ipcli.fuse(views, methd="tgv-l1")
    with pytest.raises(ParameterError, match="no view '7'"):
        ipcli.fuse(views, "7")
    with pytest.raises(FormatError, match="neither depth views nor motions"):
        ipcli.open(tmp_path)
    result = ipcli.fuse(views, solver={"iterations": 5}).save(tmp_path / "x.h5")
    with pytest.raises(FormatError, match="holds 'fused-depth', no measurements. Read it with ipcli.read"):
        ipcli.open(result)
    with pytest.raises(ParameterError, match="no model of actions"):
        ipcli.recognise(result, place / "all.clips.h5")
    with pytest.raises(AttributeError, match="no attribute 'fuze'"):
        ipcli.fuze  # noqa: B018


def test_all_names_lead_somewhere():
    assert {name for name in ipcli.__all__ if getattr(ipcli, name) is None} == set()
    assert dir(ipcli) == ipcli.__all__


def test_the_code_of_the_page_runs_as_it_stands(tmp_path, monkeypatch, capsys):
    text = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL)
    shutil.copytree(ROOT / "sample_data", tmp_path / "sample_data")
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for block in blocks:
        exec(compile(block, "docs/python.md", "exec"), names)
    assert set(names["told"]["answers"]) <= {"kick", "squat", "walk", "wave", "none"}
    assert names["told"]["answers"].tolist() == [clip.split(".")[0] for clip in names["told"]["clips"]]
    assert names["result"]["depth"].shape == names["depth"].shape
    assert capsys.readouterr().out.startswith("Result(fused-depth: ")
