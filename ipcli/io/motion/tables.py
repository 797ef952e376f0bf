"""Plain tables of joint positions: NPZ arrays, and CSV with a column a coordinate.

NPZ: `positions` (f, j, 3), `joints` (j,) names, `rate` Hz; optionally `parents` (j,) indices with -1 for none,
`rotations` (f, j, 3, 3) or quaternions (f, j, 4) x, y, z, w. CSV: a header `time,hips.x,hips.y,hips.z,...` with
seconds, or `frame,...`; an empty cell is a joint that was not seen. What hangs from what stands in skeleton.csv beside
it: joint,parent a line, no parent of a root.
"""

from __future__ import annotations

import csv
import re
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ipcli.errors import FormatError
from ipcli.geometry.skeleton import NO_PARENT, Skeleton
from ipcli.inputs import CUT, cut_number
from ipcli.io.files.text import read_text
from ipcli.io.motion.quaternions import matrices
from ipcli.measurements.motions import Motion, check_motion

SKELETON = "skeleton.csv"
UNEVEN = 0.02  # share of the frame time by which times may be off
USUAL_RATES = (
    10, 12, 12.5, 15, 20, 24, 25, 30, 48, 50, 60, 72, 75, 90, 100, 120, 150, 180, 200, 240, 250, 300, 360, 480, 500,
)  # fmt: skip
MOST_GAPS = 100  # frames for each line of a table with frame numbers
MOST_NOTES = 5
CLEAR = 10  # frames whose coarsely rounded times tell a clock
DELIMITERS = (",", ";", "\t")
DECIMAL = re.compile(r",(?=[0-9])")


def read_npz(path: Path, *, rate: float | None = None, unit: float | None = None) -> Motion:
    """The motion of an NPZ file. `unit` is metres a unit of length (default: metres), `rate` in Hz replaces its own.

    A joint at exactly 0 0 0 was not seen, as in `unseen`.
    """
    arrays = _arrays(path)
    for name in ("positions", "joints"):
        if name not in arrays:
            got = ", ".join(arrays) or "nothing"
            raise FormatError(path, f"no array '{name}'", expected="positions, joints, rate", got=got, fix="Add it")
    joints = tuple(map(str, np.atleast_1d(arrays["joints"]).ravel()))
    parents = _numeric(path, "parents", np.atleast_1d(arrays.get("parents", np.full(len(joints), NO_PARENT))).ravel())
    if not (np.isfinite(parents) & (np.abs(parents) < len(parents) + 2)).all():
        raise FormatError(path, "parents that are no joints", expected="-1 or the index of a joint", fix="Correct them")
    positions = _numeric(path, "positions", arrays["positions"])
    if positions.ndim != 3 or positions.shape[1:] != (len(joints), 3):
        expected = f"(frames, {len(joints)}, 3)"
        raise FormatError(path, "positions have the wrong shape", expected=expected, got=positions.shape, fix="Turn it")
    stated = rate if rate is not None else _single(path, arrays)
    skeleton = Skeleton(joints, tuple(map(int, parents)))
    rotations = _rotations(path, arrays, (*positions.shape[:2], 3, 3))
    positions, notes = unseen(positions, skeleton)
    return check_motion(Motion(skeleton, positions * (1.0 if unit is None else unit), stated, rotations, notes), path)


def _single(path: Path, arrays: dict[str, np.ndarray]) -> float:
    """The rate that the file states; NaN if it states none."""
    rate = _numeric(path, "rate", np.asarray(arrays.get("rate", np.nan)))
    if rate.size != 1:
        raise FormatError(path, "rate is not one number", got=f"{rate.size} numbers", fix="Save frames a second")
    return float(rate.ravel()[0])


def read_csv(path: Path, *, rate: float | None = None, unit: float | None = None) -> Motion:
    """The motion of a CSV file. `unit` is metres a unit of length (default: metres); `rate` in Hz where there are no
    times.

    Cells are parted by commas, semicolons (numbers may have decimal commas then) or tabs. Frame numbers that are left
    out become frames of NaN; a joint at exactly 0 0 0 was not seen, as in `unseen`.
    """
    text = read_text(path)
    rows = table_rows(path, text)
    header = [cell.strip() for cell in rows[0]] if rows else []
    first = header[0].lower() if header else ""
    timed = first in ("time", "frame")
    columns = [_lower_axis(name) for name in (header[1:] if timed else header)]
    joints = tuple(dict.fromkeys(name.rpartition(".")[0] for name in columns))
    if not joints or [f"{joint}.{axis}" for joint in joints for axis in "xyz"] != columns:
        expected = "time,NAME.x,NAME.y,NAME.z,..."
        got = ",".join(header[:4])[:80]
        raise FormatError(path, "line 1: not the header of a motion", expected=expected, got=got, fix="Add it")
    lines = [(line, row) for line, row in enumerate(rows[1:], start=2) if any(cell.strip() for cell in row)]
    table = np.array([_row(path, line, row, len(header)) for line, row in lines]).reshape(-1, len(header))
    notes = (CUT,) if cut_number(text) else ()
    if first == "time" and rate is None:
        rate = even_rate(path, table[:, 0], [line for line, _ in lines])
    elif first == "frame":
        table = _numbered(path, table)
    positions = table[:, int(timed) :].reshape(len(table), len(joints), 3)
    skeleton = _skeleton(path.parent / SKELETON, joints)
    positions, zeros = unseen(positions, skeleton)
    scale = 1.0 if unit is None else unit
    return check_motion(Motion(skeleton, positions * scale, rate or np.nan, notes=(*notes, *zeros)), path)


def table_rows(path: Path, text: str) -> list[list[str]]:
    """The cells of a CSV text. They are parted by what the first line has most of: commas, semicolons or tabs.

    With semicolons or tabs, a comma between digits is a decimal point. Raises FormatError.
    """
    first = text.partition("\n")[0]
    delimiter = max(DELIMITERS, key=first.count)
    try:
        rows = list(csv.reader(text.splitlines(), delimiter=delimiter))
    except csv.Error as error:
        raise FormatError(path, f"not a table: {error}", fix="Check that it is a CSV file") from None
    return rows if delimiter == "," else [[DECIMAL.sub(".", cell) for cell in row] for row in rows]


def unseen(positions: np.ndarray, skeleton: Skeleton) -> tuple[np.ndarray, tuple[str, ...]]:
    """Positions (f, j, 3) with NaN for joints at exactly 0 0 0, which is how many programs write one that was not seen.

    A root that others hang from, and a joint that is there in all frames amid the others, is the origin that the body
    was moved to, and stays. What was done is said.
    """
    zero = (positions == 0).all(axis=-1)
    if not zero.any():
        return positions, ()
    others = np.where(zero[..., None], np.nan, positions)
    with np.errstate(invalid="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        amid = ((np.nanmin(others, axis=1) <= 0) & (np.nanmax(others, axis=1) >= 0)).all(axis=-1)
    holds = {parent for parent in skeleton.parents if parent != NO_PARENT and skeleton.parents[parent] == NO_PARENT}
    always = np.flatnonzero(zero.all(axis=0))
    for joint in {*always.tolist()} & holds or ({*always.tolist()} if len(always) == 1 and amid.mean() > 0.5 else ()):
        zero[:, joint] = False
    for joint in holds:
        zero[amid, joint] = False
    notes = tuple(
        f"'{skeleton.joints[joint]}' is at exactly 0 0 0 in {int(zero[:, joint].sum())} of {len(zero)} frames: not seen"
        for joint in np.flatnonzero(zero.any(axis=0))
    )
    if len(notes) > MOST_NOTES:
        what = f"{len(notes)} joints are at exactly 0 0 0 in some of the {len(zero)} frames: not seen there"
        notes = (what,)
    return np.where(zero[..., None], np.nan, positions), notes


def _lower_axis(column: str) -> str:
    name, dot, axis = column.rpartition(".")
    return f"{name}{dot}{axis.lower()}"


def _numbered(path: Path, table: np.ndarray) -> np.ndarray:
    """Rows in the places that their frame numbers give them, NaN in between; steps that are all alike are one frame."""
    steps = np.diff(table[:, 0])
    if not np.isfinite(table[:, 0]).all() or (steps <= 0).any():
        line = 3 + int(np.argmax(~(steps > 0)))
        what = f"line {line}: frame numbers do not grow"
        raise FormatError(path, what, got=f"{table[line - 2, 0]:g}", fix="Sort the lines, and give each frame once")
    step = steps.min() if len(steps) else 1.0
    at = (table[:, 0] - table[0, 0]) / step if len(table) else table[:, 0]
    if not np.allclose(at, np.round(at), atol=1e-6) or (len(at) and at[-1] > MOST_GAPS * len(at)):
        raise FormatError(path, "frame numbers with odd gaps", expected=f"steps of {step:g}", fix="Check the column")
    spread = np.full((int(round(at[-1])) + 1 if len(at) else 0, table.shape[1]), np.nan)
    spread[np.round(at).astype(np.int64)] = table
    return spread


def _arrays(path: Path) -> dict[str, np.ndarray]:
    try:
        with np.load(path, allow_pickle=False) as file:
            return {name: _plain(path, file, name) for name in file.files}
    except FileNotFoundError:
        raise FormatError(path, "no such file", fix="Check the path") from None
    except FormatError:
        raise
    except Exception as error:  # numpy and zipfile raise anything on a damaged file
        raise FormatError(
            path, f"not a readable NPZ file: {' '.join(str(error).split())}", fix="Check the copy"
        ) from None


def _plain(path: Path, file: Any, name: str) -> np.ndarray:
    try:
        array: np.ndarray = file[name]
    except ValueError as error:
        if "allow_pickle" not in str(error):
            raise
        fix = f"Save it as a plain array: {name}=np.array({name}, dtype={'str' if name == 'joints' else 'float'})"
        raise FormatError(path, f"{name} is an array of Python objects, which are never unpickled", fix=fix) from None
    return array


def _numeric(path: Path, name: str, array: np.ndarray) -> np.ndarray:
    if array.dtype.kind not in "iuf":
        raise FormatError(path, f"{name} holds no numbers", got=array.dtype, fix="Save numbers")
    return array.astype(np.float64)


def _rotations(path: Path, arrays: dict[str, np.ndarray], shape: tuple[int, ...]) -> np.ndarray | None:
    if "rotations" not in arrays:
        return None
    rotations = _numeric(path, "rotations", arrays["rotations"])
    return matrices(rotations) if rotations.shape == (*shape[:2], 4) else rotations


def _row(path: Path, line: int, row: Sequence[str], length: int) -> list[float]:
    if len(row) != length:
        raise FormatError(
            path, f"line {line}: {len(row)} cells", expected=length, fix="Leave cells of unseen joints empty"
        )
    try:
        return [float(cell) if cell.strip() else np.nan for cell in row]
    except ValueError as error:
        raise FormatError(
            path, f"line {line}: {error}", fix="Write numbers, or nothing where a joint is not seen"
        ) from None


def even_rate(path: Path, times: np.ndarray, lines: Sequence[int]) -> float | None:
    """Frames a second of evenly spaced times (f,) in seconds, of these lines of the file; None of a single one.

    Times that were rounded to so many decimal places are even if an even clock can give them; of the rates that can,
    a usual one is taken.
    """
    steps = np.diff(times)
    if not len(steps):
        return None
    step = float(np.median(steps))
    is_even = (np.abs(steps - step) <= UNEVEN * abs(step)) & (step > 0)
    rounded = _rounded_rate(times) if not is_even.all() or not _is_usual(1 / step) else None
    if rounded is not None or is_even.all():
        return round(1 / step, 6) if rounded is None else rounded
    off = np.where(np.isfinite(steps), np.abs(steps - step).round(9), np.inf)
    line = lines[int(np.argmax(off)) + 1]
    fix = "Resample it to even times, or give --source-rate; leave the cells of dropped frames empty"
    raise FormatError(path, f"line {line}: times are uneven", expected=f"steps of {step:g} s", fix=fix)


def _is_usual(rate: float) -> bool:
    return any(abs(rate / usual - 1) < 1e-3 for usual in USUAL_RATES)


def _rounded_rate(times: np.ndarray) -> float | None:
    """The rate of an even clock whose times, rounded as these are, are these; None if there is no such clock."""
    whole = float(times[-1] - times[0]) / (len(times) - 1)
    places = next((p for p in range(1, 7) if np.allclose(times, np.round(times, p), rtol=0, atol=1e-9)), None)
    if places is None or not whole > 2 * 10.0**-places or (places < 3 and len(times) < CLEAR):
        return None
    frames = np.arange(len(times))
    for rate in (*sorted(USUAL_RATES, key=lambda usual: abs(usual * whole - 1)), 1 / whole):
        late = times - frames / rate
        if float(late.max() - late.min()) <= 1.001 * 10.0**-places:
            return round(rate, 6)
    return None


def _skeleton(path: Path, joints: tuple[str, ...]) -> Skeleton:
    if not path.is_file():
        return Skeleton(joints, (NO_PARENT,) * len(joints))
    parent_of: dict[str, str] = {}
    for line, row in enumerate(table_rows(path, read_text(path)), start=1):
        cells = [cell.strip() for cell in row] + ["", ""]
        if cells[:2] == ["joint", "parent"] or not any(cells):
            continue
        for name in cells[:2]:
            if name and name not in joints:
                raise FormatError(
                    path, f"line {line}: no joint '{name}' in the tables beside it", fix="Correct the name"
                )
        parent_of[cells[0]] = cells[1]
    return Skeleton(
        joints, tuple(joints.index(parent_of[name]) if parent_of.get(name) else NO_PARENT for name in joints)
    )
