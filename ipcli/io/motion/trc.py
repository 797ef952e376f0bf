"""TRC markers (Motion Analysis, OpenSim): a table with tabs; positions only, each marker a joint without a parent.

Line 2 names what line 3 gives (DataRate, NumFrames, NumMarkers, Units ...), line 4 names the markers, each over three
columns; lines of numbers begin with the number and the time of the frame. An empty cell is a marker that was not seen.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from ipcli.errors import FormatError
from ipcli.geometry.skeleton import NO_PARENT, Skeleton
from ipcli.inputs import CUT, cut_number
from ipcli.io.files.text import read_any_text
from ipcli.io.motion.names import numbered
from ipcli.io.motion.tables import unseen
from ipcli.measurements.motions import Motion, check_motion

UNITS = {"m": 1.0, "dm": 0.1, "cm": 0.01, "mm": 0.001, "in": 0.0254, "inches": 0.0254, "ft": 0.3048, "meters": 1.0}
DAMAGED = "Check that the copy is complete, or fix the line"


def read(path: Path, *, rate: float | None = None, unit: float | None = None) -> Motion:
    """The markers of a TRC file. `unit` is metres a unit of length (default: as Units says), `rate` in Hz replaces
    DataRate.

    Raises FormatError where the head and the table contradict each other.
    """
    text = read_any_text(path)
    lines = re.split(r"\r\n|\r|\n", text)
    head, names = _head(path, lines)
    rows = [(n, line) for n, line in enumerate(lines[5:], start=6) if line.strip()]
    table = np.array([_row(path, n, line, len(names)) for n, line in rows]).reshape(len(rows), 2 + 3 * len(names))
    _check_count(path, head, len(table))
    if (np.diff(table[:, 0]) <= 0).any():
        n = rows[int(np.argmax(np.diff(table[:, 0]) <= 0)) + 1][0]
        raise FormatError(path, f"line {n}: frame numbers do not grow", fix="Sort the lines, and give each frame once")
    joints, twice = numbered(names)
    skeleton = Skeleton(joints, (NO_PARENT,) * len(joints))
    positions, zeros = unseen(table[:, 2:].reshape(len(table), len(joints), 3), skeleton)
    scale = _unit(path, head.get("units", "mm")) if unit is None else unit
    stated = rate or _rate(path, head)
    notes = (*twice, *zeros, *((CUT,) if cut_number(text) else ()))
    return check_motion(Motion(skeleton, positions * scale, stated, notes=notes), path)


def _head(path: Path, lines: list[str]) -> tuple[dict[str, str], list[str]]:
    if len(lines) < 6 or not lines[0].lower().startswith("pathfiletype"):
        what = "not a whole TRC file" if lines[0].lower().startswith("pathfiletype") else "not a TRC file"
        expected = "PathFileType, two lines of facts, names of markers, a table"
        raise FormatError(path, what, expected=expected, got=f"{len(lines)} lines", fix=DAMAGED)
    head = dict(zip((key.lower() for key in lines[1].split()), lines[2].split(), strict=False))
    cells = lines[3].split("\t")
    names = [cell.strip() for cell in cells[2:] if cell.strip()]
    if not names:
        raise FormatError(path, "line 4: no names of markers", expected="Frame#, Time, names, with tabs", fix=DAMAGED)
    stated = head.get("nummarkers", str(len(names)))
    if stated != str(len(names)):
        raise FormatError(path, "line 4: names of markers", expected=stated, got=len(names), fix=DAMAGED)
    return head, names


def _row(path: Path, line: int, text: str, markers: int) -> list[float]:
    cells = text.rstrip("\r\n").split("\t")
    wanted = 2 + 3 * markers
    cells = [cell.strip() for cell in cells]
    if len(cells) > wanted and not any(cells[wanted:]):
        cells = cells[:wanted]
    if len(cells) != wanted:
        raise FormatError(path, f"line {line}: cells", expected=wanted, got=len(cells), fix=DAMAGED)
    try:
        return [float(cell) if cell else np.nan for cell in cells]
    except ValueError as error:
        raise FormatError(path, f"line {line}: {error}", fix=DAMAGED) from None


def _check_count(path: Path, head: dict[str, str], frames: int) -> None:
    stated = head.get("numframes", str(frames))
    if stated != str(frames):
        raise FormatError(path, "frames in the table", expected=stated, got=frames, fix="Check that the copy is whole")


def _rate(path: Path, head: dict[str, str]) -> float:
    try:
        return float(head.get("datarate", head.get("camerarate", "nan")))
    except ValueError:
        raise FormatError(path, f"DataRate '{head.get('datarate')}'", expected="Hz", fix="Give --source-rate") from None


def _unit(path: Path, name: str) -> float:
    if name.lower() not in UNITS:
        raise FormatError(path, f"unknown unit '{name}'", expected=", ".join(UNITS), fix="Give the unit with --unit")
    return UNITS[name.lower()]
