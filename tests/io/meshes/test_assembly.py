"""Models with named parts: closed after they were written and read again, in every format."""

import numpy as np
import pytest
import trimesh

from ipcli.errors import FormatError, ParameterError
from ipcli.io.files import ply
from ipcli.io.meshes import assembly, mesh
from tests.fixtures import limbs


@pytest.fixture(scope="module")
def model():
    vertices, faces, labels = limbs.mesh()
    return (
        (vertices * np.pi).astype(np.float32),
        faces.astype(np.int32),
        labels - 1,
    )  # coordinates with all their digits


@pytest.mark.parametrize("suffix", assembly.SUFFIXES)
def test_closed_after_save_and_load(model, tmp_path, suffix):
    vertices, faces, parts = model
    path = tmp_path / f"model{suffix}"
    assembly.write(path, vertices, faces, parts, limbs.TREE.names)
    loaded = trimesh.load(path, force="mesh")
    loaded.merge_vertices(merge_norm=True, merge_tex=True)
    assert loaded.is_watertight
    assert loaded.volume == pytest.approx(trimesh.Trimesh(vertices, faces, process=False).volume, rel=1e-5)
    read = mesh.read_joined(path)
    assert trimesh.Trimesh(*read, process=False).is_watertight
    assert len(read[0]) == len(vertices)


def test_glb_has_a_node_for_each_part(model, tmp_path):
    vertices, faces, parts = model
    assembly.write(tmp_path / "m.glb", vertices, faces, parts, limbs.TREE.names, name="limbs")
    scene = trimesh.load(tmp_path / "m.glb")
    assert set(scene.graph.nodes_geometry) == set(limbs.TREE.names)
    counts = {name: len(scene.geometry[name].faces) for name in limbs.TREE.names}
    assert counts == {name: int((parts == k).sum()) for k, name in enumerate(limbs.TREE.names)}


def test_obj_has_a_group_for_each_part(model, tmp_path):
    vertices, faces, parts = model
    assembly.write(tmp_path / "m.obj", vertices, faces, parts, ("a b", *limbs.TREE.names[1:]))
    groups = [line[2:] for line in (tmp_path / "m.obj").read_text().splitlines() if line.startswith("g ")]
    assert groups == ["a_b", *limbs.TREE.names[1:]]


def test_ply_keeps_what_is_known_of_vertices(model, tmp_path):
    vertices, faces, parts = model
    seen = np.arange(len(vertices)).astype(np.uint16)
    assembly.write(tmp_path / "m.ply", vertices, faces, parts, limbs.TREE.names, extra={"seen_by": seen})
    read = ply.read(tmp_path / "m.ply")
    assert (read.extra["seen_by"] == seen).all()
    assert set(np.unique(read.extra["part"])) == {0, 1, 2, 3}


def test_the_same_bytes_every_time(model):
    vertices, faces, parts = model
    once, again = (assembly.glb(vertices, faces, parts, limbs.TREE.names, "m") for _ in range(2))
    assert once == again


def test_a_lighter_mesh_keeps_its_parts(model):
    vertices, faces, parts = model
    light = assembly.lighter(vertices, faces, parts, 500)
    assert len(light[1]) <= 520
    assert set(np.unique(light[2])) == {0, 1, 2, 3}


def test_other_formats_are_refused(model, tmp_path):
    with pytest.raises(ParameterError, match=r"\.glb"):
        assembly.write(tmp_path / "m.fbx", *model, limbs.TREE.names)


@pytest.mark.parametrize(
    ("name", "content"), [("m.glb", b"glTF"), ("m.stl", b"solid"), ("m.txt", b""), ("m.obj", b"v 0 0 0")]
)
def test_what_is_no_mesh_is_refused(tmp_path, name, content):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(FormatError, match=name):
        mesh.read_joined(tmp_path / name)
