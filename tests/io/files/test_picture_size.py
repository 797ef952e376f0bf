"""The size that a header tells is that of the picture, in every format and byte order; damage tells nothing."""

import cv2
import numpy as np
import pytest
from PIL import Image

from ipcli.io.files.picture_size import declared_size


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".tif"])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_the_size_is_that_of_the_picture(suffix, dtype):
    if suffix == ".jpg" and dtype == np.uint16:
        pytest.skip("JPEG has 8 bits")
    done, data = cv2.imencode(suffix, np.zeros((21, 34), dtype))
    assert done
    assert declared_size(data.tobytes()) == (34, 21)


def test_a_jpeg_with_a_comment_and_progressive_is_understood(tmp_path):
    Image.new("RGB", (50, 20)).save(tmp_path / "a.jpg", progressive=True, comment=b"x" * 300)
    assert declared_size((tmp_path / "a.jpg").read_bytes()) == (50, 20)


def test_a_tiff_of_the_other_byte_order_is_understood():
    entries = b"".join(
        tag.to_bytes(2) + (3).to_bytes(2) + (1).to_bytes(4) + value.to_bytes(2) + b"\0\0"
        for tag, value in ((256, 700), (257, 300))
    )
    assert declared_size(b"MM\0*" + (8).to_bytes(4) + (2).to_bytes(2) + entries) == (700, 300)


@pytest.mark.parametrize(
    "data", [b"", b"GIF89a", b"\x89PNG", b"\xff\xd8\xff", b"II*\0\xff\xff\xff\xff", b"MM\0*\0\0\0\x08\0\0"]
)
def test_what_is_not_understood_tells_nothing(data):
    assert declared_size(data) is None
