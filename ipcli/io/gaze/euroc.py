"""EuRoC / ASL recordings: `mav0/camN/data/*.png` with `sensor.yaml`, and the flat forms that courses hand out.

Flat: `cam0_sensor.yaml` and `cam1_sensor.yaml` beside `cam0/`, `cam1/` or beside `images/TIME_0.jpg`, `TIME_1.jpg`.
Names are nanoseconds. T_BS in a sensor file maps points of the sensor to the body (the IMU).
`imu0/data.csv` is kept where it is there.
"""

from __future__ import annotations

import re
from functools import partial
from pathlib import Path

import numpy as np

from ipcli.errors import FormatError
from ipcli.io.files import text as layout
from ipcli.io.gaze import pictures, trajectories
from ipcli.measurements.recording import Camera, HeadRecording

MODELS = {"radial-tangential": "radtan", "radtan": "radtan", "equidistant": "equidistant", "none": "pinhole"}
NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
GAP = 0.2  # seconds between two poses of the truth that may be interpolated


def is_euroc(folder: Path) -> bool:
    """Whether the folder holds such a recording."""
    return _sensor(folder, 0) is not None


def open_euroc(folder: Path) -> HeadRecording:
    """The recording with its truth where there is one: `state_groundtruth_estimate0/data.csv` or `gt_cam0.tum`."""
    root = folder / "mav0" if (folder / "mav0").is_dir() else folder
    sensors = [path for path in (_sensor(folder, 0), _sensor(folder, 1)) if path]
    pairs, words = _pictures(root, len(sensors))
    names = list(pairs)
    cameras, body_from_cam = _cameras(sensors, pairs[names[0]])
    times = np.array([int(name) for name in names], dtype=np.int64) * 1e-9
    truth, files = _truth(root, times, body_from_cam)
    imu, more = _imu(root, body_from_cam)
    paths = tuple(path for pair in pairs.values() for path in pair)
    return HeadRecording(
        tuple(names),
        times,
        cameras,
        pictures.loader(list(pairs.values()), cameras),
        (*sensors, *files, *more, *paths),
        truth=truth,
        imu=imu,
        source="EuRoC/ASL",
        dropped=words,
    )


def _sensor(folder: Path, camera: int) -> Path | None:
    places = (
        folder / "mav0" / f"cam{camera}" / "sensor.yaml",
        folder / f"cam{camera}" / "sensor.yaml",
        folder / f"cam{camera}_sensor.yaml",
    )
    return next((path for path in places if path.is_file()), None)


def _pictures(root: Path, count: int) -> tuple[dict[str, tuple[Path, ...]], tuple[str, ...]]:
    """The files of each moment by its nanoseconds."""
    folders = [root / f"cam{c}" / "data" for c in range(count)]
    if not folders[0].is_dir():
        folders = [root / f"cam{c}" for c in range(count)]
    found = [layout.by_stem(folder, layout.IMAGES) for folder in folders]
    if not found[0] and (root / "images").is_dir():
        mixed = layout.by_stem(root / "images", layout.IMAGES)
        found = [
            {stem[:-2]: path for stem, path in mixed.items() if stem.endswith(f"_{camera}")} for camera in range(count)
        ]
    found = [{stem: path for stem, path in one.items() if stem.isascii() and stem.isdecimal()} for one in found]
    if not found[0]:
        raise FormatError(root, "no pictures", expected="cam0/data/NANOSECONDS.png", fix="Check the layout")
    if count == 1:
        return {name: (path,) for name, path in sorted(found[0].items(), key=lambda item: int(item[0]))}, ()
    common, words = pictures.matched(root, found[0], found[1])
    return {name: (found[0][name], found[1][name]) for name in common}, words


def _cameras(sensors: list[Path], first: tuple[Path, ...]) -> tuple[tuple[Camera, ...], np.ndarray]:
    read = [_read_sensor(path) for path in sensors]
    body_from_left = read[0][1]
    cameras = []
    for (camera, body_from_cam), path in zip(read, first, strict=True):
        pictures.check_size(path, pictures.size_of(path)[::-1], camera)
        cam_from_rig = np.linalg.inv(body_from_cam) @ body_from_left
        cameras.append(Camera(camera.size, camera.intrinsics, camera.model, camera.distortion, cam_from_rig))
    return tuple(cameras), body_from_left


def _read_sensor(path: Path) -> tuple[Camera, np.ndarray]:
    """Camera and T_BS of a sensor.yaml; its few lines are read as they are, without a YAML library."""
    text = _without_comments(path)
    values = partial(_values, path, text)
    pose = _pose(path, text)
    width, height = (int(value) for value in values("resolution", (2,)))
    named = re.search(r"^\s*distortion_model\s*:\s*([\w-]+)", text, flags=re.MULTILINE)
    model = MODELS.get(named[1] if named else "none")
    if model is None:
        raise FormatError(path, "unknown lens", expected=", ".join(MODELS), got=named[1] if named else None)
    coefficients = np.array(values("distortion_coefficients", (4, 5, 8))) if model != "pinhole" else np.zeros(0)
    camera = pictures.camera_of(path, values("intrinsics", (4,)), (width, height), model=model, distortion=coefficients)
    return camera, pose


def _without_comments(path: Path) -> str:
    return "\n".join(line.split("#", 1)[0] for line in layout.read_text(path).splitlines())


def _values(path: Path, text: str, key: str, counts: tuple[int, ...]) -> list[float]:
    found = re.search(rf"^\s*{key}\s*:\s*\[([^\]]*)\]", text, flags=re.MULTILINE)
    numbers = [float(number) for number in re.findall(NUMBER, found[1])] if found else []
    if len(numbers) not in counts or not np.isfinite(numbers).all():
        raise FormatError(
            path, f"no {key}", expected=f"{key}: [{' or '.join(map(str, counts))} numbers]", got=len(numbers)
        )
    return numbers


def _pose(path: Path, text: str) -> np.ndarray:
    """T_BS, body_from_sensor (4, 4)."""
    pose = np.array(_values(path, text, "data", (16,))).reshape(4, 4)
    if not np.allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-3):
        raise FormatError(path, "T_BS is not rigid", fix="Give the 4 x 4 matrix row by row")
    return pose


def _imu(root: Path, body_from_cam: np.ndarray) -> tuple[np.ndarray | None, tuple[Path, ...]]:
    """Samples (m, 7) of imu0: seconds, angular rate and acceleration along the axes of camera 0, where the IMU is."""
    table, sensor = root / "imu0" / "data.csv", root / "imu0" / "sensor.yaml"
    if not table.is_file():
        return None, ()
    rows = [layout.numbers(table, n, text.split(","), (7,)) for n, text in layout.comment_free(table)]
    values = np.array(rows).reshape(-1, 7)
    if not np.isfinite(values).all():
        raise FormatError(table, "a sample is not finite", fix="Leave its line out")
    body_from_imu = _pose(sensor, _without_comments(sensor)) if sensor.is_file() else np.eye(4)
    turn = body_from_cam[:3, :3].T @ body_from_imu[:3, :3]
    samples = np.concatenate([values[:, :1] * 1e-9, values[:, 1:4] @ turn.T, values[:, 4:] @ turn.T], axis=1)
    return samples, (table, sensor) if sensor.is_file() else (table,)


def _truth(root: Path, times: np.ndarray, body_from_cam: np.ndarray) -> tuple[np.ndarray | None, tuple[Path, ...]]:
    """world_from_rig at the times of the frames, NaN where the truth has a gap."""
    table, ready = root / "state_groundtruth_estimate0" / "data.csv", root / "gt_cam0.tum"
    if ready.is_file():
        return trajectories.at_times(*trajectories.read_tum(ready), times, 1e9 if len(times) < 2 else GAP), (ready,)
    if not table.is_file():
        return None, ()
    rows = [layout.numbers(table, n, text.split(","), (8, 17)) for n, text in layout.comment_free(table)]
    values = np.array([row[:8] for row in rows]).reshape(-1, 8)
    stamps, poses = values[:, 0] * 1e-9, _poses(values)
    return trajectories.at_times(stamps, poses @ body_from_cam, times, GAP), (table,)


def _poses(values: np.ndarray) -> np.ndarray:
    """world_from_body (n, 4, 4) of rows time, position, quaternion w x y z."""
    from scipy.spatial.transform import Rotation

    poses = np.tile(np.eye(4), (len(values), 1, 1))
    poses[:, :3, :3] = Rotation.from_quat(values[:, [5, 6, 7, 4]]).as_matrix()
    poses[:, :3, 3] = values[:, 1:4]
    return poses
