from __future__ import annotations

import struct
import zlib

import numpy as np
import pytest

from ipcli.errors import FormatError
from ipcli.io.files import exr
from ipcli.io.files.images import read_depth

DEPTH = np.random.default_rng(0).uniform(1, 9, (37, 5)).astype(np.float32)


def attribute(name: str, kind: str, content: bytes) -> bytes:
    return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(content)) + content


def packed(block: bytes) -> bytes:
    """Zip as OpenEXR does: even bytes before odd ones, differences, deflate."""
    halves = np.frombuffer(block, np.uint8)
    apart = np.concatenate([halves[::2], halves[1::2]]).astype(np.int64)
    apart[1:] = np.diff(apart) + 128
    return zlib.compress(apart.astype(np.uint8).tobytes())


def written(depth: np.ndarray, compression: int, half: bool = False, others: tuple[str, ...] = ()) -> bytes:
    height, width = depth.shape
    kind = np.dtype("<f2" if half else "<f4")
    names = sorted([*others, "Z"])
    channels = b"".join(n.encode() + b"\0" + struct.pack("<iiii", 1 if half else 2, 0, 1, 1) for n in names) + b"\0"
    box = struct.pack("<iiii", 0, 3, width - 1, height + 2)  # the window need not begin at 0
    header = b"v/1\x01" + struct.pack("<i", 2) + attribute("channels", "chlist", channels)
    header += attribute("compression", "compression", bytes([compression])) + attribute("dataWindow", "box2i", box)
    header += b"\0"
    blocks = []
    for row in range(0, height, exr.LINES[compression]):
        lines = [
            (depth[r] if name == "Z" else -depth[r]).astype(kind).tobytes()
            for r in range(row, min(row + exr.LINES[compression], height))
            for name in names
        ]
        block = b"".join(lines)
        squeezed = packed(block) if compression else block
        content = squeezed if len(squeezed) < len(block) else block
        blocks.append(struct.pack("<ii", row + 3, len(content)) + content)
    sizes = np.cumsum([0, *map(len, blocks)])[:-1] + len(header) + 8 * len(blocks)
    return header + struct.pack(f"<{len(blocks)}Q", *sizes) + b"".join(blocks)


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


def test_a_header_of_zeros_is_said_to_lack_all():
    with pytest.raises(FormatError, match="no channels, compression, dataWindow in its header"):
        exr.decode("d.exr", b"v/1\x01" + bytes(100))
