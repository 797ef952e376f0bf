"""Part masks of every kind, and files that are none."""

import json

import numpy as np
import pytest
from PIL import Image

from ipcli.errors import FormatError
from ipcli.io.files import images
from ipcli.io.parts import masks

LABELS = np.zeros((20, 30), np.uint8)
LABELS[2:10, 3:20] = 1
LABELS[10:18, 5:9] = 2
NAMES = ("torso", "leg")


def test_an_index_png_grey_or_with_a_palette(tmp_path):
    images.write_png(tmp_path / "grey.png", LABELS)
    palette = Image.fromarray(LABELS, mode="P")
    palette.putpalette([0, 0, 0, 200, 10, 10, 10, 200, 10])
    palette.save(tmp_path / "palette.png")
    for name in ("grey.png", "palette.png"):
        found = masks.read(tmp_path / name, NAMES)
        assert found.names == NAMES
        assert (found.labels == LABELS).all()


def test_colours_are_not_taken_for_one_part(tmp_path):
    """A picture in which each part has a colour of its own: nothing says which is which."""
    table = np.array([[0, 0, 0], [200, 30, 30], [30, 200, 30], [30, 30, 200]], np.uint8)
    images.write_png(tmp_path / "rgb.png", table[LABELS])
    with pytest.raises(
        FormatError, match=f"{len(np.unique(LABELS))} colours, which do not say.*folder of one PNG a part"
    ):
        masks.read(tmp_path / "rgb.png", NAMES)
    images.write_png(tmp_path / "grey.png", np.repeat(LABELS[..., None], 3, axis=2))
    np.testing.assert_array_equal(masks.read(tmp_path / "grey.png", NAMES).labels, LABELS)
    np.testing.assert_array_equal(masks.read(tmp_path / "rgb.png", ["torso"]).labels, LABELS > 0)


@pytest.mark.parametrize("mode", ["LA", "RGBA"])
def test_what_is_transparent_is_background(tmp_path, mode):
    image = Image.fromarray(LABELS, mode="L").convert(mode)
    image.putalpha(Image.fromarray(np.where(LABELS == 2, 0, 255).astype(np.uint8)))
    image.save(tmp_path / "a.png")
    np.testing.assert_array_equal(masks.read(tmp_path / "a.png", NAMES).labels, np.where(LABELS == 2, 0, LABELS))


def test_a_value_without_a_name_says_what_to_add(tmp_path):
    images.write_png(tmp_path / "a.png", LABELS)
    with pytest.raises(FormatError, match="labels"):
        masks.read(tmp_path / "a.png", ("torso",))


def test_a_folder_of_one_png_a_part(tmp_path):
    for number, name in ((1, "torso"), (2, "leg")):
        images.write_png(tmp_path / "m" / f"{name}.png", np.where(number == LABELS, 255, 0).astype(np.uint8))
    found = masks.read(tmp_path / "m")
    assert found.names == ("leg", "torso")
    assert ((found.labels == 2) == (LABELS == 1)).all()


def labelme(shapes, height=20, width=30):
    return json.dumps({"shapes": shapes, "imageHeight": height, "imageWidth": width})


def test_labelme_polygons_and_rectangles(tmp_path):
    shapes = [
        {"label": "torso", "points": [[3, 2], [19, 2], [19, 9], [3, 9]], "shape_type": "polygon"},
        {"label": "leg", "points": [[5, 10], [8, 17]], "shape_type": "rectangle"},
    ]
    (tmp_path / "a.json").write_text(labelme(shapes))
    assert (masks.read(tmp_path / "a.json").labels == LABELS).all()


@pytest.mark.parametrize(
    "text",
    [
        "", "[]", "{", "[" * 5000, labelme([]), labelme([{"label": "a", "points": [[0, 0]]}]),
        labelme([{"label": "a", "points": [[0, 0], [1, float("nan")], [2, 2]]}]),
        labelme([{"label": "a", "points": [[0, 0], [1, 0], [2, 2]]}], height=0),
        labelme([{"label": "a", "points": [[0, 0], [1, 10**400], [2, 2]]}]),
        labelme([{"label": "a", "points": [[0, 0], [1, 0], [2, 2]]}], height=10**6, width=10**6),
    ],
)  # fmt: skip
def test_damaged_labelme_is_refused(tmp_path, text):
    (tmp_path / "a.json").write_text(text)
    with pytest.raises(FormatError, match=r"a\.json"):
        masks.read(tmp_path / "a.json")


def test_a_cut_png_and_another_suffix_are_refused(tmp_path):
    images.write_png(tmp_path / "a.png", LABELS)
    (tmp_path / "cut.png").write_bytes((tmp_path / "a.png").read_bytes()[:-20])
    (tmp_path / "a.gif").write_bytes(b"GIF")
    for name in ("cut.png", "a.gif"):
        with pytest.raises(FormatError, match=name):
            masks.read(tmp_path / name, ("a", "b"))


def test_a_picture_too_large_is_refused_before_it_is_decoded(tmp_path, monkeypatch):
    images.write_png(tmp_path / "a.png", LABELS)
    monkeypatch.setattr(masks, "MOST_PIXELS", 100)
    with pytest.raises(FormatError, match="too large"):
        masks.read(tmp_path / "a.png", ("a", "b"))


def test_masks_of_two_sizes_are_refused(tmp_path):
    images.write_png(tmp_path / "m" / "a.png", LABELS)
    images.write_png(tmp_path / "m" / "b.png", LABELS[:10])
    with pytest.raises(FormatError, match=r"b\.png"):
        masks.read(tmp_path / "m")
