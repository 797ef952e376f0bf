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
        ("x.stl", b"", "expected .ply or .obj, got .stl"),
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
