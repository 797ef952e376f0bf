"""`model-animal` from a project to closed files and pages, step by step."""

import json

import pytest
import trimesh

from ipcli.cli.main import main
from ipcli.io.files import h5
from tests.fixtures import limbs

QUICK = ("--voxels", "40", "--set", "modelling.inflation.triangles=200")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("animal")
    source = limbs.write_project(folder / "in")
    assert (
        main(["model-animal", str(source), "-o", str(folder / "a.glb"), *QUICK, "--separate-parts", "stl", "-q"]) == 0
    )
    return folder, source


def test_everything_is_written_and_closed(made):
    folder, _ = made
    names = {path.name for path in folder.iterdir()}
    assert {"a.glb", "a.h5", "a.html", "a.turn.html", "a.steps", "a.head.stl", "a.torso.stl"} <= names
    loaded = trimesh.load(folder / "a.glb", force="mesh")
    loaded.merge_vertices(merge_norm=True, merge_tex=True)
    assert loaded.is_watertight
    arrays = h5.read(folder / "a.h5", "animal-model").arrays
    assert set(arrays["face_part"].tolist()) == {0, 1, 2, 3}
    assert arrays["overlaps"].min() > 0.85
    assert float((arrays["vertices"].max(axis=0) - arrays["vertices"].min(axis=0)).max()) == pytest.approx(
        2.0, rel=1e-4
    )


def test_a_second_run_is_up_to_date(made, caplog):
    folder, source = made
    before = (folder / "a.h5").stat().st_mtime_ns
    assert main(["model-animal", str(source), "-o", str(folder / "a.glb"), *QUICK, "--separate-parts", "stl"]) == 0
    assert (folder / "a.h5").stat().st_mtime_ns == before


def test_steps_can_be_run_alone(tmp_path, capsys):
    source = limbs.write_project(tmp_path / "in", longest=80)
    for step in ("aspects", "components"):
        assert main(["model-animal", str(source), "-o", str(tmp_path / "b.glb"), *QUICK, "--stop-after", step]) == 0
        assert capsys.readouterr().out.strip().endswith(f"{step}.h5")
        assert not (tmp_path / "b.glb").exists()


@pytest.mark.parametrize("suffix", ["ply", "obj", "stl"])
def test_other_formats(tmp_path, suffix, capsys):
    source = limbs.write_project(tmp_path / "in", longest=80)
    path = tmp_path / f"c.{suffix}"
    assert main(["model-animal", str(source), "-o", str(path), *QUICK, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["output"], told["parts"]) == (str(path), 4)
    assert min(told["overlap"].values()) > 0.8
    assert main(["model-animal", "check", str(path)]) == 0
    assert "watertight: yes" in capsys.readouterr().out


def test_check_tells_of_an_open_mesh(tmp_path, capsys):
    box = trimesh.creation.box()
    trimesh.Trimesh(box.vertices, box.faces[1:], process=False).export(tmp_path / "open.ply")
    assert main(["model-animal", "check", str(tmp_path / "open.ply")]) == 1
    assert "watertight: no" in capsys.readouterr().out
    box.export(tmp_path / "box.stl")
    assert main(["model-animal", "check", str(tmp_path / "box.stl"), "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["volume"] == pytest.approx(1.0)
    assert facts["thinnest"] == pytest.approx(1.0, rel=1e-3)
    assert facts["pieces"] == 1


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (["check"], 2),
        (["check", "none.glb"], 1),
        (["a.toml"], 2),
        (["a.toml", "-o", "x.fbx"], 2),
        (["none.toml", "-o", "x.glb"], 1),
        (["a.toml", "b.toml", "-o", "x.glb"], 2),
    ],
)
def test_wrong_usage(words, code, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["model-animal", *words]) == code


def test_one_image_alone_gives_a_closed_model(tmp_path):
    source = limbs.write_project(tmp_path / "in", ("left",), longest=80)
    assert main(["model-animal", str(source), "-o", str(tmp_path / "one.glb"), *QUICK, "-q"]) == 0
    assert main(["model-animal", "check", str(tmp_path / "one.glb")]) == 0
