"""Plain tables of joint positions: NPZ arrays, and CSV with a column a coordinate.

NPZ: `positions` (f, j, 3), `joints` (j,) names, `rate` Hz; optionally `parents` (j,) indices with -1 for none,
`rotations` (f, j, 3, 3) or quaternions (f, j, 4) x, y, z, w. CSV: a header `time,hips.x,hips.y,hips.z,...` with
seconds, or `frame,...`; an empty cell is a joint that was not seen. What hangs from what stands in skeleton.csv beside
it: joint,parent a line, no parent of a root.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ipcli.errors import FormatError
from ipcli.geometry.skeleton import NO_PARENT, Skeleton
from ipcli.io.files.text import read_text
from ipcli.io.motion.quaternions import matrices
from ipcli.measurements.motions import Motion, check_motion

SKELETON = "skeleton.csv"
UNEVEN = 0.02  # share of the frame time by which times may be off


def read_npz(path: Path, *, rate: float | None = None, unit: float | None = None) -> Motion:
    """The motion of an NPZ file. `unit` is metres a unit of length (default: metres), `rate` in Hz replaces its own."""
    arrays = _arrays(path)
    for name in ("positions", "joints"):
        if name not in arrays:
            got = ", ".join(arrays) or "nothing"
            raise FormatError(path, f"no array '{name}'", expected="positions, joints, rate", got=got, fix="Add it")
    joints = tuple(map(str, np.atleast_1d(arrays["joints"])))
    parents = arrays.get("parents", np.full(len(joints), NO_PARENT))
    positions = _numeric(path, "positions", arrays["positions"])
    stated = rate if rate is not None else float(arrays.get("rate", np.nan))
    skeleton = Skeleton(joints, tuple(map(int, _numeric(path, "parents", np.atleast_1d(parents)))))
    rotations = _rotations(path, arrays, (*positions.shape[:2], 3, 3))
    return check_motion(Motion(skeleton, positions * (1.0 if unit is None else unit), stated, rotations), path)


def read_csv(path: Path, *, rate: float | None = None, unit: float | None = None) -> Motion:
    """The motion of a CSV file. `unit` is metres a unit of length (default: metres); `rate` in Hz where there are no
    times.
    """
    rows = list(csv.reader(read_text(path).splitlines()))
    header = [cell.strip() for cell in rows[0]] if rows else []
    timed = header[:1] in (["time"], ["frame"])
    columns = header[1:] if timed else header
    joints = tuple(dict.fromkeys(name.rpartition(".")[0] for name in columns))
    if not joints or [f"{joint}.{axis}" for joint in joints for axis in "xyz"] != columns:
        expected = "time,NAME.x,NAME.y,NAME.z,..."
        raise FormatError(
            path, "line 1: not the header of a motion", expected=expected, got=",".join(header[:4]), fix="Add it"
        )
    table = np.array([_row(path, line, row, len(header)) for line, row in enumerate(rows[1:], start=2) if row]).reshape(
        -1, len(header)
    )
    if header[0] == "time" and rate is None:
        rate = _rate(path, table[:, 0])
    positions = table[:, int(timed) :].reshape(len(table), len(joints), 3) * (1.0 if unit is None else unit)
    return check_motion(Motion(_skeleton(path.parent / SKELETON, joints), positions, rate or np.nan), path)


def _arrays(path: Path) -> dict[str, np.ndarray]:
    try:
        with np.load(path, allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    except FileNotFoundError:
        raise FormatError(path, "no such file", fix="Check the path") from None
    except Exception as error:  # numpy and zipfile raise anything on a damaged file
        raise FormatError(
            path, f"not a readable NPZ file: {' '.join(str(error).split())}", fix="Check the copy"
        ) from None


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


def _rate(path: Path, times: np.ndarray) -> float | None:
    """Frames a second of evenly spaced times; None of a single one."""
    steps = np.diff(times)
    if not len(steps):
        return None
    step = float(np.median(steps))
    if not (np.abs(steps - step) <= UNEVEN * abs(step)).all() or step <= 0:
        line = int(np.argmax(~(np.abs(steps - step) <= UNEVEN * abs(step)))) + 3
        fix = "Resample it to even times; leave the cells of dropped frames empty"
        raise FormatError(path, f"line {line}: times are uneven", expected=f"steps of {step:g} s", fix=fix)
    return round(1 / step, 6)


def _skeleton(path: Path, joints: tuple[str, ...]) -> Skeleton:
    if not path.is_file():
        return Skeleton(joints, (NO_PARENT,) * len(joints))
    parent_of: dict[str, str] = {}
    for line, row in enumerate(csv.reader(read_text(path).splitlines()), start=1):
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
