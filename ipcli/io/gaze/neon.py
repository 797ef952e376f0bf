"""A recording of Pupil Neon as its phone stores it: `gaze ps1.raw`, `.time` and so on, one pair a part."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ipcli.errors import FormatError
from ipcli.measurements.names import natural
from ipcli.measurements.recording import Gaze

BLINK = np.dtype([("type", "<i4"), ("start", "<i8"), ("end", "<i8")])
NANOSECONDS = 1e-9
LARGEST = 1 << 30  # bytes of a file: a day of gaze is a seventh of it
WORN = 128  # of 255


def is_neon(folder: Path) -> bool:
    """Whether the folder is such a recording."""
    return any(folder.glob("gaze ps*.raw"))


def read_neon(folder: Path) -> Gaze:
    """Gaze in pixels of the distorted scene picture; not worn and blinks are invalid. Times are UTC seconds."""
    parts = sorted(folder.glob("gaze ps*.raw"), key=lambda path: natural(path.name))
    found = [_part(path) for path in parts]
    times, pixels, worn = (np.concatenate(columns) for columns in zip(*found, strict=True))
    blinks = [_values(path, BLINK) for path in sorted(folder.glob("blinks ps*.raw"))]
    blinking = np.zeros(len(times), bool)
    for blink in np.concatenate(blinks) if blinks else ():
        blinking |= (times >= blink["start"]) & (times <= blink["end"])
    valid = worn & ~blinking & np.isfinite(pixels).all(axis=1)
    return Gaze(times * NANOSECONDS, pixels.astype(np.float64), valid, source="Pupil Neon")


def _part(path: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nanoseconds (n,), pixels (n, 2), whether worn (n,)."""
    pixels = _values(path, np.dtype(("<f4", 2)))
    times = _values(path.with_suffix(".time"), np.dtype("<i8"))
    beside = path.with_name(path.name.replace("gaze", "worn", 1))
    worn = _values(beside, np.dtype("u1")) >= WORN if beside.is_file() else np.ones(len(times), bool)
    if not len(pixels) == len(times) == len(worn):
        got = f"{len(pixels)}, {len(times)} times, {len(worn)} of worn"
        raise FormatError(path, "gaze, times and worn differ in number", expected="as many of each", got=got)
    return times, pixels, worn


def _values(path: Path, kind: np.dtype) -> np.ndarray:
    try:
        size = path.stat().st_size
        if size > LARGEST or size % kind.itemsize:
            raise FormatError(path, "cut or too long", expected=f"items of {kind.itemsize} bytes", got=f"{size} bytes")
        return np.frombuffer(path.read_bytes(), kind)
    except OSError as error:
        raise FormatError(path, f"cannot be read: {error.strerror}", fix="Copy the recording again") from None
