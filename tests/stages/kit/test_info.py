"""What info tells of an artefact and of a PLY file is what other libraries find in them."""

import json

import h5py
import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from ipcli import schema
from ipcli.errors import FormatError
from ipcli.io.files import h5
from ipcli.stages.kit import info
from tests.fixtures.artefacts import artefacts
from tests.fixtures.errors import check_message


@pytest.mark.parametrize("kind", schema.KINDS)
@settings(max_examples=5)
@given(data=st.data())
def test_every_kind_is_described_as_h5py_finds_it(tmp_path_factory, kind, data):
    path = tmp_path_factory.mktemp("info") / "a.H5"
    h5.write(path, kind, data.draw(artefacts(schema.kind(kind))), {"seed": 3})
    told = info.run(path)
    found = {}
    with h5py.File(path) as file:
        file.visititems(lambda name, item: found.update({name: item.shape} if isinstance(item, h5py.Dataset) else {}))
    assert {name: tuple(entry["shape"]) for name, entry in told["datasets"].items()} == found
    assert (told["file"], told["kind"], told["provenance"]) == (str(path), kind, {"seed": 3})
    assert told["version"] == schema.kind(kind).version
    for name, entry in told["datasets"].items():
        field, _ = schema.kind(kind).field(name)
        assert (entry["doc"], entry["units"], entry["dtype"]) == (field.doc, field.units, field.dtype)
    assert json.loads(json.dumps(told))["datasets"].keys() == found.keys()


@pytest.mark.parametrize("encoding", ["ascii", "binary"])
def test_a_mesh_of_another_library_is_described(tmp_path, encoding):
    ball = trimesh.creation.icosphere(2)
    ball.export(tmp_path / "ball.ply", encoding=encoding)
    told = info.run(tmp_path / "ball.ply")
    assert told["kind"] == "ply"
    assert told["format"].startswith(encoding)
    assert {name: element["count"] for name, element in told["elements"].items()} == {
        "vertex": len(ball.vertices),
        "face": len(ball.faces),
    }
    assert list(told["elements"]["vertex"]["properties"])[:3] == ["x", "y", "z"]


def test_no_data_is_read(tmp_path):
    """The description of an artefact whose values break the schema is told all the same."""
    arrays = {"views/0/depth": np.ones((2, 3), np.float32), "views/0/intrinsics": np.eye(3)}
    arrays |= {"views/0/cam_from_world": np.eye(4), "unit": np.array("m"), "measured": np.array("depth")}
    h5.write(tmp_path / "a.h5", "views", arrays, {})
    with h5py.File(tmp_path / "a.h5", "r+") as file:
        file["views/0/depth"][...] = -1
    with pytest.raises(FormatError):
        h5.read(tmp_path / "a.h5", "views")
    told = info.run(tmp_path / "a.h5")
    assert told["datasets"]["views/0/depth"]["shape"] == (2, 3)
    assert told["texts"]["unit"] == {"distinct": 1, "values": {"m": 1}}


def test_texts_that_break_the_schema_are_left_out_and_the_rest_is_told(tmp_path):
    arrays = {"views/0/depth": np.ones((2, 3), np.float32), "views/0/intrinsics": np.eye(3)}
    arrays |= {"views/0/cam_from_world": np.eye(4), "unit": np.array("m"), "measured": np.array("depth")}
    h5.write(tmp_path / "a.h5", "views", arrays, {})
    with h5py.File(tmp_path / "a.h5", "r+") as file:
        file["measured"][...] = "smell"
    told = info.run(tmp_path / "a.h5")
    assert told["texts"] == {}
    assert told["datasets"].keys() == arrays.keys()


@pytest.mark.parametrize(("name", "got"), [("a.csv", ".csv"), ("a", "no suffix"), ("a.h5.gz", ".gz")])
def test_another_file_is_refused_by_its_suffix(tmp_path, name, got):
    (tmp_path / name).write_bytes(b"x")
    with pytest.raises(FormatError) as raised:
        info.run(tmp_path / name)
    check_message(raised.value, name, "expected .h5 or .ply", f"got {got}")
