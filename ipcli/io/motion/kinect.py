"""Skeletons of the first Kinect: Florence 3D Actions and UTKinect-Action in the release of Vemulapalli et al. 2014,
with their splits.

Both have positions only, in metres, of the sensor's frame turned so that y is up and right-handed. Splits are the ten
published ones, half of the actors against the other half.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ipcli.errors import FormatError, nearest
from ipcli.geometry.skeleton import Skeleton
from ipcli.inputs import warn_if_cut
from ipcli.io.files import matlab
from ipcli.io.files.archive import is_archive, listing, unpacked
from ipcli.io.files.text import comment_free, read_text, whole
from ipcli.measurements.motions import TEST, TRAIN, Clip, Clips, Motion, check_motion

FLORENCE_RATE = 30.0  # Hz, the sensor's; the files do not say which frames were kept
NUMBERING_RATE = 30.0  # Hz, of the frame numbers of UTKinect
DAMAGED = "Check that the copy is complete"

FLORENCE = Skeleton(
    (
        "head",
        "neck",
        "spine",
        "left_shoulder",
        "left_elbow",
        "left_wrist",
        "right_shoulder",
        "right_elbow",
        "right_wrist",
    )
    + ("left_hip", "left_knee", "left_ankle", "right_hip", "right_knee", "right_ankle"),
    (1, 2, -1, 1, 3, 4, 1, 6, 7, 2, 9, 10, 2, 12, 13),
)
KINECT = Skeleton(
    ("hip_center", "spine", "shoulder_center", "head", "left_shoulder", "left_elbow", "left_wrist", "left_hand")
    + ("right_shoulder", "right_elbow", "right_wrist", "right_hand", "left_hip", "left_knee", "left_ankle", "left_foot")
    + ("right_hip", "right_knee", "right_ankle", "right_foot"),
    (-1, 0, 1, 2, 2, 4, 5, 6, 2, 8, 9, 10, 0, 12, 13, 14, 0, 16, 17, 18),
)


def is_florence(path: Path) -> bool:
    """Whether a folder or archive holds Florence 3D Actions."""
    return (path.is_dir() or is_archive(path)) and _place(path, "skeletal_data.mat") is not None


def open_florence(path: Path) -> Clips:
    """The 215 clips of Florence 3D Actions: skeletal_data.mat, action_names.mat, tr_te_splits.mat."""
    home = unpacked(path)
    folder = home.folder / (_place(home.folder, "skeletal_data.mat") or "")
    source = folder / "skeletal_data.mat"
    recordings = [item[0, 0] for item in _load(source, "skeletal_data").ravel()]
    actions = _texts(folder / "action_names.mat", "action_names")
    labels, subjects = ([int(item[key][0, 0]) for item in recordings] for key in ("action", "subject"))
    names = tuple(f"{index:03d}" for index in range(1, len(recordings) + 1))

    def load(name: str) -> Clip:
        index = names.index(name)
        positions = recordings[index]["original_skeletal_data"]
        if positions.ndim != 3 or positions.shape[:2] != (3, len(FLORENCE.joints)):
            raise FormatError(
                source, f"clip {name} has the wrong shape", expected="(3, 15, frames)", got=positions.shape, fix=DAMAGED
            )
        upright = np.moveaxis(positions, -1, 0)[:, [0, 2, 1]]  # their x, depth, up is left-handed
        motion = Motion(FLORENCE, _seen(np.swapaxes(upright, 1, 2)), FLORENCE_RATE)
        return Clip(
            name, check_motion(motion, f"{source}: clip {name}"), actions[labels[index] - 1], f"{subjects[index]:02d}"
        )

    splits = _splits(folder / "tr_te_splits.mat", subjects)
    about = tuple(actions[label - 1] for label in labels), tuple(f"{subject:02d}" for subject in subjects)
    return Clips(names, *about, FLORENCE, load, _kept(home, path), splits)


def is_utkinect(path: Path) -> bool:
    """Whether a folder or archive holds UTKinect-Action."""
    return (path.is_dir() or is_archive(path)) and _place(path, "joints_s01_e01.txt") is not None


def open_utkinect(path: Path) -> Clips:
    """The 199 clips of UTKinect-Action: joints/joints_sXX_eYY.txt cut by actionLabel_modified.txt, or else by
    actionLabel.txt.

    Rows whose frame number was there before are left out. Rows are taken as equally far apart in time, which they are
    but for the frames in which the sensor found nobody.
    """
    home = unpacked(path)
    folder = home.folder / (_place(home.folder, "joints_s01_e01.txt") or "")
    cuts = _cuts(
        next(
            (file for file in (folder / "actionLabel_modified.txt", folder / "actionLabel.txt") if file.is_file()),
            folder,
        )
    )
    names = tuple(cuts)
    tables: dict[str, np.ndarray] = {}

    def load(name: str) -> Clip:
        take, label, start, stop = cuts[name]
        source = folder / f"joints_{take}.txt"
        if take not in tables:
            tables[take] = _table(source)
        table = tables[take]
        chosen = table[(table[:, 0] >= start) & (table[:, 0] <= stop)]
        if len(chosen) < 1:
            raise FormatError(source, f"no frame of {name}", expected=f"frames {start} to {stop}", fix=DAMAGED)
        positions = _seen(chosen[:, 1:].reshape(len(chosen), -1, 3))
        step = float(np.median(np.diff(table[:, 0]))) if len(table) > 1 else 1.0
        first, last = table[[0, -1], 0]
        notes = (
            (f"frames {start} to {stop} lie partly beyond the table, which has {first:g} to {last:g}: cut there",)
            if start < first or stop > last
            else ()
        )
        motion = Motion(KINECT, positions, NUMBERING_RATE / step, notes=notes)
        return Clip(name, check_motion(motion, source), label, take[1:3])

    actors = tuple(cuts[name][0][1:3] for name in names)
    splits = _splits(folder.parent / "tr_te_splits.mat", [int(actor) for actor in actors])
    return Clips(names, tuple(cuts[name][1] for name in names), actors, KINECT, load, _kept(home, path), splits)


def _place(path: Path, name: str) -> str | None:
    """The folder inside a folder or archive that holds a file of this name."""
    found = (Path(file) for file in listing(path))
    return next((file.parent.as_posix() for file in found if file.name == name), None)


def _kept(home: Any, path: Path) -> Any:
    """The files of a clip; holding on to the unpacked archive too, so that it stays as long as the clips."""

    def files(name: str, home: Any = home) -> tuple[Path, ...]:
        return (path,)

    return files


def _cuts(path: Path) -> dict[str, tuple[str, str, int, int]]:
    """Clip name -> (take, label, first frame, last frame); actions marked NaN are left out."""
    cuts: dict[str, tuple[str, str, int, int]] = {}
    take = ""
    warn_if_cut(path, read_text(path))
    for line, text in comment_free(path):
        label, colon, frames = text.partition(":")
        if not colon:
            take = text
            if whole(take[1:3]) is None:
                raise FormatError(path, f"line {line}: '{text[:40]}'", expected="a take such as s01_e01", fix=DAMAGED)
            continue
        words = frames.split()
        if [word.lower() for word in words] == ["nan", "nan"]:
            continue
        if not take or len(words) != 2 or any(whole(word) is None for word in words):
            raise FormatError(
                path, f"line {line}: '{text}'", expected="a take, then lines `action: first last`", fix=DAMAGED
            )
        if f"{take}_{label.strip()}" in cuts:
            raise FormatError(path, f"line {line}: '{text[:40]}' is in this take twice", fix=DAMAGED)
        cuts[f"{take}_{label.strip()}"] = (take, label.strip(), int(words[0]), int(words[1]))
    if not cuts:
        raise FormatError(path, "holds no action", expected="a take, then lines `action: first last`", fix=DAMAGED)
    return cuts


def _table(path: Path) -> np.ndarray:
    """Frame number and 60 coordinates a row, each frame number once."""
    try:
        table = np.loadtxt(path, ndmin=2)
    except (OSError, ValueError) as error:
        raise FormatError(path, f"not a table of numbers: {' '.join(str(error).split())}", fix=DAMAGED) from None
    if table.shape[1] != 1 + 3 * len(KINECT.joints):
        raise FormatError(
            path,
            "rows of the wrong length",
            expected="a frame number and 60 coordinates",
            got=table.shape[1],
            fix=DAMAGED,
        )
    return table[np.unique(table[:, 0], return_index=True)[1]]


def _seen(positions: np.ndarray) -> np.ndarray:
    """Positions (f, j, 3) with NaN for joints at exactly 0, which is what the sensor writes for one that it lost."""
    positions = np.array(positions, np.float64)
    positions[(positions == 0).all(axis=-1)] = np.nan
    return positions


def _splits(path: Path, subjects: Sequence[int]) -> dict[str, np.ndarray]:
    """The published splits, if they are there: clips of the training subjects 1, of the test subjects 2."""
    if not path.is_file():
        return {}
    train, test = _load(path, "tr_subjects"), _load(path, "te_subjects")
    who = np.asarray(subjects)
    rows = (
        np.where(np.isin(who, tr), TRAIN, np.where(np.isin(who, te), TEST, 0))
        for tr, te in zip(train, test, strict=True)
    )
    return {f"{index:02d}": row.astype(np.int8) for index, row in enumerate(rows, start=1)}


def _load(path: Path, variable: str) -> np.ndarray:
    found = matlab.read(path, fix=DAMAGED)
    if variable not in found:
        what = f"no variable '{variable}'{nearest(variable, found)}"
        raise FormatError(path, what, fix="Check that it is the right file")
    return found[variable]


def _texts(path: Path, variable: str) -> list[str]:
    return [str(item[0]) for item in _load(path, variable).ravel()]
