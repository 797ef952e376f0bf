"""KITTI odometry: rectified pairs `image_0/`, `image_1/` (or `image_l/`, `image_r/`), `calib.txt`, `times.txt`, poses.

`calib.txt` holds 3 x 4 projection matrices, one a line, with or without a name; the right one has -f b in its last
column.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ipcli.errors import FormatError
from ipcli.io.files import text as layout
from ipcli.io.gaze import pictures, trajectories
from ipcli.measurements.recording import Camera, HeadRecording

PAIRS = (("image_0", "image_1"), ("image_2", "image_3"), ("image_l", "image_r"))
RATE = 10.0  # frames a second of KITTI, where there is no times.txt


def is_kitti(folder: Path) -> bool:
    """Whether the folder holds such a sequence."""
    return (folder / "calib.txt").is_file() and _folders(folder) is not None


def open_kitti(folder: Path) -> HeadRecording:
    """The sequence; `poses.txt` gives the truth, if it is there."""
    folders = _folders(folder)
    if folders is None:
        raise FormatError(folder, "no pictures", expected="image_0 and image_1", fix="Check the layout")
    left, right = (layout.by_stem(folder / name, layout.IMAGES) for name in folders)
    names, words = pictures.matched(folder, left, right)
    cameras = _cameras(folder / "calib.txt", folders, left[names[0]])
    pairs = [(left[name], right[name]) for name in names]
    files = [path for path in (folder / "calib.txt", folder / "times.txt", folder / "poses.txt") if path.is_file()]
    truth = trajectories.read_kitti(folder / "poses.txt", len(names)) if (folder / "poses.txt").is_file() else None
    return HeadRecording(
        tuple(names),
        _times(folder / "times.txt", len(names)),
        cameras,
        pictures.loader(pairs, cameras),
        (*files, *(path for pair in pairs for path in pair)),
        truth=truth,
        source="KITTI odometry",
        dropped=words,
    )


def _folders(folder: Path) -> tuple[str, str] | None:
    return next((pair for pair in PAIRS if all((folder / name).is_dir() for name in pair)), None)


def _cameras(path: Path, folders: tuple[str, str], first: Path) -> tuple[Camera, Camera]:
    """Both cameras of the pair of folders: P0, P1 or P2, P3 where the lines have names, else the first two lines."""
    named: dict[str, np.ndarray] = {}
    for line, text in layout.comment_free(path):
        name, colon, rest = text.partition(":")
        if name.strip() == "Tr":
            continue
        key = name.strip() if colon else f"P{len(named)}"
        named[key] = layout.numbers(path, line, (rest if colon else text).split(), [12]).reshape(3, 4)
    wanted = ("P2", "P3") if folders == ("image_2", "image_3") else ("P0", "P1")
    if missing := [key for key in wanted if key not in named]:
        raise FormatError(path, f"no {' or '.join(missing)}", got=", ".join(named), fix="Add the projection matrices")
    size = pictures.size_of(first)
    origin = named[wanted[0]][0, 3] / named[wanted[0]][0, 0]
    cameras = []
    for key in wanted:
        p = named[key]
        pose = np.eye(4)
        pose[0, 3] = p[0, 3] / p[0, 0] - origin
        values = (p[0, 0], p[1, 1], p[0, 2], p[1, 2])
        cameras.append(pictures.camera_of(path, values, size, cam_from_rig=pose))
    if not cameras[1].cam_from_rig[0, 3] < 0:
        raise FormatError(
            path, "the right camera is not to the right", expected="P1[0, 3] = -f b < 0",
            got=cameras[1].cam_from_rig[0, 3], fix="Swap the two projection matrices or the two folders",
        )  # fmt: skip
    return cameras[0], cameras[1]


def _times(path: Path, count: int) -> np.ndarray:
    if not path.is_file():
        return np.arange(count) / RATE
    times = np.array([layout.numbers(path, n, text.split(), [1])[0] for n, text in layout.comment_free(path)])
    if len(times) != count or not (np.diff(times) > 0).all():
        raise FormatError(path, "not one ascending time a frame", expected=count, got=len(times))
    return times
