"""The plain layout: pictures and fixations.csv, and what may be wrong with it."""

import pytest

from ipcli.errors import FormatError
from ipcli.io.fixations.folder import open_folder
from tests.fixtures.fixation_sets import write_pictures


def test_points_and_observers_come_back_by_picture(tmp_path):
    write_pictures(tmp_path, 2)
    (tmp_path / "fixations.csv").write_text("picture,x,y,observer\np1.png,3,4.5,bo\np0.png,1,2,al\np1.png,5,6,al\n")
    first, second = open_folder(tmp_path).pictures
    assert (first.name, second.name) == ("p0", "p1")
    assert second.fixations.tolist() == [[3.0, 4.5], [5.0, 6.0]]
    assert second.observers.tolist() == [1, 0]
    assert first.read().shape == (96, 128, 3)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("picture,x\np0.png,1\n", "no column 'y'"),
        ("picture,x,y\np0.png,one,2\n", "line 2: x and y are no numbers"),
        ("picture,x,y\np0.png,nan,2\n", "not finite"),
        ("picture,x,y\np0.png\n", "line 2"),
        ("picture,x,y\n../p0.png,1,2\n", "not the name of a picture"),
        ("picture,x,y\np9.png,1,2\n", "no such picture"),
        (f"picture,x,y\n{'x' * 5000},1,2\n", "no such picture"),
        ("picture,x,y\n", "no fixations"),
        ("", "no column"),
    ],
)
def test_what_is_wrong_is_said(tmp_path, text, message):
    write_pictures(tmp_path, 1)
    (tmp_path / "fixations.csv").write_text(text)
    with pytest.raises(FormatError, match=message):
        open_folder(tmp_path)
