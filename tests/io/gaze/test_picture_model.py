"""A COLMAP model as somebody else's program writes it, with its pictures."""

import numpy as np
import pytest

from ipcli.errors import FormatError
from ipcli.io.files import atomic
from ipcli.io.files.images import encode_png
from ipcli.io.gaze.picture_model import read_picture_model

IMAGES = """1 1 0 0 0 0.5 0 0 1 a.png
10.5 20.5 7 3.5 4.5 -1 30.5 40.5 9
2 0.7071067811865476 0 0.7071067811865476 0 0 0 2 1 sub/b
5.5 6.5 9
3 1 0 0 0 0 0 0 1 gone.png
1.5 2.5 7
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "cameras.txt").write_text("1 PINHOLE 64 48 50 50 32 24\n")
    (tmp_path / "images.txt").write_text(IMAGES)
    (tmp_path / "points3D.txt").write_text("7 1 2 3 10 20 30 0.1 1 0 3 0\n9 4 5 6 90 90 90 0.1 1 2 2 0\n")
    (tmp_path / "sub").mkdir()
    for name, grey in (("a.png", 7), ("sub/b.png", 8)):
        atomic.write_bytes(tmp_path / name, encode_png(np.full((48, 64), grey, np.uint8)))
    return tmp_path


def test_points_poses_and_what_each_picture_shows(folder):
    pytest.importorskip("pycolmap")
    model = read_picture_model(folder, folder)
    np.testing.assert_array_equal(model.points, [[1, 2, 3], [4, 5, 6]])
    np.testing.assert_array_equal(model.grey, [20, 90])
    assert [shown.tolist() for shown in model.shown] == [[0, 1], [1]]  # the third picture is not there
    np.testing.assert_allclose(model.pixels[0], [[10, 20], [30, 40]])  # COLMAP counts from the corner
    np.testing.assert_allclose(model.poses[1] @ [1, 0, 0, 1], [0, 0, 1, 1], atol=1e-12)  # a quarter turn, then 2 ahead
    assert [model.load(k)[0, 0] for k in (0, 1)] == [7, 8]
    assert {path.name for path in model.files} >= {"images.txt", "a.png", "b.png"}


def test_a_model_without_its_pictures_and_pictures_without_a_model_are_refused(folder, tmp_path):
    pytest.importorskip("pycolmap")
    (tmp_path / "other").mkdir()
    with pytest.raises(FormatError, match="none of the model's pictures"):
        read_picture_model(folder, tmp_path / "other")
    with pytest.raises(FormatError, match="cannot be read"):
        read_picture_model(tmp_path / "other", folder)


def test_a_name_that_no_file_can_have_is_that_of_no_picture(folder):
    pytest.importorskip("pycolmap")
    (folder / "images.txt").write_text(IMAGES.replace("a.png", "x" * 5000))
    assert [shown.tolist() for shown in read_picture_model(folder, folder).shown] == [[1]]


def test_a_name_that_leads_out_of_the_folder_is_not_followed(folder, tmp_path):
    pytest.importorskip("pycolmap")
    (folder / "images.txt").write_text(IMAGES.replace("a.png", "../" + folder.name + "/a.png"))
    assert [shown.tolist() for shown in read_picture_model(folder, folder).shown] == [[1]]
