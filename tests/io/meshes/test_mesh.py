"""Triangle meshes that others wrote."""

import numpy as np
import pytest

from ipcli.errors import FormatError
from ipcli.io.meshes import mesh

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1.5 0\nf 1 2 3\n"


def test_vertices_and_faces_are_as_they_are_in_the_file(tmp_path):
    (tmp_path / "x.obj").write_text(TRIANGLE)
    vertices, faces = mesh.read(tmp_path / "x.obj")
    np.testing.assert_array_equal(vertices, [[0, 0, 0], [1, 0, 0], [0, 1.5, 0]])
    np.testing.assert_array_equal(faces, [[0, 1, 2]])


def test_several_objects_are_one_mesh(tmp_path):
    second = "o second\nv 0 0 1\nv 1 0 1\nv 0 1 1\nf 4 5 6\n"
    (tmp_path / "x.obj").write_text("o first\n" + TRIANGLE + second)
    vertices, faces = mesh.read(tmp_path / "x.obj")
    assert vertices.shape == (6, 3)
    assert sorted(vertices[faces][:, :, 2].max(axis=1)) == [0, 1]


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("x.stl", b"", "expected .ply or .obj or .off, got .stl"),
        ("x.off", b"OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "3 vertices and 2 faces are said, but 4 lines"),
        ("x.off", b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 2 1\n", "3 vertices and 1 faces are said, but 5"),
        ("x.off", b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n1000000000 0 1 2\n", "1000000000 corners with 3 numbers"),
        ("x.off", b"OFF\n1000000000000 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "1000000000000 vertices"),
        ("x.off", b"OFF\n", "cannot be read"),
        ("x.off", b"", "cannot be read"),
        ("x.ply", b"ply\nformat ascii 1.0\nelement ver", "cannot be read"),
        ("x.obj", b"v 0 0 0\nv 0 0 1\n", "holds no triangles|cannot be read"),
        ("x.obj", b"v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "not finite|cannot be read"),
    ],
)
def test_what_is_no_mesh_is_refused_by_name(tmp_path, name, content, message):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(FormatError, match=message) as caught:
        mesh.read(tmp_path / name)
    assert name in str(caught.value)


@pytest.mark.parametrize("head", ["OFF\n5 2 0\n", "OFF 5 2 0\n", "# by hand\nOFF # of it\n5 2 7\n\n"])
def test_off_files_of_many_hands_are_read(tmp_path, head):
    """The Princeton Shape Benchmark has triangles and larger faces, with colours behind them or not."""
    (tmp_path / "x.OFF").write_text(head + "0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 2.5\n4 0 1 2 3\n3 0 1 4 255 0 0\n")
    vertices, faces = mesh.read(tmp_path / "x.OFF")
    np.testing.assert_array_equal(vertices[[2, 4]], [[1, 1, 0], [0, 0, 2.5]])
    assert len(faces) == 3
    assert [0, 1, 4] in faces.tolist()
    assert len(mesh.read_joined(tmp_path / "x.OFF")[1]) == 3


@pytest.mark.parametrize("read", [mesh.read, mesh.read_joined])
def test_a_file_that_is_not_there_and_one_too_large_are_told_apart(tmp_path, monkeypatch, read):
    with pytest.raises(FormatError, match="no such file"):
        read(tmp_path / "x.obj")
    (tmp_path / "x.obj").write_text(TRIANGLE)
    monkeypatch.setattr(mesh, "MOST_BYTES", 10)
    with pytest.raises(FormatError, match="too large a mesh"):
        read(tmp_path / "x.obj")
