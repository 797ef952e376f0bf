"""The size that an image file declares, told from its first bytes without decoding it: PNG, JPEG and TIFF."""

from __future__ import annotations

import struct

JPEG_FRAMES = {*range(0xC0, 0xD0)} - {0xC4, 0xC8, 0xCC}  # markers of a frame, which tells the size
TIFF_WIDTH, TIFF_HEIGHT = 256, 257


def declared_size(data: bytes) -> tuple[int, int] | None:
    """(width, height) of the bytes of an image file, None of one whose header is not understood."""
    try:
        if data.startswith(b"\x89PNG"):
            width, height = struct.unpack_from(">II", data, 16)
            return width, height
        if data.startswith(b"\xff\xd8"):
            return _jpeg(data)
        if data[:4] in (b"II*\0", b"MM\0*"):
            return _tiff(data, "<" if data.startswith(b"II") else ">")
    except (struct.error, IndexError, KeyError):
        pass
    return None


def _jpeg(data: bytes) -> tuple[int, int] | None:
    at = 2
    while data[at] == 0xFF:
        marker, length = data[at + 1], struct.unpack_from(">H", data, at + 2)[0]
        if marker in JPEG_FRAMES:
            height, width = struct.unpack_from(">HH", data, at + 5)
            return width, height
        at += 2 + length
    return None


def _tiff(data: bytes, order: str) -> tuple[int, int]:
    start = struct.unpack_from(f"{order}I", data, 4)[0]
    found = {}
    for entry in range(struct.unpack_from(f"{order}H", data, start)[0]):
        at = start + 2 + 12 * entry
        tag, kind = struct.unpack_from(f"{order}HH", data, at)
        found[tag] = struct.unpack_from(order + ("H" if kind == 3 else "I"), data, at + 8)[0]
    return found[TIFF_WIDTH], found[TIFF_HEIGHT]
