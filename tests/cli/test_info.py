"""`ipcli info` tells what is in a file, as text and as JSON, and refuses what it does not know."""

import json

import numpy as np
import pytest

from ipcli import provenance, schema
from ipcli.cli.main import main
from ipcli.io.files import h5, ply


@pytest.fixture
def views(tmp_path):
    arrays = {
        "views/005/depth": np.ones((2, 3), np.float32),
        "views/005/intrinsics": np.eye(3),
        "views/005/cam_from_world": np.eye(4),
        "unit": np.array("m"),
        "measured": np.array("depth"),
    }
    (tmp_path / "in.png").write_bytes(b"x")
    record = provenance.record(
        "import-views", {"window": 3, "source": {"unit": "m"}}, [tmp_path / "in.png"], "views", 2
    )
    h5.write(tmp_path / "v.h5", "views", arrays, record)
    return tmp_path / "v.h5", record


def test_text_names_kind_fields_units_and_origin(views, capsys):
    path, record = views
    assert main(["info", str(path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == f"{path}: kind 'views', version 1"
    assert "  views/005/depth           2 x 3   float32  unit  Depth along the optical axis" in lines
    assert any(line.split()[:4] == ["unit", "scalar", "str", "-"] for line in lines)
    assert lines[-5:] == [
        "made by ipcli 0.1.0 import-views, seed 2",
        f"digest {record['digest']}",
        f"  input in.png  sha256 {record['inputs'][0]['sha256']}",
        "  window = 3",
        "  source.unit = m",
    ]


def test_json_is_the_header(views, capsys):
    path, record = views
    assert main(["info", "--json", str(path)]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["file"], found["kind"], found["version"], found["provenance"]) == (str(path), "views", 1, record)
    doc = schema.kind("views").fields[0].doc
    assert found["datasets"]["views/005/depth"] == {"shape": [2, 3], "dtype": "float32", "units": "unit", "doc": doc}


def test_a_ply_shows_its_counts(tmp_path, capsys):
    extra = {"confidence": np.ones(4, np.float32)}
    ply.write(
        tmp_path / "m.ply", np.zeros((4, 3), np.float32), faces=np.zeros((2, 3), int), extra=extra, comments=["hello"]
    )
    assert main(["info", str(tmp_path / "m.ply")]) == 0
    text = capsys.readouterr().out.splitlines()
    assert text[1:] == ["  4 x vertex: x, y, z, confidence", "  2 x face: vertex_indices", "  comment hello"]
    assert main(["info", "--json", str(tmp_path / "m.ply")]) == 0
    assert json.loads(capsys.readouterr().out)["elements"]["face"]["count"] == 2


@pytest.mark.parametrize(
    ("name", "message"),
    [("a.txt", "expected .h5 or .ply, got .txt"), ("a.h5", "no such file"), ("a.ply", "No such file")],
)
def test_other_files_are_refused(tmp_path, capsys, name, message):
    assert main(["info", str(tmp_path / name)]) == 1
    assert message in capsys.readouterr().err


def kicks(count):
    """Clips of one frame and one joint: three bows, then kicks; nobody knows who moves in the first two."""
    return {
        "clips": np.array([f"a{n}" for n in range(count)]),
        "labels": np.array(["bow"] * 3 + ["kick"] * (count - 3)),
        "actors": np.array([""] * 2 + ["ann"] * (count - 2)),
        "frames": np.ones(count, np.int64),
        "rates": np.full(count, 30.0),
        "joints": np.array(["hips"]),
        "parents": np.array([-1]),
        "positions": np.zeros((count, 1, 3), np.float32),
        "frame_labels": np.full(count, ""),
    }


def test_texts_are_told_by_their_values(tmp_path, capsys):
    clips = kicks(7)
    h5.write(tmp_path / "c.h5", "clips", clips, {})
    assert main(["info", str(tmp_path / "c.h5")]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert "  labels: bow 3, kick 4" in lines
    assert "  actors: '' 2, ann 5" in lines
    assert "  clips: a0, a1, a2, a3, a4, a5, a6" in lines
    assert not any(line.startswith("  frame_labels:") for line in lines)


def test_of_many_names_the_first_are_told(tmp_path, capsys):
    h5.write(tmp_path / "c.h5", "clips", kicks(25), {})
    assert main(["info", str(tmp_path / "c.h5")]) == 0
    (line,) = (line for line in capsys.readouterr().out.splitlines() if line.startswith("  clips: a0"))
    assert line.endswith("a18, a19 and 5 more")
    assert main(["info", "--json", str(tmp_path / "c.h5")]) == 0
    texts = json.loads(capsys.readouterr().out)["texts"]
    assert (texts["clips"]["distinct"], len(texts["clips"]["values"])) == (25, 20)
    assert texts["labels"] == {"distinct": 2, "values": {"bow": 3, "kick": 22}}
