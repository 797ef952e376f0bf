"""The layout of OSIE (Xu et al. 2014): `fixations.mat` and a folder of pictures, `stimuli/`."""

from __future__ import annotations

import os
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ipcli.errors import FormatError
from ipcli.io.files import matlab
from ipcli.io.files.images import read_image
from ipcli.measurements.fixations import FixatedPicture, FixationSet

FILE, PICTURES = "fixations.mat", "stimuli"
MOST_BYTES = 1 << 28


def is_osie(path: Path) -> bool:
    """Whether the folder holds fixations.mat and stimuli/."""
    return (path / FILE).is_file() and (path / PICTURES).is_dir()


def open_osie(path: Path) -> FixationSet:
    """The set, pictures read when asked for; of pictures that are not there, if not all, a note is made. Points in the
    file count from 1. Raises FormatError.
    """
    file = path / FILE
    records = _records(file)
    pictures, missing = [], []
    for number, record in enumerate(records):
        name, points, observers = _picture(file, record, number)
        picture = path / PICTURES / name
        if os.path.isfile(picture):  # no error, as Path's has, for a name that no file can have
            pictures.append(FixatedPicture(Path(name).stem, partial(read_image, picture), points, observers))
        else:
            missing.append(picture)
    if not pictures:
        raise FormatError(missing[0], f"no such picture, nor any other that {FILE} names", fix="Add them")
    note = f"{len(missing)} of {len(records)} pictures that {FILE} names are not there, and left out"
    return FixationSet(tuple(pictures), notes=(f"{note}: {missing[0].name}, ...",) if missing else ())


def _records(file: Path) -> np.ndarray:
    if file.stat().st_size > MOST_BYTES:
        raise FormatError(file, "too large", expected=f"at most {MOST_BYTES} bytes")
    records = matlab.read(file).get("fixations")
    if records is None or records.dtype != object or not records.size:
        raise FormatError(file, "holds no cells 'fixations'")
    return np.asarray(records).ravel()


def _picture(file: Path, record: Any, number: int) -> tuple[str, np.ndarray, np.ndarray]:
    """Name, points (n, 2) from 0, observers (n,)."""
    try:
        name = str(record["img"][0, 0][0])
        subjects = [cell[0, 0] for cell in record["subjects"][0, 0].ravel()]
        each = [np.stack([np.ravel(s["fix_x"]), np.ravel(s["fix_y"])], axis=1).astype(np.float64) for s in subjects]
    except (IndexError, KeyError, ValueError, TypeError, AttributeError) as error:
        raise FormatError(file, f"record {number + 1} is not as OSIE has them", expected="img, subjects") from error
    if Path(name).name != name or not name:
        raise FormatError(file, f"record {number + 1} names no picture", got=repr(name))
    points = np.concatenate([np.zeros((0, 2)), *each]) - 1.0
    if not np.isfinite(points).all():
        raise FormatError(file, f"{name}: fixations that are not finite")
    return name, points, np.repeat(np.arange(len(each)), [len(part) for part in each])
