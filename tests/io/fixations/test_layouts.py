import pytest

from ipcli.errors import FormatError
from ipcli.io.fixations.layouts import open_fixations
from tests.fixtures.fixation_sets import write_pictures, write_surfaces


def test_each_layout_is_told_by_what_it_holds(tmp_path):
    assert open_fixations(write_pictures(tmp_path / "p", 1)).names == ("p0",)
    assert open_fixations(write_surfaces(tmp_path / "s", 1)).names == ("ball0",)


def test_blurred_maps_alone_are_no_set(tmp_path):
    (tmp_path / "a.png").write_bytes(b"")
    (tmp_path / "a_fixMap.png").write_bytes(b"")
    with pytest.raises(FormatError, match="no known layout of fixation sets"):
        open_fixations(tmp_path)
