"""A folder of pictures with `fixations.csv`: a line for each fixation, columns picture, x, y and, if known, observer.

`x` and `y` are pixels from the left top corner, counted from 0; `picture` is a file name, with suffix, beside the CSV.
"""

from __future__ import annotations

import csv
import os
from functools import partial
from pathlib import Path

import numpy as np

from ipcli.errors import FormatError
from ipcli.inputs import warn_if_cut
from ipcli.io.files.images import read_image
from ipcli.measurements.fixations import FixatedPicture, FixationSet

FILE = "fixations.csv"
NEEDED = ("picture", "x", "y")
MOST_BYTES = 1 << 28


def is_folder(path: Path) -> bool:
    """Whether the folder holds fixations.csv."""
    return (path / FILE).is_file()


def open_folder(path: Path) -> FixationSet:
    """The set, pictures in order of their names and read when asked for. Raises FormatError."""
    file = path / FILE
    points: dict[str, list[tuple[float, float]]] = {}
    observers: dict[str, list[str]] = {}
    for line, row in enumerate(_rows(file), 2):
        name = row["picture"]
        if not name or Path(name).name != name:
            raise FormatError(file, f"line {line}: not the name of a picture beside it", got=repr(name))
        points.setdefault(name, []).append(_point(file, line, row))
        observers.setdefault(name, []).append(row.get("observer") or "")
    if not points:
        raise FormatError(file, "holds no fixations")
    return FixationSet(tuple(_picture(path, name, points[name], observers[name]) for name in sorted(points)))


def _rows(file: Path) -> list[dict[str, str]]:
    try:
        if file.stat().st_size > MOST_BYTES:
            raise FormatError(file, "too large", expected=f"at most {MOST_BYTES} bytes")
        text = file.read_text(encoding="utf-8-sig")
        warn_if_cut(file, text)
        reader = csv.DictReader(text.splitlines())
        names = reader.fieldnames or ()
        if missing := [name for name in NEEDED if name not in names]:
            raise FormatError(file, f"no column '{missing[0]}'", expected=", ".join(NEEDED), got=", ".join(names))
        return list(reader)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise FormatError(file, f"not a readable table: {' '.join(str(error).split())}") from error


def _point(file: Path, line: int, row: dict[str, str]) -> tuple[float, float]:
    try:
        x, y = float(row["x"]), float(row["y"])
    except (TypeError, ValueError):
        raise FormatError(file, f"line {line}: x and y are no numbers", got=f"{row['x']}, {row['y']}") from None
    if not np.isfinite((x, y)).all():
        raise FormatError(file, f"line {line}: a fixation that is not finite")
    return x, y


def _picture(path: Path, name: str, points: list[tuple[float, float]], observers: list[str]) -> FixatedPicture:
    if not os.path.isfile(path / name):  # no error, as Path's has, for a name that no file can have
        raise FormatError(path / name, f"no such picture, which {FILE} names", fix="Add it")
    known = {observer: k for k, observer in enumerate(sorted(set(observers)))}
    whose = np.array([known[observer] for observer in observers], np.int64)
    return FixatedPicture(Path(name).stem, partial(read_image, path / name), np.array(points), whose)
