"""Models of COLMAP: their counts are checked, and then pycolmap reads them in a child process.

    plain = parsed(parse, folder, "Run `colmap image_undistorter` again")

pycolmap loops or eats memory where a count inside a file is damaged. Its objects die with the model, so `parse`, which
runs in the child, turns them into plain arrays.
"""

from __future__ import annotations

from collections.abc import Callable
from mmap import ACCESS_READ, mmap
from pathlib import Path
from typing import Any

from ipcli.errors import FormatError
from ipcli.io.files.guarded import MEMORY, SECONDS, ParserFailed, guarded

LEAST_BYTES = {"cameras": 24, "images": 65, "rigs": 8, "frames": 8, "points3D": 43}  # of an item of each binary file


def parsed(parse: Callable[[str], Any], folder: Path, fix: str) -> Any:
    """What `parse` makes of the model in a folder, text or binary; FormatError, which advises `fix`, when it is none or
    is cut.
    """
    check_counts(folder, fix)
    weight = sum(path.stat().st_size for path in folder.iterdir() if path.is_file())
    try:
        return guarded(parse, str(folder), seconds=SECONDS + weight / 1e7, memory=MEMORY + 20 * weight)
    except ParserFailed as error:
        words = f"model cannot be read: {' '.join(str(error).split())[:120]}"
        raise FormatError(folder, words, expected="cameras, images and points3D as .bin or .txt", fix=fix) from None


def check_counts(folder: Path, fix: str) -> None:
    """FormatError for a binary model file too short for its own counts: pycolmap would read on without end."""
    for stem, least in LEAST_BYTES.items():
        path = folder / f"{stem}.bin"
        if path.is_file():
            size = path.stat().st_size
            with path.open("rb") as stream:
                count = int.from_bytes(stream.read(8), "little")
            if size < 8 or count * least > size - 8 or (stem in ENDS and _end(path, count, ENDS[stem]) != size):
                got = f"{size} bytes for {count} items"
                raise FormatError(path, "cut or empty", expected=f"{least} bytes an item or more", got=got, fix=fix)


def _end(path: Path, count: int, item_end: Callable[[mmap, int], int]) -> int:
    """Where `count` items end that tell their own lengths, or beyond the file."""
    with path.open("rb") as stream, mmap(stream.fileno(), 0, access=ACCESS_READ) as data:
        place = 8
        for _ in range(count):
            if place >= len(data):
                return len(data) + 1
            place = item_end(data, place)
        return place


def _image_end(data: mmap, start: int) -> int:
    """Behind number, pose, camera, a name up to a zero, and a counted list of points of 24 bytes."""
    name_end = data.find(b"\0", start + 64)
    return name_end + 9 + 24 * _whole(data, name_end + 1, 8) if name_end >= 0 else len(data) + 1


def _frame_end(data: mmap, start: int) -> int:
    """Behind number, rig, pose, and a counted list of pictures of 16 bytes."""
    return start + 68 + 16 * _whole(data, start + 64, 4)


def _whole(data: mmap, start: int, size: int) -> int:
    return int.from_bytes(data[start : start + size], "little")


ENDS = {"images": _image_end, "frames": _frame_end}
