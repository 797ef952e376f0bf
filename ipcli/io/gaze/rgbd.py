"""RGB-D recordings: TUM (`rgb.txt`, `depth.txt`) and 7-Scenes (`frame-XXXXXX.color.png`, `.depth.png`, `.pose.txt`).

Depth must be registered to the colour camera; one camera, so there is no right picture.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ipcli.errors import FormatError, ParameterError
from ipcli.inputs import warn_if_cut
from ipcli.io.files import text as layout
from ipcli.io.files.images import read_depth, read_image
from ipcli.io.gaze import pictures, trajectories
from ipcli.measurements.recording import Frame, HeadRecording

TUM_SCALE, MILLIMETRES = 5000.0, 1000.0
SEVEN_SCENES = (585.0, 585.0, 320.0, 240.0)
RATE = 30.0
PAIRED = 0.02  # seconds between a picture and its depth
GAP = 0.1  # seconds between poses of the truth


def is_tum(folder: Path) -> bool:
    """Whether the folder is a TUM RGB-D recording."""
    return (folder / "rgb.txt").is_file() and (folder / "depth.txt").is_file()


def is_seven_scenes(folder: Path) -> bool:
    """Whether the folder is a 7-Scenes sequence."""
    return folder.is_dir() and any(folder.glob("frame-*.depth.png"))


def open_tum(
    folder: Path, *, intrinsics: Sequence[float] | None = None, depth_scale: float = TUM_SCALE
) -> HeadRecording:
    """A TUM recording; it does not hold its calibration: give fx,fy,cx,cy."""
    if intrinsics is None:
        raise ParameterError(f"{folder}: a TUM recording does not say its calibration: give --intrinsics fx,fy,cx,cy")
    colours, depths = (_index(folder / f"{kind}.txt") for kind in ("rgb", "depth"))
    times = np.array([time for time, _ in depths])
    pairs: list[tuple[float, Path, Path]] = []
    alone = 0
    for time, path in colours:
        nearest = int(np.abs(times - time).argmin())
        if abs(times[nearest] - time) <= PAIRED:
            pairs.append((time, path, depths[nearest][1]))
        else:
            alone += 1
    if not pairs:
        fix = "Check the times of rgb.txt and depth.txt"
        raise FormatError(folder, "no picture has a depth map of its time", expected=f"within {PAIRED} s", fix=fix)
    words = (f"{alone} pictures have no depth map within {PAIRED} s",) if alone else ()
    stamps = np.array([pair[0] for pair in pairs])
    truth_file = folder / "groundtruth.txt"
    truth = trajectories.at_times(*trajectories.read_tum(truth_file), stamps, GAP) if truth_file.is_file() else None
    names = tuple(f"{time:.6f}".replace(".", "_") for time in stamps)
    return _recording(folder, names, stamps, pairs, intrinsics, depth_scale, truth, "TUM RGB-D", words)


def open_seven_scenes(
    folder: Path, *, intrinsics: Sequence[float] | None = None, depth_scale: float = MILLIMETRES
) -> HeadRecording:
    """A 7-Scenes sequence at 30 frames a second."""
    pairs: list[tuple[float, Path, Path]] = []
    poses, alone = [], 0
    for depth in sorted(folder.glob("frame-*.depth.png")):
        stem = depth.name.removesuffix(".depth.png")
        colour = next((p for s in layout.IMAGES if (p := folder / f"{stem}.color{s}").is_file()), None)
        if colour is None:
            alone += 1
            continue
        pairs.append((len(pairs) / RATE, colour, depth))
        pose = folder / f"{stem}.pose.txt"
        poses.append(layout.read_matrix(pose, (4, 4)) if pose.is_file() else np.full((4, 4), np.nan))
    if not pairs:
        raise FormatError(folder, "no colour pictures", expected="frame-XXXXXX.color.png beside each depth map")
    words = (f"{alone} depth maps have no colour picture",) if alone else ()
    names = tuple(pair[1].name.split(".")[0] for pair in pairs)
    stamps = np.array([pair[0] for pair in pairs])
    return _recording(
        folder, names, stamps, pairs, intrinsics or SEVEN_SCENES, depth_scale, np.stack(poses), "7-Scenes", words
    )


def _recording(folder, names, times, pairs, intrinsics, scale: float, truth, source: str, words) -> HeadRecording:
    if not scale > 0:
        raise ParameterError(f"{folder}: depth_scale = {scale!r}: expected a number > 0")
    camera = pictures.camera_of(folder, tuple(intrinsics), pictures.size_of(pairs[0][1]))

    def load(k: int) -> Frame:
        image = read_image(pairs[k][1])
        pictures.check_size(pairs[k][1], image.shape[:2], camera)
        depth = read_depth(pairs[k][2], scale)
        pictures.check_size(pairs[k][2], depth.shape, camera)
        return Frame(pictures.grey(image), None, depth, image)

    files = tuple(path for _, colour, depth in pairs for path in (colour, depth))
    return HeadRecording(names, times, (camera,), load, files, truth=truth, source=source, dropped=words)


def _index(path: Path) -> list[tuple[float, Path]]:
    """(time, file) of lines `time path`, in order of time."""
    entries = []
    warn_if_cut(path, layout.read_text(path))
    for line, text in layout.comment_free(path):
        time, _, name = text.partition(" ")
        if not name:
            raise FormatError(path, f"line {line} is cut", expected="a time and a file name", got=text)
        stamp = float(layout.numbers(path, line, [time], [1])[0])
        if not np.isfinite(stamp):
            raise FormatError(path, f"line {line} has no time", got=time)
        entries.append((stamp, path.parent / name.strip()))
    times = [time for time, _ in entries]
    if len(set(times)) != len(times):
        raise FormatError(path, "one time twice", fix="Leave one of the two lines out")
    if not entries:
        raise FormatError(path, "lists nothing", expected="lines of a time and a file name", fix="Check the copy")
    return sorted(entries)
