"""Artefacts come back as they were written; of a file that is not sound, only FormatError comes."""

import resource
import shutil
import time

import h5py
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ipcli import schema
from ipcli.errors import FormatError, IpcliError, VersionTooNew, VersionTooOld
from ipcli.io.files import h5
from tests.fixtures.artefacts import artefacts
from tests.fixtures.errors import check_message

KINDS = list(schema.KINDS.values())
IN_FOLDER = settings(
    max_examples=50, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow], deadline=None
)
PROVENANCE = {"command": "test", "digest": "0", "params": {"ü": [1, None, 0.1]}}


def views(count=3, size=(4, 5)):
    rng = np.random.default_rng(0)
    arrays = {"unit": np.array("m"), "measured": np.array("depth")}
    for index in range(count):
        stem = f"views/{index:03d}/"
        arrays[stem + "depth"] = rng.uniform(1, 2, size).astype(np.float32)
        arrays[stem + "intrinsics"] = np.eye(3)
        arrays[stem + "cam_from_world"] = np.eye(4)
        arrays[stem + "image"] = rng.integers(0, 255, (*size, 3), np.uint8)
    return arrays


@pytest.fixture
def path(tmp_path):
    h5.write(tmp_path / "v.h5", "views", views(), PROVENANCE)
    return tmp_path / "v.h5"


def assert_same(one, other):
    assert one.keys() == other.keys()
    for name, array in one.items():
        assert array.shape == other[name].shape
        if array.dtype.kind == "U":
            assert array.tolist() == other[name].tolist()
        else:
            assert array.dtype == other[name].dtype
            np.testing.assert_array_equal(array, other[name])


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_round_trip(kind, tmp_path):
    @IN_FOLDER
    @given(artefacts(kind))
    def comes_back(arrays):
        h5.write(tmp_path / "a.h5", kind.name, arrays, PROVENANCE)
        artefact = h5.read(tmp_path / "a.h5", kind.name)
        assert (artefact.kind, artefact.version, artefact.provenance) == (kind.name, kind.version, PROVENANCE)
        assert_same(artefact.arrays, arrays)
        assert h5.names(tmp_path / "a.h5") == tuple(sorted(arrays))
        peeked = h5.peek(tmp_path / "a.h5").datasets
        assert {name: dataset.shape for name, dataset in peeked.items()} == {
            name: a.shape for name, a in arrays.items()
        }

    comes_back()


def test_two_writes_at_different_times_give_the_same_bytes(path, tmp_path):
    time.sleep(1.1)  # HDF5 stamps whole seconds
    arrays = views()
    h5.write(tmp_path / "again.h5", "views", dict(reversed(arrays.items())), PROVENANCE)
    assert (tmp_path / "again.h5").read_bytes() == path.read_bytes()


def test_the_file_tells_units_dims_and_meaning_to_any_hdf5_reader(path):
    with h5py.File(path) as file:
        for name, field in (
            ("views/000/depth", schema.kind("views").fields[0]),
            ("unit", schema.kind("views").field("unit")[0]),
        ):
            attributes = file[name].attrs
            found = [attributes[key].decode() for key in ("units", "description", "dims")]
            assert found == [field.units, field.doc, " ".join(field.dims)]
        assert file["views/000/image"].compression == "gzip"
        assert file["views/000/depth"].compression is None


def test_only_reads_what_is_asked_for_and_checks_that(path):
    wanted = "views/001/"
    artefact = h5.read(path, "views", only=lambda name: name.startswith(wanted))
    assert_same(artefact.arrays, {name: array for name, array in views().items() if name.startswith(wanted)})
    with h5py.File(path, "r+") as file:
        file["views/000/depth"][0, 0] = 7
    h5.read(path, "views", only=lambda name: name.startswith(wanted))
    with pytest.raises(FormatError, match="views/000/depth is damaged"):
        h5.read(path, "views", only=lambda name: name.startswith("views/000/"))


def test_nothing_is_written_when_the_arrays_break_the_schema(path):
    before = path.read_bytes()
    with pytest.raises(schema.SchemaError, match="unit: missing"):
        h5.write(path, "views", {name: array for name, array in views().items() if name != "unit"}, PROVENANCE)
    assert path.read_bytes() == before


@pytest.mark.parametrize("in_memory", [1 << 27, 0], ids=["in memory", "straight to the disk"])
def test_a_full_disk_is_one_line_and_keeps_the_old_file(path, monkeypatch, in_memory):
    monkeypatch.setattr(h5, "IN_MEMORY", in_memory)
    before = path.read_bytes()
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, hard))
    try:
        with pytest.raises(IpcliError, match=r"v\.h5: cannot be written") as caught:
            h5.write(path, "views", views(2, (300, 300)), PROVENANCE)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert "\n" not in str(caught.value)
    assert [entry.name for entry in path.parent.iterdir()] == ["v.h5"]
    assert path.read_bytes() == before


def test_a_large_artefact_goes_straight_to_the_disk_and_reads_the_same(path, tmp_path, monkeypatch):
    monkeypatch.setattr(h5, "IN_MEMORY", 0)
    h5.write(tmp_path / "large.h5", "views", views(), PROVENANCE)
    small, large = h5.read(path, "views"), h5.read(tmp_path / "large.h5", "views")
    assert large.provenance == small.provenance
    assert large.arrays.keys() == small.arrays.keys()
    for name, array in small.arrays.items():
        np.testing.assert_array_equal(large.arrays[name], array)
    first = (tmp_path / "large.h5").read_bytes()
    h5.write(tmp_path / "large.h5", "views", views(), PROVENANCE)
    assert (tmp_path / "large.h5").read_bytes() == first


def test_a_dataset_beyond_the_memory_is_refused(tmp_path, monkeypatch):
    h5.write(tmp_path / "v.h5", "views", views(1, (4200, 4200)), PROVENANCE)
    monkeypatch.setenv("IPCLI_MAX_MEMORY", "70MB")
    with pytest.raises(FormatError, match=r"v\.h5: too large for the memory .*depth of shape \(4200, 4200\)"):
        h5.read(tmp_path / "v.h5", "views")


def all_readers(path):
    """What each way of reading does with a file: whether it fails with FormatError. Other errors pass through."""
    for reader in (lambda: h5.peek(path), lambda: h5.names(path), lambda: h5.read(path, "views")):
        try:
            reader()
        except FormatError as error:
            check_message(error)
            yield str(error)
        else:
            yield None


def test_a_cut_file_is_always_refused(path):
    data = path.read_bytes()
    for length in {*np.linspace(0, len(data) - 1, 60).astype(int), len(data) - 1, 1, 8}:
        path.write_bytes(data[:length])
        assert all(all_readers(path)), length


@settings(IN_FOLDER, max_examples=300)
@given(data=st.data())
def test_flipped_bytes_are_refused_or_harmless(data, path):
    sound = path.read_bytes()
    damaged = bytearray(sound)
    for _ in range(data.draw(st.integers(1, 3))):
        damaged[data.draw(st.integers(0, len(damaged) - 1))] ^= data.draw(st.integers(1, 255))
    try:
        path.write_bytes(damaged)
        if list(all_readers(path))[2] is None:
            assert_same(h5.read(path, "views").arrays, views())
    finally:
        path.write_bytes(sound)


def broken(file, attribute, value):
    del file.attrs[attribute]
    file.attrs[attribute] = np.bytes_(value) if isinstance(value, str) else value


def replaced(file, name, **dataset):
    attributes = dict(file[name].attrs)
    del file[name]
    file.create_dataset(name, **dataset).attrs.update(attributes)


def virtual(file):
    layout = h5py.VirtualLayout((4, 5), "f4")
    layout[:] = h5py.VirtualSource("/tmp/other.h5", "x", (4, 5))
    attributes = dict(file["views/001/depth"].attrs)
    del file["views/001/depth"]
    file.create_virtual_dataset("views/001/depth", layout).attrs.update(attributes)


DAMAGES = {
    "newer version": (
        lambda f: broken(f, "ipcli_version", 2),
        VersionTooNew,
        "newer version .expected 1, got 2.. Update ipcli",
    ),
    "older version": (
        lambda f: broken(f, "ipcli_version", 0),
        VersionTooOld,
        "older version .expected 1, got 0.. Make it again",
    ),
    "not complete": (lambda f: f.attrs.__delitem__("ipcli_complete"), FormatError, "incomplete artefact"),
    "no kind": (lambda f: f.attrs.__delitem__("ipcli_kind"), FormatError, "not an artefact of ipcli"),
    "other kind": (
        lambda f: broken(f, "ipcli_kind", "vews"),
        FormatError,
        "unknown kind of artefact 'vews'; did you mean 'views'",
    ),
    "version text": (lambda f: broken(f, "ipcli_version", "one"), FormatError, "not a readable HDF5 artefact"),
    "bad json": (lambda f: broken(f, "provenance", "{"), FormatError, "not a readable HDF5 artefact"),
    "json list": (lambda f: broken(f, "provenance", "[]"), FormatError, "provenance is not a JSON object"),
    "field missing": (lambda f: f.__delitem__("views/001/depth"), FormatError, "views/001/depth: missing"),
    "field unknown": (
        lambda f: f.create_dataset("views/001/extra", data=1),
        FormatError,
        "extra: not a field of 'views'",
    ),
    "empty group": (lambda f: f.create_group("views/004"), FormatError, "views/004: not a field"),
    "soft link": (
        lambda f: f.__setitem__("baseline_focal", h5py.SoftLink("/unit")),
        FormatError,
        "baseline_focal is a soft link to /unit",
    ),
    "external link": (
        lambda f: f.__setitem__("views/001/truth", h5py.ExternalLink("/etc/hosts", "/x")),
        FormatError,
        "views/001/truth is a link to /x in another file, /etc/hosts",
    ),
    "second name": (
        lambda f: f.__setitem__("views/001/truth", f["views/001/depth"]),
        FormatError,
        "views/001/truth is a second name of something else",
    ),
    "circle": (lambda f: f.__setitem__("views/001/views", f["views"]), FormatError, "is a second name of"),
    "external storage": (
        lambda f: replaced(f, "unit", shape=(4,), dtype="S1", external=[("other.raw", 0, 4)]),
        FormatError,
        "unit lies in another file, which is not followed",
    ),
    "virtual": (virtual, FormatError, "views/001/depth lies in another file, which is not followed"),
    "retyped": (lambda f: replaced(f, "views/001/depth", data=np.ones((4, 5))), FormatError, "damaged|wrong dtype"),
    "no checksum": (lambda f: f["unit"].attrs.__delitem__("crc32"), FormatError, "not a readable HDF5 artefact"),
    "null": (
        lambda f: replaced(f, "unit", dtype="f4", data=None, shape=None),
        FormatError,
        "unit is not a plain array",
    ),
    "text on the heap": (lambda f: replaced(f, "unit", data="m"), FormatError, "unit is not a plain array"),
    "mark on the heap": (
        lambda f: f.attrs.__setitem__("ipcli_kind", "views"),
        FormatError,
        "ipcli_kind is of variable length",
    ),
    "huge": (
        lambda f: replaced(f, "views/001/depth", shape=(1 << 20, 1 << 20), dtype="f4", chunks=(1, 5)),
        FormatError,
        "claims more data",
    ),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_doctored_file_is_refused_with_its_reason(damage, path):
    change, error, message = DAMAGES[damage]
    with h5py.File(path, "r+") as file:
        change(file)
    with pytest.raises(error, match=message):
        h5.read(path, "views")


def test_other_files_are_told_apart(path, tmp_path):
    with pytest.raises(FormatError, match="wrong kind of artefact .expected fused-depth, got views"):
        h5.read(path, "fused-depth")
    (tmp_path / "text.h5").write_text("hello")
    for name, message in (("absent.h5", "no such file"), ("", "no such file"), ("text.h5", "not a readable HDF5")):
        with pytest.raises(FormatError, match=message):
            h5.read(tmp_path / name, "views")


def test_the_record_of_thousands_of_inputs_fits(path):
    record = {"inputs": [{"name": f"{index:06d}.png", "sha256": "0" * 64} for index in range(5000)]}
    h5.write(path, "views", views(), record)
    assert h5.peek(path).provenance == record


def test_a_file_on_read_only_media_can_be_read(path, tmp_path):
    shutil.copy(path, tmp_path / "copy.h5")
    (tmp_path / "copy.h5").chmod(0o444)
    assert_same(h5.read(tmp_path / "copy.h5", "views").arrays, views())
