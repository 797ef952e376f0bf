"""Depth of OpenEXR files, which OpenCV's wheels no longer read: one part, in scan lines, not or zip-compressed."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np

from ipcli.errors import FormatError

MAGIC = b"v/1\x01"
LINES = {0: 1, 2: 1, 3: 16}  # of a block, by compression: none, ZIPS, ZIP
TYPES: dict[int, np.dtype] = {0: np.dtype("<u4"), 1: np.dtype("<f2"), 2: np.dtype("<f4")}
NEEDED = ("channels", "compression", "dataWindow")  # of the header
DEPTH_CHANNELS = ("Z", "depth.Z", "Y", "V", "R")  # the first of these that is there holds the depth
FIX = "Save it uncompressed or as ZIP in scan lines, or as PFM or NPY"


def decode(path: Path, data: bytes) -> np.ndarray:
    """The depth channel (h, w) float32 of the bytes of an EXR file; FormatError for another kind of EXR."""
    if data[:4] != MAGIC:
        raise FormatError(path, "empty file" if not data else "not an OpenEXR file", fix="Copy it again")
    if len(data) < 8 or data[5] & 0x1A:
        raise FormatError(path, "an OpenEXR file of tiles, deep pixels or many parts", fix=FIX)
    try:
        attributes, start = _header(data)
        return _pixels(path, data, attributes, start)
    except (struct.error, KeyError, ValueError, IndexError, zlib.error, UnicodeDecodeError) as error:
        raise FormatError(path, f"damaged OpenEXR file: {error}", fix="Copy it again") from None


def _header(data: bytes) -> tuple[dict[str, bytes], int]:
    attributes, at = {}, 8
    while data[at] != 0:
        name_end = data.index(b"\0", at)
        type_end = data.index(b"\0", name_end + 1)
        size = struct.unpack_from("<i", data, type_end + 1)[0]
        if size < 0:
            raise ValueError("an attribute of negative size")
        attributes[data[at:name_end].decode("ascii")] = data[type_end + 5 : type_end + 5 + size]
        at = type_end + 5 + size
    return attributes, at + 1


def _channels(content: bytes) -> dict[str, np.dtype]:
    channels: dict[str, np.dtype] = {}
    at = 0
    while content[at] != 0:
        end = content.index(b"\0", at)
        kind, _, across, down = struct.unpack_from("<iiii", content, end + 1)
        if (across, down) != (1, 1):
            raise ValueError("a channel of reduced size")
        channels[content[at:end].decode("ascii")] = TYPES[kind]
        at = end + 17
    if not channels:
        raise ValueError("no channels")
    return channels


def _pixels(path: Path, data: bytes, attributes: dict[str, bytes], start: int) -> np.ndarray:
    if missing := [name for name in NEEDED if name not in attributes]:
        raise ValueError(f"no {', '.join(missing)} in its header")
    channels, compression = _channels(attributes["channels"]), attributes["compression"][0]
    if compression not in LINES:
        raise FormatError(path, "an OpenEXR file of a compression that is not read", expected="none or ZIP", fix=FIX)
    wanted = next(name for name in (*DEPTH_CHANNELS, *channels) if name in channels)
    left, top, right, bottom = struct.unpack("<iiii", attributes["dataWindow"])
    width, height = right - left + 1, bottom - top + 1
    bytes_of_line = sum(kind.itemsize for kind in channels.values()) * width
    if width < 1 or height < 1 or bytes_of_line * height > 2000 * len(data):  # zip cannot do better
        raise ValueError(f"{width} x {height} pixels in {len(data)} bytes")
    before = sum(kind.itemsize for name, kind in channels.items() if name < wanted) * width
    image = np.empty((height, width), np.float32)
    left_out = np.ones(height, bool)
    blocks = -(-height // LINES[compression])
    for offset in struct.unpack_from(f"<{blocks}Q", data, start):
        if offset > len(data):
            raise ValueError("a block beyond the end")
        row, size = struct.unpack_from("<ii", data, offset)
        first = row - top
        count = min(LINES[compression], height - first)
        if not 0 <= first < height or not 0 <= size <= len(data) - offset - 8:
            raise ValueError(f"a block at line {first}")
        packed = data[offset + 8 : offset + 8 + size]
        block = packed if size == count * bytes_of_line else _unzipped(packed, count * bytes_of_line)
        for line in range(count):
            at = line * bytes_of_line + before
            image[first + line] = np.frombuffer(block, channels[wanted], width, at)
        left_out[first : first + count] = False
    if left_out.any():
        raise ValueError(f"{int(left_out.sum())} lines in no block")
    return image


def _unzipped(packed: bytes, size: int) -> bytes:
    """Undo zip, the differences of neighbours, and the halves that were put apart."""
    stream = zlib.decompressobj()
    halves = np.frombuffer(stream.decompress(packed, size), np.uint8)
    if halves.size != size:
        raise ValueError("a cut block")
    steps = halves.astype(np.int64)
    steps[1:] -= 128
    summed = np.cumsum(steps).astype(np.uint8)
    out = np.empty(size, np.uint8)
    out[::2], out[1::2] = summed[: (size + 1) // 2], summed[(size + 1) // 2 :]
    return out.tobytes()
