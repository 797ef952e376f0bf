from __future__ import annotations

import numpy as np
import pytest

from ipcli.errors import FormatError
from ipcli.io.files import exr
from ipcli.io.files.images import read_depth
from tests.fixtures.exr_files import attribute, written

DEPTH = np.random.default_rng(0).uniform(1, 9, (37, 5)).astype(np.float32)


@pytest.mark.parametrize("compression", exr.LINES)
@pytest.mark.parametrize("half", [False, True])
def test_the_depth_channel_is_read_exactly(tmp_path, compression, half):
    smooth = np.round(DEPTH) if compression else DEPTH  # so that zip makes it smaller
    (tmp_path / "d.exr").write_bytes(written(smooth, compression, half, others=("A", "R")))
    found = read_depth(tmp_path / "d.exr")
    np.testing.assert_array_equal(found, smooth.astype(np.float16) if half else smooth)


def test_what_is_not_read_is_named(tmp_path):
    whole = written(DEPTH, 0)
    tiled = whole[:5] + b"\x02" + whole[6:]
    piz = whole.replace(attribute("compression", "compression", b"\0"), attribute("compression", "compression", b"\4"))
    cases = {"empty file": b"", "not an OpenEXR file": b"x" * 99, "of tiles": tiled, "compression that is not": piz}
    for message, content in cases.items():
        with pytest.raises(FormatError, match=f"d.exr: .*{message}|d.exr: {message}"):
            exr.decode(tmp_path / "d.exr", content)


@pytest.mark.parametrize("compression", exr.LINES)
def test_a_cut_file_is_refused(tmp_path, compression):
    content = written(np.round(DEPTH), compression)
    for length in [*range(4, len(content) - 1, 23), len(content) - 1]:
        with pytest.raises(FormatError):
            exr.decode(tmp_path / "d.exr", content[:length])


def test_blocks_that_are_not_there_or_twice_there_are_refused(tmp_path):
    whole = written(DEPTH, 0)
    table = len(whole) - 37 * (8 + 4 * 5) - 8 * 37  # one offset a line, then the lines
    first, second = whole[table : table + 8], whole[table + 8 : table + 16]
    for offset, words in ((b"\xff" * 8, "beyond the end"), (first, "1 lines in no block")):
        (tmp_path / "a.exr").write_bytes(whole[: table + 8] + offset + whole[table + 16 :])
        assert offset != second
        with pytest.raises(FormatError, match=words):
            read_depth(tmp_path / "a.exr")


def test_a_file_of_no_channels_is_refused(tmp_path):
    whole = written(DEPTH, 0)
    content = whole[whole.index(b"chlist") + 11 :]
    none = whole.replace(content[:19], b"\0" + content[1:19], 1)
    (tmp_path / "a.exr").write_bytes(none)
    with pytest.raises(FormatError, match="no channels"):
        read_depth(tmp_path / "a.exr")


def test_a_header_of_zeros_is_said_to_lack_all():
    with pytest.raises(FormatError, match="no channels, compression, dataWindow in its header"):
        exr.decode("d.exr", b"v/1\x01" + bytes(100))
