"""The layout of OSIE: cells in cells, points that count from 1."""

import numpy as np
import pytest
from scipy.io import savemat

from ipcli.errors import FormatError
from ipcli.io.files import images
from ipcli.io.fixations.layouts import open_fixations


def write(folder, *names):
    def cell(parts):
        made = np.empty((len(parts), 1), object)
        made[:, 0] = parts
        return made

    subjects = [
        {"fix_x": np.array([[11.0, 21.5]]), "fix_y": np.array([[1.0, 6.0]])},
        {"fix_x": np.array([[3.0]]), "fix_y": np.array([[4.0]])},
    ]
    records = [{"img": name, "subjects": cell(subjects)} for name in names or ("1001.jpg",)]
    savemat(folder / "fixations.mat", {"fixations": cell(records)})
    (folder / "stimuli").mkdir()
    images.write_png(folder / "stimuli" / "1001.jpg", np.full((8, 30, 3), 7, np.uint8))
    return folder


def test_points_count_from_0_and_observers_are_told_apart(tmp_path):
    (picture,) = open_fixations(write(tmp_path)).pictures
    assert picture.name == "1001"
    assert picture.fixations.tolist() == [[10.0, 0.0], [20.5, 5.0], [2.0, 3.0]]
    assert picture.observers.tolist() == [0, 0, 1]
    assert picture.read().shape == (8, 30, 3)


@pytest.mark.parametrize("name", ["1002.jpg", "../1001.jpg", "x" * 5000])
def test_a_picture_that_is_not_there_is_named(tmp_path, name):
    with pytest.raises(FormatError, match="picture"):
        open_fixations(write(tmp_path, name))


def test_pictures_that_are_there_are_taken_and_the_others_told_of(tmp_path):
    found = open_fixations(write(tmp_path, "1000.jpg", "1001.jpg", "1002.jpg"))
    assert found.names == ("1001",)
    assert found.notes == ("2 of 3 pictures that fixations.mat names are not there, and left out: 1000.jpg, ...",)
    assert open_fixations(tmp_path).names == ("1001",)


@pytest.mark.parametrize("data", [b"", b"MATLAB 5.0 and then nothing", bytes(200)])
def test_a_damaged_file_is_an_error_in_one_line(tmp_path, data):
    write(tmp_path)
    (tmp_path / "fixations.mat").write_bytes(data)
    with pytest.raises(FormatError, match="fixations.mat"):
        open_fixations(tmp_path)
