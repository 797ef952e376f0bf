"""Depth and colour come back exactly, what is missing is NaN, and what is cut or impossible is refused with
its place.
"""

import cv2
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as nps

from ipcli.errors import FormatError, IpcliError
from ipcli.io.files import images
from tests.fixtures.errors import check_message

IN_FOLDER = settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
SHAPES = nps.array_shapes(min_dims=2, max_dims=2, max_side=6)
DEPTHS = nps.arrays("f4", SHAPES, elements=st.floats(np.float32(1e-3), np.float32(1e6), width=32) | st.just(np.nan))
STORED = nps.arrays("u2", SHAPES)


def write_float(path, depth):
    """`depth` float32 by the writers of other libraries."""
    if path.suffix == ".npy":
        np.save(path, depth)
    elif path.suffix == ".npz":
        np.savez(path, depth=depth)
    else:
        assert cv2.imwrite(str(path), depth)


@pytest.mark.parametrize("suffix", [".pfm", ".tiff", ".npy", ".npz"])
def test_floats_of_other_writers_are_read_exactly(suffix, tmp_path):
    @IN_FOLDER
    @given(DEPTHS)
    def read(depth):
        write_float(tmp_path / f"d{suffix}", depth)
        found = images.read_depth(tmp_path / f"d{suffix}")
        assert found.dtype == np.float32
        np.testing.assert_array_equal(found, depth)

    read()


def test_a_big_endian_pfm_is_read_too(tmp_path):
    rows = np.arange(1, 7, dtype=">f4").reshape(2, 3)
    (tmp_path / "d.pfm").write_bytes(b"Pf\n3 2\n1.0\n" + rows[::-1].tobytes())
    np.testing.assert_array_equal(images.read_depth(tmp_path / "d.pfm"), rows)


@pytest.mark.parametrize("suffix", [".png", ".tiff"])
def test_sixteen_bits_are_divided_by_the_scale_and_both_ends_are_missing(suffix, tmp_path):
    @IN_FOLDER
    @given(STORED, st.sampled_from([1.0, 256.0, 5000.0]))
    def read(stored, scale):
        assert cv2.imwrite(str(tmp_path / f"d{suffix}"), stored)
        missing = (stored == 0) | (stored == 65535)
        expected = np.where(missing, np.nan, stored / scale).astype(np.float32)
        np.testing.assert_array_equal(images.read_depth(tmp_path / f"d{suffix}", scale), expected)

    read()


@IN_FOLDER
@given(STORED, st.sampled_from([256.0, 5000.0]))
def test_depth_png16_round_trip(tmp_path, stored, scale):
    depth = np.where((stored == 0) | (stored == 65535), np.nan, stored / scale).astype(np.float32)
    images.write_depth_png16(tmp_path / "d.png", depth, scale)
    np.testing.assert_array_equal(images.read_depth(tmp_path / "d.png", scale), depth)


@pytest.mark.parametrize("value", [65535 / 1000, 70.0, 1e300, np.inf, -1.0, 0.0, 0.0004])
def test_depth_that_sixteen_bits_cannot_hold_is_refused(tmp_path, value):
    with pytest.raises(FormatError, match="does not fit 16 bits .expected 1 to 65534, got .*1 pixels outside"):
        images.write_depth_png16(tmp_path / "d.png", np.array([[1.0, value, np.nan]]), 1000.0)
    assert list(tmp_path.iterdir()) == []


def test_sixteen_bits_without_a_scale_are_refused(tmp_path):
    images.write_png(tmp_path / "d.png", np.ones((2, 2), np.uint16))
    with pytest.raises(FormatError, match="16-bit depth of unknown scale. Give the depth scale"):
        images.read_depth(tmp_path / "d.png")


@pytest.mark.parametrize("value", [-1.0, -np.inf])
@pytest.mark.parametrize("suffix", [".pfm", ".tiff", ".npy", ".npz"])
def test_impossible_depth_is_refused_with_count_and_first_pixel(tmp_path, suffix, value):
    depth = np.array([[1, np.nan, 0], [2, value, value]], np.float32)
    write_float(tmp_path / f"d{suffix}", depth)
    with pytest.raises(FormatError, match=rf"2 pixels, the first {value} at row 1, column 1"):
        images.read_depth(tmp_path / f"d{suffix}")
    write_float(tmp_path / f"d{suffix}", np.abs(depth[:1]))
    np.testing.assert_array_equal(images.read_depth(tmp_path / f"d{suffix}", 2.0), [[0.5, np.nan, np.nan]])


def test_doubles_too_large_or_small_for_the_result_are_refused(tmp_path):
    np.save(tmp_path / "d.npy", np.array([[1e300, 1e-300, 1.0]]))
    with pytest.raises(FormatError, match="32-bit floats cannot hold .*2 pixels"):
        images.read_depth(tmp_path / "d.npy")


def test_what_is_not_one_depth_map_is_refused(tmp_path):
    np.save(tmp_path / "three.npy", np.ones((2, 2, 3)))
    np.save(tmp_path / "empty.npy", np.ones((0, 2)))
    np.save(tmp_path / "int.npy", np.ones((2, 2), np.int8))
    np.savez(tmp_path / "two.npz", a=np.ones((2, 2)), b=np.ones((2, 2)))
    images.write_png(tmp_path / "eight.png", np.ones((2, 2), np.uint8))
    (tmp_path / "d.jpg").write_bytes(b"x")
    expected = {
        "three.npy": "expected shape .h, w., got .2, 2, 3.",
        "empty.npy": "not one depth map",
        "int.npy": "expected floats, or integers of 16 bits or more, got int8",
        "two.npz": "expected a single array, got 2: a, b",
        "eight.png": "got uint8",
        "d.jpg": "not a depth file .*got .jpg",
        "absent.png": "No such file",
        "absent.npz": "No such file",
    }
    for name, message in expected.items():
        with pytest.raises(FormatError, match=rf"{name}: .*{message}"):
            images.read_depth(tmp_path / name, 1.0)


@pytest.mark.parametrize("background", [np.inf, 1e10, 65504.0])
def test_the_background_of_renderers_is_no_depth(tmp_path, background):
    depth = np.random.default_rng(0).uniform(1, 5, (20, 20)).astype(np.float32)
    depth[:3] = background
    np.save(tmp_path / "d.npy", depth)
    found = images.read_depth(tmp_path / "d.npy")
    assert np.isnan(found[:3]).all()
    np.testing.assert_array_equal(found[3:], depth[3:])


def test_a_far_wall_is_no_background(tmp_path):
    depth = np.random.default_rng(0).uniform(1, 5, (20, 20)).astype(np.float32)
    depth[:3] = 300
    np.save(tmp_path / "d.npy", depth)
    np.testing.assert_array_equal(images.read_depth(tmp_path / "d.npy"), depth)


@pytest.mark.parametrize("kind", [np.int16, np.int32, np.uint32, np.int64])
def test_wide_integers_need_a_scale_as_sixteen_bits_do(tmp_path, kind):
    np.save(tmp_path / "d.npy", np.array([[0, 1500, 2500]], kind))
    np.testing.assert_array_equal(images.read_depth(tmp_path / "d.npy", 1000), [[np.nan, 1.5, 2.5]])
    with pytest.raises(FormatError, match="-bit depth of unknown scale"):
        images.read_depth(tmp_path / "d.npy")


def test_an_empty_file_is_called_so(tmp_path):
    (tmp_path / "d.png").write_bytes(b"")
    with pytest.raises(FormatError, match=r"d\.png: empty file"):
        images.read_depth(tmp_path / "d.png", 1.0)


PICTURE = np.random.default_rng(0).integers(0, 256, (24, 32, 3), np.uint8)


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".pfm", ".tiff", ".npy", ".npz"])
def test_a_cut_file_is_refused_without_chatter_unless_all_pixels_are_there(tmp_path, suffix, capfd):
    path = tmp_path / f"d{suffix}"
    if suffix in (".png", ".jpg"):
        assert cv2.imwrite(str(path), PICTURE)
        read = images.read_image
    else:
        write_float(path, PICTURE[..., 0].astype(np.float32) + 1)
        read = images.read_depth
    whole, data, complete = read(path), path.read_bytes(), []
    for length in sorted({0, 1, *np.linspace(2, len(data) - 1, 60).astype(int)}):
        path.write_bytes(data[:length])
        try:
            np.testing.assert_array_equal(read(path), whole)
            complete.append(len(data) - length)
        except FormatError as error:
            check_message(error)
    # TIFF ends with a link to the next picture, which no pixel needs
    assert max(complete, default=0) <= (4 if suffix == ".tiff" else 0)
    assert capfd.readouterr() == ("", "")


def test_a_flipped_byte_of_a_png_is_refused(tmp_path):
    data = images.encode_png(PICTURE)
    for index in range(0, len(data), 97):
        (tmp_path / "p.png").write_bytes(data[:index] + bytes([data[index] ^ 1]) + data[index + 1 :])
        with pytest.raises(FormatError):
            images.read_image(tmp_path / "p.png")


def test_colours_are_rgb_for_us_and_for_others(tmp_path):
    images.write_png(tmp_path / "p.png", PICTURE)
    np.testing.assert_array_equal(images.read_image(tmp_path / "p.png"), PICTURE)
    np.testing.assert_array_equal(cv2.imread(str(tmp_path / "p.png"))[..., ::-1], PICTURE)


def test_grey_is_repeated_and_alpha_dropped(tmp_path):
    images.write_png(tmp_path / "grey.png", PICTURE[..., 0])
    np.testing.assert_array_equal(images.read_image(tmp_path / "grey.png"), np.repeat(PICTURE[..., :1], 3, axis=2))
    assert cv2.imwrite(str(tmp_path / "alpha.png"), np.dstack([PICTURE[..., ::-1], np.zeros((24, 32), np.uint8)]))
    np.testing.assert_array_equal(images.read_image(tmp_path / "alpha.png"), PICTURE)


@pytest.mark.parametrize(
    "array", [np.ones((2, 2)), np.ones((2, 2, 4), np.uint8), np.ones(3, np.uint8), np.ones((0, 2), np.uint8)]
)
def test_what_png_cannot_hold_is_refused(array):
    with pytest.raises(IpcliError, match="PNG: expected"):
        images.encode_png(array)


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".tif"])
def test_more_pixels_than_memory_are_refused_before_they_are_decoded(suffix, tmp_path, monkeypatch):
    monkeypatch.setenv("IPCLI_MAX_MEMORY", "70MB")
    path = tmp_path / f"white{suffix}"
    cv2.imwrite(str(path), np.full((2500, 4000), 255, np.uint8))
    monkeypatch.setattr(cv2, "imdecode", lambda *_: pytest.fail("decoded"))
    with pytest.raises(FormatError, match="4000 x 2500 pixels, which take 80 MB"):
        images.read_image(path)
