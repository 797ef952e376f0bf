"""Exports of Project Aria (Gen 2): the two front SLAM cameras, gaze in the central pupil frame, trajectory.

`calib.json` gives each camera's 15 parameters of FISHEYE624 and T_device_camera, and T_device_cpf; the central pupil
frame has x to the left, y up, z forward. The 3-D gaze point of the export is where the eyes' rays meet (vergence): its
direction is used, its depth is not.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ipcli.errors import FormatError
from ipcli.inputs import json_of
from ipcli.io.files import text as layout
from ipcli.io.gaze import gaze_files, pictures, trajectories
from ipcli.measurements.recording import Camera, Gaze, HeadRecording

SIDES = ("slam-front-left", "slam-front-right")
NANOSECONDS = 1e-9
PAIRED = 2_000_000  # nanoseconds between the two pictures of a moment
PARAMETERS = 15  # f, cx, cy, k0...k5, p0 p1, s0...s3


def is_vrs(path: Path) -> bool:
    """Whether it is a recording as the device makes it."""
    return path.is_file() and path.suffix.lower() == ".vrs"


def open_vrs(path: Path) -> HeadRecording:
    """FormatError, which says how it becomes an export: only the device's own library reads such files."""
    raise FormatError(
        path, "VRS recordings are not read", expected="an export: calib.json, slam-front-*_NS.png, eyegaze.csv",
        fix="Export pictures and calibration with Meta's projectaria-tools (Python < 3.13)",
    )  # fmt: skip


def is_aria(folder: Path) -> bool:
    """Whether the folder is such an export."""
    return (folder / "calib.json").is_file() and any(folder.glob(f"{SIDES[0]}_*.png"))


def open_aria(folder: Path) -> HeadRecording:
    """The recording; the trajectory of the device is taken as truth where it is there."""
    calibration = _json(folder / "calib.json")
    left, right = (
        {int(path.stem.rsplit("_", 1)[1]): path for path in sorted(folder.glob(f"{side}_*.png"))} for side in SIDES
    )
    pairs = _paired(folder, left, right)
    poses = [_pose(folder, calibration, side) for side in SIDES]
    size = pictures.size_of(pairs[0][1])
    cameras = tuple(
        _camera(folder, calibration[side], size, np.linalg.inv(pose) @ poses[0])
        for side, pose in zip(SIDES, poses, strict=True)
    )
    times = np.array([pair[0] for pair in pairs]) * NANOSECONDS
    gaze_file = folder / "eyegaze.csv"
    tum = next(iter(sorted(folder.glob("*.tum"))), None)
    truth = trajectories.at_times(*trajectories.read_tum(tum), times, 0.1) @ poses[0] if tum else None
    files = [folder / "calib.json", *(path for path in (gaze_file, tum) if path and path.is_file())]
    return HeadRecording(
        tuple(str(pair[0]) for pair in pairs),
        times,
        cameras,
        pictures.loader([pair[1:] for pair in pairs], cameras),
        (*files, *(path for pair in pairs for path in pair[1:])),
        _gaze(gaze_file, np.linalg.inv(poses[0]) @ _matrix(folder, calibration, "T_device_cpf")),
        truth,
        source="Project Aria",
    )


def _json(path: Path) -> dict[str, Any]:
    try:
        found = json_of(layout.read_text(path))
    except ValueError as error:
        raise FormatError(path, f"not valid JSON: {error}") from None
    if not isinstance(found, dict):
        raise FormatError(path, "not a calibration", expected="an object", got=type(found).__name__)
    return found


def _paired(folder: Path, left: dict[int, Path], right: dict[int, Path]) -> list[tuple[int, Path, Path]]:
    stamps = np.array(sorted(right), np.int64)
    pairs = []
    for time, path in left.items():
        nearest = int(stamps[np.abs(stamps - time).argmin()]) if len(stamps) else 0
        if len(stamps) and abs(nearest - time) <= PAIRED:
            pairs.append((time, path, right[nearest]))
    if not pairs:
        raise FormatError(folder, "no pictures of both front cameras at one time", expected="within 2 ms")
    return pairs


def _camera(folder: Path, entry: dict[str, Any], size: tuple[int, int], cam_from_rig: np.ndarray) -> Camera:
    values = _numbers(entry.get("params"))
    if entry.get("model") != "FISHEYE624" or values.shape != (PARAMETERS,) or not np.isfinite(values).all():
        raise FormatError(
            folder / "calib.json", "unknown camera model", expected=f"FISHEYE624 with {PARAMETERS} numbers",
            got=f"{entry.get('model')} with {values.size}",
        )  # fmt: skip
    focal = (values[0], values[0], values[1], values[2])
    return pictures.camera_of(folder, focal, size, model="fisheye624", distortion=values[3:], cam_from_rig=cam_from_rig)


def _pose(folder: Path, calibration: dict[str, Any], side: str) -> np.ndarray:
    if not isinstance(calibration.get(side), dict):
        raise FormatError(folder / "calib.json", f"no {side}", got=", ".join(calibration))
    return _matrix(folder, calibration[side], "T_device_camera")


def _matrix(folder: Path, entry: dict[str, Any], key: str) -> np.ndarray:
    value = _numbers(entry.get(key))
    if (
        value.shape != (4, 4)
        or not np.isfinite(value).all()
        or not np.allclose(value[:3, :3] @ value[:3, :3].T, np.eye(3), atol=1e-3)
    ):
        raise FormatError(folder / "calib.json", f"no rigid {key}", expected=(4, 4), got=value.shape)
    return value


def _numbers(value: Any) -> np.ndarray:
    """An array of float64 of what a JSON holds; an empty one for what are no numbers."""
    try:
        return np.array(value, np.float64)
    except (TypeError, ValueError):
        return np.zeros(0)


def _gaze(path: Path, rig_from_cpf: np.ndarray) -> Gaze | None:
    """Rays from the central pupil frame: x left and y up there, so the direction is (tan yaw, tan pitch, 1)."""
    if not path.is_file():
        return None
    gaze = gaze_files.read_gaze(path)
    if gaze.directions is None:
        raise FormatError(path, "not the gaze of an Aria", expected="yaw and pitch", got=gaze.source)
    cpf = gaze.directions * np.array([-1.0, -1.0, 1.0])  # gaze_files gives OpenCV's axes
    return Gaze(
        gaze.times,
        gaze.pixels,
        gaze.valid,
        cpf @ rig_from_cpf[:3, :3].T,
        np.tile(rig_from_cpf[:3, 3], (len(cpf), 1)),
        source=gaze.source,
        dropped=gaze.dropped,
    )
