"""Tables of landmarks with and without marks."""

import numpy as np
import pytest

from ipcli.errors import FormatError
from ipcli.io.gaze.landmarks_file import read_landmarks


def test_places_alone(tmp_path):
    path = tmp_path / "l.csv"
    path.write_text("name,x [m],y [m],z [m]\ndoor,1,2,3\nlamp,4,5,6\n")
    found = read_landmarks(path)
    assert found.names == ("door", "lamp")
    np.testing.assert_array_equal(found.places, [[1, 2, 3], [4, 5, 6]])
    assert found.marks == ()


def test_a_line_a_mark(tmp_path):
    path = tmp_path / "l.csv"
    path.write_text(
        "name,x [m],y [m],z [m],frame,u [px],v [px]\ndoor,1,2,3,a01,10,20\nlamp,4,5,6,a01,30,40\ndoor,1,2,3,a02,11,21\n"
        "lamp,4,5,6,a02,,\n"
    )
    found = read_landmarks(path)
    assert found.names == ("door", "lamp")
    assert found.marks == ((0, "a01", 10.0, 20.0), (1, "a01", 30.0, 40.0), (0, "a02", 11.0, 21.0))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("name,x [m],y [m]\na,1,2\n", "no table of landmarks"),
        ("name,x [m],y [m],z [m]\na,1,2,\nb,1,2,3\n", "no place"),
        ("name,x [m],y [m],z [m]\na,1,2,3\na,1,2,4\n", "two places"),
        ("name,x [m],y [m],z [m],frame\na,1,2,3,f\n", "marks of landmarks"),
    ],
)
def test_others_are_refused(tmp_path, text, said):
    path = tmp_path / "l.csv"
    path.write_text(text)
    with pytest.raises(FormatError, match=said):
        read_landmarks(path)
