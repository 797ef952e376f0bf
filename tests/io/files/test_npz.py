"""NPZ holds numbers, comes back bit for bit, and is refused when damaged."""

import zipfile

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as nps

from ipcli.errors import FormatError, IpcliError
from ipcli.io.files import images, npz

IN_FOLDER = settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
DTYPES = st.sampled_from(["?", "i1", "<u2", ">i4", "<f4", "<f8", "<c16"])
ARRAYS = st.dictionaries(
    st.sampled_from(["file", "a", "b c", "é", "x.npy"]),
    nps.arrays(DTYPES, nps.array_shapes(min_dims=0, min_side=0, max_dims=3, max_side=3)),
)


@IN_FOLDER
@given(ARRAYS)
def test_round_trip(tmp_path, arrays):
    npz.write(tmp_path / "a.npz", arrays)
    found = npz.read(tmp_path / "a.npz")
    assert found.keys() == arrays.keys()
    for name, array in arrays.items():
        assert (found[name].dtype, found[name].shape) == (array.dtype, array.shape)
        assert found[name].tobytes() == array.tobytes()
    first = (tmp_path / "a.npz").read_bytes()
    npz.write(tmp_path / "a.npz", dict(reversed(arrays.items())))
    assert (tmp_path / "a.npz").read_bytes() == first


def test_numpy_reads_it(tmp_path):
    npz.write(tmp_path / "a.npz", {"x": np.arange(3)})
    assert np.load(tmp_path / "a.npz")["x"].tolist() == [0, 1, 2]


@pytest.mark.parametrize("array", [np.array([{}]), np.array(["text"]), np.array(["2020-01-01"], "M8[D]")])
def test_other_than_numbers_is_refused_and_nothing_written(tmp_path, array):
    with pytest.raises(IpcliError, match="NPZ holds numbers only"):
        npz.write(tmp_path / "a.npz", {"fine": np.ones(2), "x": array})
    assert list(tmp_path.iterdir()) == []


def test_a_pickle_inside_is_refused_and_not_run(tmp_path):
    np.savez(tmp_path / "a.npz", x=np.array([print], dtype=object))
    with pytest.raises(FormatError, match="Object arrays cannot be loaded"):
        npz.read(tmp_path / "a.npz")


def test_every_cut_is_refused_and_every_flip_refused_or_harmless(tmp_path):
    arrays = {"a": np.arange(12.0).reshape(3, 4), "b": np.arange(5, dtype=np.uint8)}
    npz.write(tmp_path / "a.npz", arrays)
    data = (tmp_path / "a.npz").read_bytes()
    for length in range(0, len(data), 7):
        (tmp_path / "cut.npz").write_bytes(data[:length])
        with pytest.raises(FormatError):
            npz.read(tmp_path / "cut.npz")
    for index in range(len(data)):
        (tmp_path / "flip.npz").write_bytes(data[:index] + bytes([data[index] ^ 0x55]) + data[index + 1 :])
        try:
            found = npz.read(tmp_path / "flip.npz")
        except FormatError:
            continue
        for array in found.values():  # a name may be damaged, since ZIP does not protect names; data are not
            assert any(np.array_equal(array, original) for original in arrays.values()), index


@pytest.mark.parametrize(
    "header",
    [b"{'descr': '<f8', 'shape': (", b"{'descr': '<f8', 'fortran_order': 0, 'shape': (9**9,)}", b"((((" * 2000, b"\0"],
)
def test_the_header_of_an_array_may_be_any_python(tmp_path, header):
    data = b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header
    with zipfile.ZipFile(tmp_path / "a.npz", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a.npy", data)
    with pytest.raises(FormatError, match="not a readable NPZ"):
        npz.read(tmp_path / "a.npz")
    (tmp_path / "a.npy").write_bytes(data)
    with pytest.raises(FormatError, match="not a readable NPY"):
        images.read_npy(tmp_path / "a.npy")


def test_a_stream_that_does_not_inflate_is_refused(tmp_path):
    with zipfile.ZipFile(tmp_path / "a.npz", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a.npy", bytes(1000))
    whole = (tmp_path / "a.npz").read_bytes()
    (tmp_path / "a.npz").write_bytes(whole[:35] + b"\xff\xff" + whole[37:])
    with pytest.raises(FormatError, match="not a readable NPZ"):
        npz.read(tmp_path / "a.npz")


def test_absence_is_told(tmp_path):
    with pytest.raises(FormatError, match="No such file"):
        npz.read(tmp_path / "absent.npz")


def test_what_would_not_fit_into_the_memory_is_refused_before_it_is_unpacked(tmp_path, monkeypatch):
    monkeypatch.setenv("IPCLI_MAX_MEMORY", "100MB")
    with zipfile.ZipFile(tmp_path / "small.npz", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("zeros.npy", bytes(60_000_000))
    assert (tmp_path / "small.npz").stat().st_size < 100_000
    with pytest.raises(FormatError, match=r"too large for the memory .*unpacked arrays, which take 120 MB"):
        npz.read(tmp_path / "small.npz")
