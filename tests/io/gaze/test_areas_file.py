"""Tables and clouds of areas of interest, and what is wrong with others."""

import numpy as np
import pytest

from ipcli.errors import FormatError
from ipcli.io.files import ply
from ipcli.io.gaze.areas_file import read_areas

BOXES = "name,x0 [m],y0 [m],z0 [m],x1 [m],y1 [m],z1 [m]\n"
CORNERS = "name,x [m],y [m],z [m]\n"


def test_boxes_whose_corners_come_in_any_order(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(BOXES + "shelf,1,0,3,0,2,2\ncup,0,0,0,1,1,1\n")
    found = read_areas(path)
    assert found.names == ("shelf", "cup")
    np.testing.assert_array_equal(found.boxes[0], [[0, 0, 2], [1, 2, 3]])


def test_polygons_keep_the_order_of_their_corners(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(CORNERS + "".join(f"{name},{x},{x * x},2\n" for x in (3, 1, 2) for name in ("door", "wall")))
    found = read_areas(path)
    assert found.names == ("door", "wall")
    np.testing.assert_array_equal(found.polygons[1], [[3, 9, 2], [1, 1, 2], [2, 4, 2]])


def test_labels_of_a_cloud_without_the_unlabelled(tmp_path):
    path = tmp_path / "a.ply"
    ply.write(path, np.arange(12, dtype=np.float32).reshape(4, 3), extra={"label": np.array([0, 7, 2, 7], np.uint8)})
    found = read_areas(path)
    assert found.names == ("2", "7")
    np.testing.assert_array_equal(found.clouds[1], [[3, 4, 5], [9, 10, 11]])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("label,x [m]\na,1\n", "no names"),
        ("name,x [m]\na,1\n", "no table of areas"),
        (CORNERS + "a,0,0,0\na,1,0,0\n", "a is no polygon"),
        (CORNERS + "a,0,0,\na,1,0,0\na,1,1,0\n", "no place"),
        (BOXES + "a,0,0,0,1,1,1\na,0,0,0,1,1,1\n", "one name"),
    ],
)
def test_others_are_refused(tmp_path, text, said):
    path = tmp_path / "a.csv"
    path.write_text(text)
    with pytest.raises(FormatError, match=said):
        read_areas(path)


def test_a_cloud_without_labels_is_refused(tmp_path):
    ply.write(tmp_path / "a.ply", np.zeros((3, 3), np.float32))
    with pytest.raises(FormatError, match="no labels"):
        read_areas(tmp_path / "a.ply")
