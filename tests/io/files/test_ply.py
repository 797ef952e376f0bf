"""PLY files come back whole, other libraries count the same, and a file that is not whole is never an empty mesh."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as nps

from ipcli.errors import FormatError, IpcliError
from ipcli.io.files import ply

IN_FOLDER = settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)


@st.composite
def meshes(draw):
    """Keyword arguments of ply.write, everything but the vertices present or not."""
    count = draw(st.integers(0, 6))
    floats = draw(st.sampled_from(["<f4", "<f8"]))
    mesh = {"vertices": draw(nps.arrays(floats, (count, 3)))}
    if count and draw(st.booleans()):
        mesh["faces"] = draw(nps.arrays(np.int32, (draw(st.integers(0, 4)), 3), elements=st.integers(0, count - 1)))
    if draw(st.booleans()):
        mesh["normals"] = draw(nps.arrays(floats, (count, 3)))
    if draw(st.booleans()):
        mesh["colors"] = draw(nps.arrays(np.uint8, (count, 3)))
    dtypes = st.sampled_from(["i1", "u1", "<i2", "<u2", "<i4", "<u4", "<f4", "<f8"])
    names = draw(st.lists(st.sampled_from(["confidence", "observations", "alpha"]), unique=True))
    mesh["extra"] = {name: draw(nps.arrays(draw(dtypes), (count,))) for name in names}
    mesh["comments"] = draw(st.lists(st.sampled_from(["ipcli kind=depth", "element face 3"]), max_size=2))
    return mesh


def assert_same(found, mesh):
    for name in ("vertices", "faces", "normals", "colors"):
        array, expected = getattr(found, name), mesh.get(name)
        assert (array is None) == (expected is None), name
        if expected is not None:
            assert array.dtype == expected.dtype
            np.testing.assert_array_equal(array, expected)
    assert found.extra.keys() == mesh["extra"].keys()
    for name, values in mesh["extra"].items():
        assert found.extra[name].dtype == values.dtype
        np.testing.assert_array_equal(found.extra[name], values)
    assert found.comments == tuple(mesh["comments"])


@IN_FOLDER
@given(meshes())
def test_round_trip_in_binary(tmp_path, mesh):
    ply.write(tmp_path / "m.ply", **mesh)
    assert_same(ply.read(tmp_path / "m.ply"), mesh)


@IN_FOLDER
@given(meshes())
def test_the_same_mesh_as_ascii_reads_the_same(tmp_path, mesh):
    ply.write(tmp_path / "m.ply", **mesh)
    head = (tmp_path / "m.ply").read_bytes().split(ply.END)[0].replace(b"binary_little_endian", b"ascii")
    found = ply.read(tmp_path / "m.ply")
    groups = [g for g in (found.vertices, found.normals, found.colors) if g is not None]
    columns = [*(column for group in groups for column in group.T), *found.extra.values()]
    lines = [" ".join(repr(value.item()) for value in row) for row in zip(*columns, strict=True)]
    lines += [f"3 {' '.join(map(str, face))}" for face in (() if found.faces is None else found.faces)]
    (tmp_path / "m.ply").write_bytes(head + ply.END + "".join(line + "\n" for line in lines).encode())
    assert_same(ply.read(tmp_path / "m.ply"), mesh)


def icosphere():
    """A closed mesh with every attribute."""
    import trimesh

    sphere = trimesh.creation.icosphere(2)
    count = len(sphere.vertices)
    colors = np.arange(3 * count).reshape(count, 3).astype(np.uint8)
    confidence = np.linspace(0, 1, count, dtype=np.float32)
    return {
        "vertices": sphere.vertices.astype(np.float32),
        "faces": sphere.faces.astype(np.int32),
        "normals": sphere.vertex_normals.astype(np.float32),
        "colors": colors,
        "extra": {"confidence": confidence},
        "comments": ["made by ipcli"],
    }


def test_trimesh_and_open3d_read_the_same_mesh(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    mesh = icosphere()
    ply.write(tmp_path / "m.ply", **mesh)
    theirs = trimesh.load(tmp_path / "m.ply", process=False)
    np.testing.assert_array_equal(theirs.vertices, mesh["vertices"])
    np.testing.assert_array_equal(theirs.faces, mesh["faces"])
    np.testing.assert_array_equal(theirs.visual.vertex_colors[:, :3], mesh["colors"])
    from ipcli.geometry import open3d

    theirs = open3d.load().io.read_triangle_mesh(str(tmp_path / "m.ply"))
    np.testing.assert_array_equal(np.asarray(theirs.vertices), mesh["vertices"])
    np.testing.assert_array_equal(np.asarray(theirs.triangles), mesh["faces"])
    np.testing.assert_array_equal(np.asarray(theirs.vertex_normals), mesh["normals"])
    np.testing.assert_allclose(255 * np.asarray(theirs.vertex_colors), mesh["colors"], atol=1e-9)


def test_a_mesh_that_trimesh_writes_as_ascii_or_binary_is_read(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    sphere = trimesh.creation.icosphere(1)
    for encoding in ("ascii", "binary"):
        (tmp_path / "m.ply").write_bytes(trimesh.exchange.ply.export_ply(sphere, encoding=encoding))
        found = ply.read(tmp_path / "m.ply")
        np.testing.assert_allclose(found.vertices, sphere.vertices, atol=1e-6)
        np.testing.assert_array_equal(found.faces, sphere.faces)


def test_every_cut_and_every_surplus_is_refused(tmp_path):
    ply.write(tmp_path / "m.ply", **icosphere())
    data = (tmp_path / "m.ply").read_bytes()
    pieces = [data[:length] for length in {*range(0, 500, 11), *np.linspace(0, len(data) - 1, 50).astype(int)}]
    for piece in [*pieces, data + b"\0", data[:-1]]:
        (tmp_path / "cut.ply").write_bytes(piece)
        with pytest.raises(FormatError):
            ply.read(tmp_path / "cut.ply")


def test_flipped_bytes_of_the_header_give_a_mesh_or_a_format_error(tmp_path):
    ply.write(tmp_path / "m.ply", **icosphere())
    data = (tmp_path / "m.ply").read_bytes()
    refused = 0
    for index in range(data.index(ply.END) + len(ply.END)):
        (tmp_path / "flip.ply").write_bytes(data[:index] + bytes([data[index] ^ 0x15]) + data[index + 1 :])
        try:
            assert len(ply.read(tmp_path / "flip.ply").vertices) == 162
        except FormatError:
            refused += 1
    assert refused > 100  # names of properties and comments may change, the rest may not


HEADER = (
    "ply\nformat {form} 1.0\nelement vertex {n}\nproperty float x\nproperty float y\nproperty float "
    "z\n{rest}end_header\n{data}"
)
FACE = "element face 1\nproperty list uchar int vertex_indices\n"
DAMAGES = {
    "big endian": ({"form": "binary_big_endian"}, "header line not understood: format binary_big_endian"),
    "no vertices": ({"n": "x"}, "header line not understood: element vertex x"),
    "quads": ({"rest": FACE, "data": "0 0 0\n4 0 0 0 0\n"}, "data do not fit the header"),
    "missing corner": (
        {"rest": FACE, "data": "0 0 0\n3 0 0 1\n"},
        "faces of missing vertices .expected indices below 1, got 1",
    ),
    "negative corner": ({"rest": FACE, "data": "0 0 0\n3 0 0 -1\n"}, "faces of missing vertices"),
    "count of two": ({"rest": FACE, "data": "0 0 0\n2 0 0 0\n"}, "faces that are not triangles"),
    "words": ({"data": "0 0 a\n"}, "data do not fit the header"),
    "line missing": ({"data": ""}, "truncated or too long .expected 1 lines of data, got 0"),
    "property twice": ({"rest": "property float x\n", "data": "0 0 0 0\n"}, "none twice"),
    "list in vertex": ({"rest": "property list uchar int y\n"}, "header line not understood"),
    "other element": ({"rest": "element edge 3\n"}, "header line not understood: element edge 3"),
    "index of floats": ({"rest": FACE.replace(" int ", " float ")}, "header line not understood"),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_what_is_not_read_is_told(damage, tmp_path):
    changes, message = DAMAGES[damage]
    text = HEADER.format(**({"form": "ascii", "n": 1, "rest": "", "data": "0 0 0\n"} | changes))
    (tmp_path / "m.ply").write_text(text)
    with pytest.raises(FormatError, match=message):
        ply.read(tmp_path / "m.ply")


def test_a_unit_of_micrometres_is_written_in_ascii(tmp_path):
    ply.write(tmp_path / "m.ply", np.zeros((2, 3), np.float32), comments=("unit µm",))
    assert ply.header(tmp_path / "m.ply").comments == ("unit \\xb5m",)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"faces": np.array([[0, 1, 2]])}, "indices from 0 to 2, but there are 2 vertices"),
        ({"faces": np.array([[0, -1, 1]])}, "indices from -1 to 1"),
        ({"faces": np.zeros((1, 3))}, "expected .m, 3. integers"),
        ({"extra": {"x": np.zeros(2)}}, "'x' cannot name an extra property"),
        ({"extra": {"two words": np.zeros(2)}}, "cannot name an extra property"),
        ({"extra": {"a": np.zeros(3)}}, "property a: expected .2,. of a PLY type, got float64 of shape .3,."),
        ({"extra": {"a": np.zeros(2, np.int64)}}, "property a: .* got int64"),
        ({"normals": np.zeros((3, 3))}, "property nx"),
        ({"comments": ["two\nlines"]}, "single lines of ASCII"),
    ],
)
def test_bad_arguments_are_refused_before_anything_is_written(tmp_path, arguments, message):
    with pytest.raises(IpcliError, match=message):
        ply.write(tmp_path / "m.ply", np.zeros((2, 3)), **arguments)
    assert list(tmp_path.iterdir()) == []


VERTICES = np.random.default_rng(0).random((9, 3), np.float32)
FACES = np.array([[0, 1, 2], [6, 7, 8], [3, 4, 8]])


def test_in_bands_a_mesh_is_written_as_at_once(tmp_path):
    vertices, faces = VERTICES, FACES
    extra = {"count": np.arange(len(vertices), dtype=np.int32)}
    ply.write(tmp_path / "whole.ply", vertices, faces=faces, extra=extra, comments=("a",))
    bands = (
        ply.vertex_table(tmp_path, vertices[k : k + 1], extra={"count": np.array([k], np.int32)})
        for k in range(len(vertices))
    )
    counts = (len(vertices), len(faces))
    ply.write_bands(tmp_path / "bands.ply", bands, counts, (face[None] for face in faces), ("a",))
    assert (tmp_path / "bands.ply").read_bytes() == (tmp_path / "whole.ply").read_bytes()


def test_bands_that_are_not_what_was_announced_leave_no_file(tmp_path):
    table = ply.vertex_table(tmp_path, VERTICES)
    with pytest.raises(IpcliError, match="vertices and faces"):
        ply.write_bands(tmp_path / "bands.ply", [table], (len(table) + 1, 0), None, ())
    assert not list(tmp_path.iterdir())
