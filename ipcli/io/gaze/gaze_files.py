"""Gaze: Pupil Cloud, Neon's own files, Pupil Core, Tobii Glasses 2 and 3, Project Aria, glassesTools, and plain tables.

Every device has axes and clocks of its own; here all become seconds, pixels with the origin in the middle of the top
left pixel, and rays with x right, y down, z forward. A table is told by the names of its columns.
"""

from __future__ import annotations

import csv
import gzip
import io
import logging
import zlib
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from ipcli.errors import FormatError
from ipcli.inputs import json_of
from ipcli.io.files import text as layout
from ipcli.io.gaze.neon import is_neon, read_neon
from ipcli.measurements.recording import Gaze

LARGEST = 1 << 30  # bytes of an unpacked export
CONFIDENT = 0.6  # confidence below which Pupil's own software leaves a sample out
AXES = ("x [m]", "y [m]", "z [m]")  # of a place, in a table
Columns = Mapping[str, np.ndarray]
log = logging.getLogger(__name__)


def read_gaze(path: Path, size: tuple[int, int] | None = None) -> Gaze:
    """Gaze of any known export, a file or the folder that holds it. `size` (width, height) of the scene picture turns
    shares of it into pixels. FormatError for an unknown one, naming the columns that were found.
    """
    if is_neon(Path(path)):
        return _in_order(read_neon(Path(path)))
    path = _file(Path(path))
    if path.suffix == ".gz":
        return _in_order(_tobii(path, size))
    columns = columns_of(path)
    for needed, convert, name in TABLES:
        if all(column in columns for column in needed):
            gaze = _converted(path, convert, columns, size)
            return _in_order(replace(gaze, source=name))
    known = "; ".join(f"{name}: {', '.join(needed)}" for needed, _, name in TABLES)
    raise FormatError(
        path, "unknown gaze table", expected=known, got=", ".join(list(columns)[:12]),
        fix="Name the columns time [s], x [px], y [px]",
    )  # fmt: skip


def _converted(path: Path, convert: Callable[..., Gaze], columns: dict[str, np.ndarray], size) -> Gaze:
    """What a converter of TABLES makes of the columns; FormatError where text or nothing stands for numbers."""
    try:
        return convert(path, columns, size)
    except (TypeError, ValueError, KeyError) as error:
        texts = ", ".join(name for name, column in columns.items() if column.dtype.kind == "U") or "none"
        raise FormatError(
            path, f"a column of numbers is missing or holds text ({type(error).__name__})",
            expected="numbers", got=f"columns of text: {texts}", fix="Correct the cells",
        ) from error  # fmt: skip


def _file(path: Path) -> Path:
    """The export in a folder."""
    if not path.is_dir():
        return path
    wanted = ("gaze.csv", "gaze_positions.csv", "eyegaze.csv", "gazeData.tsv", "gazedata.gz", "livedata.json.gz")
    found = [match for name in wanted for match in sorted(path.rglob(name))]
    if not found:
        raise FormatError(path, "no gaze export in this folder", expected=", ".join(wanted))
    return found[0]


def columns_of(path: Path) -> dict[str, np.ndarray]:
    """Columns by name; numbers where they are numbers, NaN where empty. Nanoseconds keep all their digits."""
    text = layout.read_text(path)
    if not text.endswith("\n"):
        text = text[: text.rfind("\n") + 1]  # a last line without an end may be cut in its last number
        log.warning("%s: the last line has no end, so it may be cut: left out", path)
    lines = text.lstrip("\ufeff").splitlines()
    if len(lines) < 2:
        raise FormatError(
            path, "no gaze samples", expected="a line of names and one a sample", got=f"{len(lines)} lines"
        )
    comma = max(",\t;", key=lines[0].count)
    try:
        rows = [row for row in csv.reader(lines, delimiter=comma) if row]
    except csv.Error as error:
        raise FormatError(path, f"not a table: {error}") from None
    names = [name.strip().lstrip("#").strip() for name in rows[0]]
    bad = next((n for n, row in enumerate(rows[1:], start=2) if len(row) != len(names)), None)
    if bad:
        raise FormatError(path, f"line {bad} is cut or too long", expected=len(names), got=len(rows[bad - 1]))
    return {name: _numbers(path, name, [row[i] for row in rows[1:]]) for i, name in enumerate(names)}


def _numbers(path: Path, name: str, texts: list[str]) -> np.ndarray:
    if name.endswith("[ns]"):
        if not all(text.strip().isascii() and text.strip().isdecimal() and len(text) < 20 for text in texts):
            raise FormatError(path, f"column '{name}' holds something that is no time", expected="nanoseconds")
        return np.array([int(text) for text in texts], np.int64)
    try:
        return np.array([float(text) if text.strip() else np.nan for text in texts])
    except ValueError:
        lowered = [text.strip().lower() for text in texts]
        if set(lowered) <= {"true", "false", ""}:
            return np.array([float(text == "true") for text in lowered])
        return np.array(texts)


def _gaze(times, pixels, valid, directions=None, origins=None, labels=None) -> Gaze:
    known = np.isfinite(pixels).all(axis=1) | (np.isfinite(directions).all(axis=1) if directions is not None else False)
    return Gaze(np.asarray(times, np.float64), pixels, np.asarray(valid, bool) & known, directions, origins, labels)


def _cloud(path: Path, c: Columns, size) -> Gaze:
    """Pupil Cloud: pixels of the distorted scene video, UTC nanoseconds; elevation is up."""
    pixels = np.stack([c["gaze x [px]"], c["gaze y [px]"]], axis=1).astype(np.float64)
    worn = np.nan_to_num(c["worn"], nan=1.0) > 0.5 if "worn" in c else np.ones(len(pixels), bool)
    blink = (
        np.isfinite(c["blink id"])
        if "blink id" in c and c["blink id"].dtype.kind == "f"
        else np.zeros(len(pixels), bool)
    )
    return _gaze(c["timestamp [ns]"] * 1e-9, pixels, worn & ~blink)


def _pupil(path: Path, c: Columns, size) -> Gaze:
    """Pupil Core: shares of the picture from its bottom left corner."""
    width, height = _size(path, size)
    pixels = np.stack([c["norm_pos_x"] * width - 0.5, (1 - c["norm_pos_y"]) * height - 0.5], axis=1)
    return _gaze(c["gaze_timestamp"], pixels, c["confidence"] >= CONFIDENT)


def _glasses(path: Path, c: Columns, size) -> Gaze:
    """mobileGazeMapping: milliseconds, shares of the picture from its top left corner."""
    width, height = _size(path, size)
    pixels = np.stack([c["norm_pos_x"] * width - 0.5, c["norm_pos_y"] * height - 0.5], axis=1)
    return _gaze(c["timestamp"] * 1e-3, pixels, c.get("confidence", np.ones(len(pixels))) >= CONFIDENT)


def _tools(path: Path, c: Columns, size) -> Gaze:
    """glassesTools: milliseconds, pixels."""
    pixels = np.stack([c["gaze_pos_vid_x"], c["gaze_pos_vid_y"]], axis=1)
    return _gaze(c["timestamp"] * 1e-3, pixels, np.ones(len(pixels), bool))


def _aria(path: Path, c: Columns, size) -> Gaze:
    """Project Aria: microseconds, angles of the central pupil frame (x left, y up); the two eyes' yaws are averaged in
    their tangents.
    """
    time = "tracking_timestamp_us" if "tracking_timestamp_us" in c else "t_us"
    yaw_name = next((n for n in ("yaw_rads_cpf", "yaw_rad") if n in c), None)
    pitch = np.tan(c["pitch_rads_cpf" if "pitch_rads_cpf" in c else "pitch_rad"])
    yaws = [yaw_name] if yaw_name else ["left_yaw_rads_cpf", "right_yaw_rads_cpf"]
    across = np.mean([np.tan(c[name]) for name in yaws], axis=0)
    rays = np.stack([-across, -pitch, np.ones_like(pitch)], axis=1)
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    return _gaze(c[time] * 1e-6, np.full((len(rays), 2), np.nan), np.isfinite(rays).all(axis=1), rays)


def _plain(path: Path, c: Columns, size) -> Gaze:
    """time [s], x [px], y [px]; optional confidence, valid, label; or dx, dy, dz and ox, oy, oz of a ray."""
    count = len(next(iter(c.values())))
    pixels = np.full((count, 2), np.nan)
    if "x [px]" in c:
        pixels = np.stack([c["x [px]"], c["y [px]"]], axis=1).astype(np.float64)
    directions = origins = None
    if "dx" in c:
        directions = np.stack([c["dx"], c["dy"], c["dz"]], axis=1)
        with np.errstate(invalid="ignore", divide="ignore"):
            directions = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    if "ox [m]" in c:
        origins = np.stack([c["ox [m]"], c["oy [m]"], c["oz [m]"]], axis=1)
    valid = np.ones(count, bool)
    for name, least in (("confidence", CONFIDENT), ("valid", 0.5)):
        valid &= c[name] >= least if name in c else True
    return _gaze(c["time [s]"], pixels, valid, directions, origins, c["label"].astype(str) if "label" in c else None)


def _size(path: Path, size: tuple[int, int] | None) -> tuple[int, int]:
    if size is None:
        raise FormatError(path, "gaze as a share of the picture, whose size is not known", fix="Give --gaze-size W,H")
    return size


TABLES: tuple[tuple[tuple[str, ...], Callable[..., Gaze], str], ...] = (
    (("timestamp [ns]", "gaze x [px]", "gaze y [px]"), _cloud, "Pupil Cloud"),
    (("gaze_timestamp", "norm_pos_x", "norm_pos_y", "confidence"), _pupil, "Pupil Core"),
    (("tracking_timestamp_us", "pitch_rads_cpf"), _aria, "Project Aria"),
    (("t_us", "yaw_rad", "pitch_rad"), _aria, "Project Aria"),
    (("timestamp", "gaze_pos_vid_x", "gaze_pos_vid_y"), _tools, "glassesTools"),
    (("timestamp", "norm_pos_x", "norm_pos_y"), _glasses, "mobileGazeMapping"),
    (("time [s]", "x [px]", "y [px]"), _plain, "table"),
    (("time [s]", "dx", "dy", "dz"), _plain, "table"),
)


def _tobii(path: Path, size: tuple[int, int] | None) -> Gaze:
    """Tobii Glasses 2 (`gp`, `ts` in microseconds) and 3 (`gaze2d`, seconds): lines of JSON, packed."""
    try:
        with gzip.open(path) as stream:
            data = stream.read(LARGEST + 1)
    except (OSError, EOFError, zlib.error) as error:
        raise FormatError(path, f"cannot be unpacked: {error}", fix="Copy it again") from None
    if len(data) > LARGEST:
        raise FormatError(path, "too large when unpacked", expected=f"<= {LARGEST} bytes")
    width, height = _size(path, size or (1920, 1080))
    times, shares = [], []
    for number, line in enumerate(io.TextIOWrapper(io.BytesIO(data), "utf-8", errors="replace"), start=1):
        found = _sample(path, number, line)
        if found:
            times.append(found[0])
            shares.append(found[1:])
    if not times:
        raise FormatError(path, "no gaze", expected="lines with gp (Glasses 2) or gaze2d (Glasses 3)")
    pixels = np.array(shares) * [width, height] - 0.5
    gaze = _gaze(times, pixels, np.ones(len(times), bool))
    return replace(gaze, source="Tobii Glasses")


def _sample(path: Path, number: int, line: str) -> tuple[float, float, float] | None:
    """Time and share of the picture of one line, None when it is about something else or the eyes were not found."""
    try:
        entry = json_of(line)
        if "gp" in entry and entry.get("s", 0) == 0:
            return (float(entry["ts"]) * 1e-6, float(entry["gp"][0]), float(entry["gp"][1]))
        if entry.get("type") == "gaze" and len(entry.get("data", {}).get("gaze2d", ())) == 2:
            return (float(entry["timestamp"]), *map(float, entry["data"]["gaze2d"]))  # type: ignore[return-value]
    except (ValueError, TypeError, KeyError, IndexError, AttributeError):
        raise FormatError(path, f"line {number} cannot be read", got=line[:60]) from None
    return None


def _in_order(gaze: Gaze) -> Gaze:
    """Samples by time; those without one, or with that of another, are left out and counted."""
    order = np.argsort(gaze.times, kind="stable")
    order = order[np.isfinite(gaze.times[order])]
    fresh = np.diff(gaze.times[order], prepend=-np.inf) > 0
    order = order[fresh]
    missing = len(gaze.times) - len(order)
    words = (f"{missing} gaze samples have no time of their own",) if missing else ()

    def chosen(values: np.ndarray | None) -> np.ndarray | None:
        return None if values is None else values[order]

    return Gaze(
        gaze.times[order], gaze.pixels[order], gaze.valid[order], chosen(gaze.directions), chosen(gaze.origins),
        chosen(gaze.labels), gaze.source, words,
    )  # fmt: skip


def on_clock(gaze: Gaze, times: np.ndarray, shift: float, path: Path) -> Gaze:
    """The gaze with `shift` s added to its times; FormatError when it does not overlap with the frames at all."""
    moved = replace(gaze, times=gaze.times + shift)
    inside = (moved.times >= times[0] - 1) & (moved.times <= times[-1] + 1)
    if not inside.any():
        raise FormatError(
            path, "gaze and pictures have no time in common", expected=f"{times[0]:.3f} to {times[-1]:.3f} s",
            got=f"{moved.times[0]:.3f} to {moved.times[-1]:.3f} s",
            fix=f"Give --gaze-shift: {times[0] - gaze.times[0]:.3f} lays both beginnings together",
        )  # fmt: skip
    return moved


def read_targets(path: Path) -> tuple[tuple[str, ...], np.ndarray]:
    """Names and places (t, 3) in metres of a table `name, x [m], y [m], z [m]`."""
    return places_of(path, columns_of(path), "target")


def places_of(path: Path, columns: Columns, what: str) -> tuple[tuple[str, ...], np.ndarray]:
    """Names and places (t, 3) in metres from the columns of a table of `what`s. Raises FormatError."""
    if "name" not in columns or not all(axis in columns and columns[axis].dtype.kind == "f" for axis in AXES):
        wanted = ", ".join(("name", *AXES))
        raise FormatError(path, f"no table of {what}s", expected=wanted, got=", ".join(columns))
    places = np.stack([columns[axis] for axis in AXES], axis=1)
    if not np.isfinite(places).all():
        raise FormatError(path, f"a {what} has no place", expected="finite numbers")
    return tuple(str(name) for name in columns["name"]), places
