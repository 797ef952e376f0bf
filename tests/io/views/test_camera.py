"""Cameras described in TOML."""

import numpy as np
import pytest

from ipcli.errors import FormatError
from ipcli.io.views import camera

POSE = "cam_from_world = [1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]"
GOOD = f"width = 6\nheight = 4\nintrinsics = [5.0, 5, 2.5, 1.5]\n{POSE}\n"


def test_a_camera_is_a_view_that_has_seen_nothing(tmp_path):
    (tmp_path / "mine.toml").write_text(GOOD)
    view = camera.read(tmp_path / "mine.toml")
    assert view.name == "mine"
    assert view.depth.shape == (4, 6)
    assert np.isnan(view.depth).all()
    np.testing.assert_array_equal(view.intrinsics, [[5, 0, 2.5], [0, 5, 1.5], [0, 0, 1]])
    assert view.cam_from_world[0, 3] == 0.5


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("width = ", "not valid TOML"),
        (GOOD + "depth = 1", "'depth' is not a key"),
        (GOOD.replace("width = 6\n", ""), "'width' is missing"),
        (GOOD.replace("width = 6", "width = 6.5"), "width has the wrong type"),
        (GOOD.replace("width = 6", "width = 0"), "no size"),
        (GOOD.replace("2.5, 1.5", "2.5"), "intrinsics has the wrong length"),
        (GOOD.replace("0.5", '"a"'), "cam_from_world holds something else"),
        (GOOD.replace("[1, 0", "[2, 0"), "not rigid"),
    ],
)
def test_a_wrong_camera_is_refused_in_one_line_that_names_the_file(tmp_path, text, says):
    (tmp_path / "mine.toml").write_text(text)
    with pytest.raises(FormatError, match=says) as caught:
        camera.read(tmp_path / "mine.toml")
    assert "mine.toml" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_camera_of_more_pixels_than_memory_is_refused(tmp_path):
    (tmp_path / "mine.toml").write_text(GOOD.replace("width = 6", "width = 200000").replace("= 4\n", "= 200000\n"))
    with pytest.raises(FormatError, match="too large for the memory.*200000 x 200000 pixels, which take 160 GB"):
        camera.read(tmp_path / "mine.toml")
