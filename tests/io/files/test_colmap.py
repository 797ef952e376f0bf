"""COLMAP models that are cut are refused before pycolmap sees them."""

import pytest

from ipcli.errors import FormatError
from ipcli.io.files.colmap import parsed
from ipcli.io.views.colmap import model_cameras


@pytest.mark.parametrize("content", [b"", (3).to_bytes(8, "little") + bytes(20)])
def test_fewer_bytes_than_the_count_says(tmp_path, content):
    (tmp_path / "images.bin").write_bytes(content)
    with pytest.raises(FormatError, match="cut or empty") as caught:
        parsed(model_cameras, tmp_path, "Do it again")
    assert "Do it again" in str(caught.value)


def test_a_folder_without_a_model(tmp_path):
    pytest.importorskip("pycolmap")
    with pytest.raises(FormatError, match="cannot be read"):
        parsed(model_cameras, tmp_path, "Give another")
