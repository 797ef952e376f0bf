"""Photographs and masks: conventions there and back, and every fault that users of such tools meet."""

import numpy as np
import pytest

from ipcli.errors import FormatError
from ipcli.io.files import images
from ipcli.io.materials import photographs


def write(folder, picture=None, mask=None):
    picture = np.full((20, 30, 3), 90, np.uint8) if picture is None else picture
    if mask is None:
        mask = np.zeros((20, 30), np.uint8)
        mask[4:15, 5:25] = 255
    images.write_png(folder / "p.png", picture)
    images.write_png(folder / "m.png", mask)
    return folder / "p.png", folder / "m.png"


def test_gamma_is_undone_and_channels_keep_their_order(tmp_path):
    picture = np.zeros((20, 30, 3), np.uint8)
    picture[..., 0], picture[..., 1] = 188, 255
    photo = photographs.read(*write(tmp_path, picture), "srgb")
    np.testing.assert_allclose(photo.colour[0, 0], [0.503, 1, 0], atol=0.003)
    assert photo.saturated == 1
    np.testing.assert_array_equal(photo.shown, picture)


def test_sixteen_bits_are_taken_as_they_are(tmp_path):
    photo = photographs.read(*write(tmp_path, np.full((20, 30), 32768, np.uint16)), "linear")
    np.testing.assert_allclose(photo.colour, 32768 / 65535)
    assert photo.shown[0, 0, 0] == 188


@pytest.mark.parametrize(
    ("mask", "message"),
    [
        ("small", "differ in size"),
        ("empty", "empty"),
        ("full", "all object"),
        ("two", "several pieces"),
        ("grey", "a picture of greys, not a mask"),
    ],
)
def test_wrong_masks_are_told(tmp_path, mask, message):
    made = {
        "small": np.ones((3, 3)),
        "empty": np.zeros((20, 30)),
        "full": np.ones((20, 30)),
        "two": np.zeros((20, 30)),
        "grey": np.tile(np.linspace(0, 1, 30), (20, 1)),
    }[mask]
    if mask == "two":
        made[2:8, 2:8] = made[12:18, 12:18] = 1
    with pytest.raises(FormatError, match=message):
        photographs.read(*write(tmp_path, mask=(255 * made).astype(np.uint8)), "srgb")


def test_specks_and_pin_holes_of_a_mask_are_mended_but_a_window_is_kept(tmp_path):
    mask = np.zeros((100, 100), np.uint8)
    mask[5:90, 5:90] = 255
    mask[95, 95] = 255
    mask[20, 20] = 0
    mask[40:60, 40:60] = 0
    images.write_png(tmp_path / "m.png", mask)
    read = photographs.read_mask(tmp_path / "m.png", (100, 100))
    assert not read[95, 95]
    assert read[20, 20]
    assert not read[50, 50]


@pytest.mark.parametrize("convention", photographs.CONVENTIONS)
def test_normals_come_back_in_every_convention(tmp_path, convention):
    rng = np.random.default_rng(0)
    n = rng.normal(size=(6, 7, 3))
    n[..., 2] = np.abs(n[..., 2])
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    n[0, 0] = np.nan
    images.write_png(tmp_path / "n.png", photographs.encode_normals(n, convention))
    read = photographs.read_normals(tmp_path / "n.png", convention, (6, 7))
    np.testing.assert_allclose(read[1:], n[1:], atol=5e-5)


def test_normals_of_another_convention_are_refused(tmp_path):
    n = np.tile([0.0, 0.0, 1.0], (4, 4, 1))
    np.save(tmp_path / "n.npy", n)
    with pytest.raises(FormatError, match="face away.*--convention"):
        photographs.read_normals(tmp_path / "n.npy", "opencv", (4, 4))
    np.save(tmp_path / "n.npy", 3 * n)
    with pytest.raises(FormatError, match="unit length"):
        photographs.read_normals(tmp_path / "n.npy", "opengl", (4, 4))


def test_a_map_of_another_kind_is_refused_by_its_suffix(tmp_path):
    (tmp_path / "n.mat").write_bytes(b"MATLAB 5.0 MAT-file")
    with pytest.raises(FormatError, match=r"expected \.npy, \.npz or \.png, got \.mat"):
        photographs.read_height(tmp_path / "n.mat", (20, 30))


def test_a_mask_that_is_not_finite_is_refused(tmp_path):
    import cv2

    plane = np.zeros((20, 30), np.float32)
    plane[4:15, 5:25] = 255
    plane[0, 0] = np.nan
    cv2.imwrite(str(tmp_path / "m.tiff"), plane)
    with pytest.raises(FormatError, match="not finite"):
        photographs.read_mask(tmp_path / "m.tiff", plane.shape)


def test_a_photograph_is_turned_as_its_camera_says(tmp_path):
    from PIL import Image

    left_dark = Image.fromarray(np.repeat(np.linspace(20, 200, 32).astype(np.uint8)[None, :, None], 16, 0).repeat(3, 2))
    turned = left_dark.getexif()
    turned[0x0112] = 6  # the top of the scene is on the right
    left_dark.save(tmp_path / "a.jpg", exif=turned, quality=95)
    shown = images.read_stored(tmp_path / "a.jpg")
    assert shown.shape == (32, 16, 3)
    assert shown[0].mean() < 30 < 180 < shown[-1].mean()
