"""A folder, an archive or a single file of motions as Clips, labelled by a manifest, by HDM05 names or by folders.

A manifest is manifest.csv in the folder (or given): columns path, label, actor, and optionally start, stop (frames, the
last not included), name, split (train or test). Without one, names like HDM_bd_squat1Reps_001_120.amc say all; else
files lie in LABEL/ or LABEL/ACTOR/. Top folders train/ and test/ become a split.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ipcli.errors import FormatError, ParameterError
from ipcli.geometry.upright import Y_UP_FROM, upright
from ipcli.inputs import warn_if_cut
from ipcli.io.files.archive import Unpacked, is_archive, listing, unpacked
from ipcli.io.files.text import read_text, whole
from ipcli.io.motion import acclaim, bvh, c3d, msr, tables, trc
from ipcli.measurements.motions import TEST, TRAIN, Clip, Clips, Motion

HDM05 = re.compile(r"HDM_(?P<actor>[a-zA-Z]+)_(?P<label>.+)_\d+_\d+")
UNITS = {"m": 1.0, "dm": 0.1, "cm": 0.01, "mm": 0.001, "inch": 0.0254, "foot": 0.3048}
SMALLEST, LARGEST = 0.1, 10.0  # metres a body may span
READERS: dict[str, Callable[..., Motion]] = {
    ".amc": acclaim.read,
    ".bvh": bvh.read,
    ".c3d": c3d.read,
    ".npz": tables.read_npz,
    ".csv": tables.read_csv,
    ".trc": trc.read,
    ".txt": msr.read,
}
UNREAD = {".fbx": "BVH", ".glb": "BVH", ".gltf": "BVH", ".c3dx": "C3D", ".mot": "TRC", ".htr": "BVH", ".v3d": "C3D"}
TABLES_ABOUT_TABLES = ("manifest.csv", tables.SKELETON)


@dataclass(frozen=True)
class Recording:
    """A clip that has not been read."""

    name: str
    path: Path
    label: str = ""
    actor: str = ""
    start: int | None = None
    stop: int | None = None
    split: str = ""


@dataclass(frozen=True)
class Reading:
    """What the files do not say: metres a unit of length, the rate in Hz, which axis is up."""

    unit: float | None = None
    rate: float | None = None
    up: str = "y"


def is_recordings(path: Path) -> bool:
    """Whether it is a motion file, or a folder or archive with one in it (or with a skeleton, to say what is
    missing).
    """
    return any(_is_motion(file) or file.suffix.lower() == ".asf" for file in (path, *map(Path, listing(path))))


def _is_motion(file: Path) -> bool:
    if file.suffix.lower() == ".txt" and not msr.is_msr(file):
        return False
    return file.suffix.lower() in READERS and file.name[0] != "." and file.name not in TABLES_ABOUT_TABLES


def open_recordings(
    path: Path,
    *,
    manifest: Path | None = None,
    unit: str | None = None,
    source_rate: float | None = None,
    up: str = "y",
) -> Clips:
    """The motion files at `path`. `unit` is a name of UNITS or metres as a number; `up` the axis that points up in the
    files.

    Raises FormatError for a file that is damaged or of another skeleton than the first, ParameterError for hints.
    """
    if up not in Y_UP_FROM:
        raise ParameterError(f"up axis '{up}': give {', '.join(Y_UP_FROM)}")
    home = unpacked(path)
    folder, said = _level(home.folder, manifest)
    recordings = _listed(folder, path, manifest)
    reading = Reading(_unit(unit), source_rate, up)
    skeletons: dict[Path, acclaim.Asf] = {}
    skeleton = _read(recordings[0], reading, skeletons).skeleton
    by_name = {recording.name: recording for recording in recordings}

    def load(name: str, home: Unpacked = home) -> Clip:
        recording = by_name[name]
        motion = _read(recording, reading, skeletons)
        return Clip(name, _cut(motion, recording), recording.label, recording.actor)

    def files(name: str) -> tuple[Path, ...]:
        return (path,) if is_archive(path) else (by_name[name].path,)

    about = tuple(item.label for item in recordings), tuple(item.actor for item in recordings)
    return Clips(tuple(by_name), *about, skeleton, load, files, _split(recordings), said)


def _read(recording: Recording, reading: Reading, skeletons: dict[Path, acclaim.Asf]) -> Motion:
    path, suffix = recording.path, recording.path.suffix.lower()
    if suffix not in READERS:
        raise FormatError(
            path,
            "not a motion file",
            expected=", ".join(READERS),
            got=suffix or "no suffix",
            fix="Correct the manifest",
        )
    hints: dict[str, Any] = {"rate": reading.rate, "unit": reading.unit}
    if suffix == ".amc":
        asf = acclaim.asf_of(path)
        hints["asf"] = skeletons[asf] if asf in skeletons else skeletons.setdefault(asf, acclaim.read_asf(asf))
    motion = _upright(READERS[suffix](path, **hints), reading.up)
    return _sized(motion, path)


def _upright(motion: Motion, up: str) -> Motion:
    """The world turned by whole axes so that `up` becomes y."""
    if up == "y":
        return motion
    rotations = None if motion.rotations is None else Y_UP_FROM[up] @ motion.rotations
    return replace(motion, positions=upright(motion.positions, up), rotations=rotations)


def _sized(motion: Motion, path: Path) -> Motion:
    """FormatError for a body that no person can have, which is how a wrong unit shows."""
    seen = np.isfinite(motion.positions).all(axis=-1)
    whole = motion.positions[seen.sum(axis=1).argmax()]
    size = float((np.nanmax(whole, axis=0) - np.nanmin(whole, axis=0)).max())
    if seen.sum(axis=1).max() > 2 and not SMALLEST <= size <= LARGEST:
        fix = f"Give the unit of length of the files with --unit ({', '.join(UNITS)}, or metres as a number)"
        raise FormatError(
            path,
            "a body of this size is no person's",
            expected=f"{SMALLEST} to {LARGEST} m",
            got=f"{size:.3g} m",
            fix=fix,
        )
    return motion


def _cut(motion: Motion, recording: Recording) -> Motion:
    if recording.start is None and recording.stop is None:
        return motion
    frames = slice(recording.start, recording.stop)
    positions = motion.positions[frames]
    if not len(positions):
        got = f"{recording.start} to {recording.stop} of {len(motion.positions)}"
        raise FormatError(recording.path, "no frames between start and stop", got=got, fix="Correct the manifest")
    notes = motion.notes
    if recording.stop is not None and recording.stop > len(motion.positions):
        notes += (f"stop {recording.stop} of the manifest lies beyond its {len(motion.positions)} frames: cut there",)
    rotations = None if motion.rotations is None else motion.rotations[frames]
    return replace(motion, positions=positions, rotations=rotations, notes=notes)


def _unit(unit: str | None) -> float | None:
    if unit is None:
        return None
    try:
        metres = UNITS[unit] if unit in UNITS else float(unit)
    except ValueError:
        metres = 0.0
    if not 0 < metres < np.inf:
        raise ParameterError(f"unit '{unit}': give one of {', '.join(UNITS)}, or metres as a number")
    return metres


def _level(folder: Path, manifest: Path | None) -> tuple[Path, tuple[str, ...]]:
    """The folder in which the labels begin, and what there is to say about it.

    A set that lies in one more folder than it has to (as `tar cf x.tar motions/` packs it) is found there.
    """
    if not folder.is_dir():
        return folder, ()
    every = [Path(name) for name in listing(folder)]
    odd = sorted({file.suffix.lower() for file in every} & {*UNREAD})
    said = tuple(
        f"{sum(file.suffix.lower() == suffix for file in every)} files of {suffix} are not read: export them as "
        f"{UNREAD[suffix]}"
        for suffix in odd
    )
    motions = [file for file in every if _is_motion(file)]
    if manifest is not None or "manifest.csv" in map(str, every) or not motions or _named_by_themselves(motions):
        return folder, said
    tops = {file.parts[0] for file in motions}
    top = next(iter(tops))
    if len(tops) > 1 or min(len(file.parts) for file in motions) < 2 or top in ("train", "test"):
        return folder, (*said, *_depth(motions))
    inside = {file.parts[1] for file in motions if len(file.parts) > 2}
    if (folder / top / "manifest.csv").is_file() or max(len(file.parts) for file in motions) > 3 or "train" in inside:
        deeper, more = _level(folder / top, None)
        return deeper, (*said, *more, f"everything lies in '{top}': labels were taken from the folders in it")
    if len(inside) > 1:
        said += (
            f"all clips lie in '{top}', so that is their label and {', '.join(sorted(inside)[:4])} are actors. If "
            f"those are the labels, give the folder '{top}' itself, or pack it from inside (tar -C {top} -cf x.tar .)",
        )
    return folder, said


def _named_by_themselves(motions: Sequence[Path]) -> bool:
    return all(HDM05.fullmatch(file.stem) or msr.is_msr(file) for file in motions)


def _depth(motions: Sequence[Path]) -> tuple[str, ...]:
    deep = [file for file in motions if len(file.parts) - (file.parts[0] in ("train", "test")) > 3]
    if not deep:
        return ()
    return (f"{len(deep)} clips lie deeper than LABEL/ACTOR/ (such as {deep[0]}): the first two folders were taken",)


def _listed(folder: Path, path: Path, manifest: Path | None) -> list[Recording]:
    """The recordings in order, from a manifest if there is one."""
    manifest = manifest or (folder / "manifest.csv" if (folder / "manifest.csv").is_file() else None)
    if manifest is not None:
        found = _of_manifest(manifest, folder if folder.is_dir() else folder.parent)
    elif folder.is_file():
        found = [_guessed(folder, folder.parent)] if _is_motion(folder) else []
    else:
        files = (folder / name for name in listing(folder))
        found = [_guessed(file, folder) for file in files if _is_motion(file)]
    if not found:
        fix = "Add the motions; an ASF file is a skeleton at rest"
        raise FormatError(manifest or path, "no motion in it", expected=f"{', '.join(READERS)} files", fix=fix)
    return _uniquely_named(found, folder)


def _guessed(file: Path, folder: Path) -> Recording:
    """What the name or the folders of a file say of it."""
    parts = file.relative_to(folder).parts[:-1]
    split = parts[0] if parts and parts[0] in ("train", "test") else ""
    if named := HDM05.fullmatch(file.stem):
        return Recording(file.stem, file, named["label"], named["actor"], split=split)
    if named_by_msr := msr.label_of(file.stem) if msr.is_msr(file) else None:
        return Recording(file.stem, file, *named_by_msr, split=split)
    label, actor = (*parts[bool(split) :], "", "")[:2]
    return Recording(file.stem, file, label, actor, split=split)


def _uniquely_named(found: Sequence[Recording], folder: Path) -> list[Recording]:
    names = [item.name for item in found]
    if len(set(names)) == len(names):
        return list(found)
    longer = [item.path.relative_to(folder).with_suffix("").as_posix().replace("/", ".") for item in found]
    if len(set(longer)) < len(longer):
        longer = [f"{name}.{item.start or 0}" for name, item in zip(longer, found, strict=True)]
    if len(set(longer)) < len(longer):
        twice = next(name for name in longer if longer.count(name) > 1)
        raise FormatError(folder, f"two clips are named '{twice}'", fix="Add a column `name` to the manifest")
    return [replace(item, name=name) for item, name in zip(found, longer, strict=True)]


def _of_manifest(manifest: Path, folder: Path) -> list[Recording]:
    text = read_text(manifest)
    warn_if_cut(manifest, text)
    header, *rows = tables.table_rows(manifest, text) or [[]]
    header = [column.strip().lower() for column in header]
    known = {"path", "label", "actor", "start", "stop", "name", "split"}
    columns = set(header)
    if "path" not in columns or columns - known:
        got = ", ".join(header or ("nothing",))[:80]
        expected = "path, label, actor and maybe start, stop, name, split"
        raise FormatError(manifest, "wrong columns", expected=expected, got=got, fix="See docs/motions.md")
    lines = [(number, row) for number, row in enumerate(rows, start=2) if any(cell.strip() for cell in row)]
    return [_of_row(manifest, number, dict(zip(header, row, strict=False)), folder) for number, row in lines]


def _of_row(manifest: Path, line: int, row: dict[str, str], folder: Path) -> Recording:
    row = {key: value.strip() for key, value in row.items()}
    path = _there(folder, row["path"])
    if path is None:
        fix = "Correct the path; it is relative to the folder"
        raise FormatError(manifest, f"line {line}: no file '{row['path']}' in {folder.name}", fix=fix)
    split = row.get("split", "")
    if split not in ("", "train", "test"):
        raise FormatError(
            manifest, f"line {line}: split '{split}'", expected="train, test or nothing", fix="Correct the line"
        )
    start, stop = (_frame(manifest, line, row.get(key, "")) for key in ("start", "stop"))
    name = row.get("name") or path.stem + ("" if start is None else f"_{start}")
    return Recording(name, path, row.get("label", ""), row.get("actor", ""), start, stop, split)


def _there(folder: Path, name: str) -> Path | None:
    """The file of a name, or of the same with the slashes of Windows turned."""
    paths = (folder / name, folder / name.replace("\\", "/"))
    return next((path for path in paths if os.path.isfile(path)), None)  # no error for a name that no file can have


def _frame(manifest: Path, line: int, text: str) -> int | None:
    number = whole(text)
    if text and number is None:
        raise FormatError(
            manifest, f"line {line}: '{text}' is not a frame", expected="a number from 0", fix="Correct the line"
        )
    return number


def _split(recordings: Sequence[Recording]) -> dict[str, np.ndarray]:
    numbers = {"train": TRAIN, "test": TEST, "": 0}
    row = np.array([numbers[item.split] for item in recordings], np.int8)
    return {"published": row} if {TRAIN, TEST} <= set(row.tolist()) else {}
