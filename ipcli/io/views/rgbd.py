"""RGB-D recordings in metres: the layouts of the TUM benchmark, of Open3D and ICL-NUIM, and of 7-Scenes."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from collections.abc import Sequence as Ordered
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ipcli.errors import FormatError, ParameterError
from ipcli.inputs import json_of
from ipcli.io.files import text
from ipcli.io.files.images import read_depth
from ipcli.measurements.names import natural
from ipcli.measurements.views import View, Views, check_view

PRIMESENSE = (525.0, 525.0, 319.5, 239.5)  # also the default of ROS, for 640 x 480
SEVEN_SCENES = (585.0, 585.0, 320.0, 240.0)  # the depth camera, as the data set's page gives it
# Sturm et al., A benchmark for the evaluation of RGB-D SLAM systems (IROS 2012): colour cameras, with depth registered
# to them
FREIBURG = {
    "freiburg1": (517.3, 516.5, 318.6, 255.3),
    "freiburg2": (520.9, 521.0, 325.1, 249.7),
    "freiburg3": (535.4, 539.2, 320.1, 247.6),
}
MILLIMETRES = 1000.0
TUM_SCALE = 5000.0
OPEN3D_CAMERAS = ("camera_intrinsic.json", "intrinsic.json", "camera.json")
SCANNET_CAMERA = "intrinsic/intrinsic_depth.txt"


@dataclass(frozen=True, eq=False)
class _Frame:
    depth: Path
    image: Path | None
    pose: Path  # the file with the pose
    world_from_cam: np.ndarray | None = None  # None when that file is of this frame alone, to be read with it


def is_tum(folder: Path) -> bool:
    """Whether the folder has the index files of the TUM benchmark."""
    return (folder / "depth.txt").is_file() and (folder / "groundtruth.txt").is_file()


def is_open3d(folder: Path) -> bool:
    """Whether the folder has depth images and a trajectory in the way of Open3D's reconstruction system."""
    return (folder / "depth").is_dir() and any(folder.glob("*.log"))


def is_seven_scenes(folder: Path) -> bool:
    """Whether the folder holds frame-XXXXXX.depth.png beside frame-XXXXXX.pose.txt."""
    return any(folder.glob("frame-*.depth.png")) and any(folder.glob("frame-*.pose.txt"))


def open_tum(
    folder: Path, *, intrinsics: Ordered[float] | None = None, depth_scale: float = TUM_SCALE, max_gap: float = 0.02
) -> Views:
    """A TUM recording: the depth images that have a pose within ``max_gap`` seconds, with the nearest colour.

    ``groundtruth.txt`` holds ``time tx ty tz qx qy qz qw``, camera to world. Intrinsics (fx, fy, cx, cy) follow from a
    folder name with ``freiburg1`` to ``3`` in it, and must be given otherwise. Raises FormatError when nothing can be
    associated.
    """
    depth, images = _tum_index(folder / "depth.txt"), _tum_index(folder / "rgb.txt", optional=True)
    pose_file = folder / "groundtruth.txt"
    poses = {time: _pose_from_quaternion(pose_file, line, values) for time, line, values in _tum_poses(pose_file)}
    frames = {}
    for time, path in depth.items():
        posed, seen = _nearest(poses, time, max_gap), _nearest(images, time, max_gap)
        if posed is not None:
            image = None if seen is None else images[seen]
            frames[path.stem] = _Frame(path, image, pose_file, poses[posed])
    left = len(depth) - len(frames)
    if not frames:
        raise FormatError(
            pose_file,
            f"none of {len(depth)} depth images has a pose within {max_gap:g} s",
            fix="Check that both use the same clock, or raise max_gap",
        )
    camera = intrinsics or _freiburg(folder)
    note = f"{left} of {len(depth)} depth images left out: no pose within {max_gap:g} s (--set source.max_gap=SECONDS)"
    return _sequence(folder, frames, text.camera_matrix(camera), depth_scale, (note,) if left else ())


def open_open3d(
    folder: Path,
    *,
    intrinsics: Ordered[float] | None = None,
    depth_scale: float = MILLIMETRES,
    trajectory: str | None = None,
) -> Views:
    """A folder of Open3D's reconstruction system: depth/, image/ or color/ or rgb/, and a trajectory.

    The k-th pose of the trajectory (camera to world) belongs to the k-th depth image when there are as many of each;
    otherwise the number in the file name picks the pose. The trajectory is trajectory.log or the only .log there is.
    Intrinsics are those of camera_intrinsic.json, if it is there, else PrimeSense's, which hold for 640 x 480 only.
    """
    depths = text.by_stem(folder / "depth", (".png",))
    images = next(
        (found for name in ("image", "color", "rgb") if (found := text.by_stem(folder / name, text.IMAGES))), {}
    )
    pose_file = folder / trajectory if trajectory else _trajectory(folder)
    poses = text.read_trajectory_log(pose_file)
    frames = {}
    for (stem, name), pose in zip(_padded(depths).items(), _matched(folder, depths, poses), strict=True):
        frames[name] = _Frame(depths[stem], images.get(stem), pose_file, pose)
    own = next((folder / name for name in OPEN3D_CAMERAS if (folder / name).is_file()), None)
    if intrinsics is None and own and frames:
        return _sequence(folder, frames, _open3d_camera(own, next(iter(frames.values())).depth), depth_scale)
    if intrinsics is None and frames:
        _require_vga(next(iter(frames.values())).depth)
    return _sequence(folder, frames, text.camera_matrix(intrinsics or PRIMESENSE), depth_scale)


def open_seven_scenes(
    folder: Path, *, intrinsics: Ordered[float] | None = None, depth_scale: float = MILLIMETRES
) -> Views:
    """A 7-Scenes recording: frame-XXXXXX.depth.png, .color.png or .jpg, .pose.txt (camera to world).

    Depth 0 and 65535 are missing. Intrinsics are those of ``camera-intrinsics.txt`` if it is there, else the data set's
    default.
    """
    frames = {}
    for depth in sorted(folder.glob("frame-*.depth.png")):
        name = depth.name.removesuffix(".depth.png")
        images = (folder / f"{name}.color{suffix}" for suffix in text.IMAGES)
        frames[name] = _Frame(
            depth, next((path for path in images if path.is_file()), None), folder / f"{name}.pose.txt"
        )
    own = folder / "camera-intrinsics.txt"
    if intrinsics is None and own.is_file():
        return _sequence(folder, frames, text.read_matrix(own, (3, 3)), depth_scale)
    return _sequence(folder, frames, text.camera_matrix(intrinsics or SEVEN_SCENES), depth_scale)


def _trajectory(folder: Path) -> Path:
    """trajectory.log, or the only .log file; FormatError when there are several."""
    logs = sorted(folder.glob("*.log"))
    if folder / "trajectory.log" in logs or len(logs) == 1:
        return folder / "trajectory.log" if len(logs) > 1 else logs[0]
    fix = "Name it: --set source.trajectory=FILE.log"
    raise FormatError(folder, "which .log is the trajectory?", got=", ".join(path.name for path in logs), fix=fix)


def _open3d_camera(path: Path, depth: Path) -> np.ndarray:
    """The camera matrix of Open3D's JSON, column by column there; FormatError when it is of another image size."""
    fix = "Give the camera of the depth images as --intrinsics fx,fy,cx,cy"
    try:
        given = json_of(text.read_text(path))
        matrix = np.array(given["intrinsic_matrix"], np.float64).reshape(3, 3).T
        size = (int(given["width"]), int(given["height"]))
    except (ValueError, KeyError, TypeError, OverflowError) as error:
        raise FormatError(path, f"not a camera of Open3D: {' '.join(str(error).split())}", fix=fix) from None
    height, width = read_depth(depth, MILLIMETRES).shape
    if size != (width, height):
        raise FormatError(path, "camera of another image size", expected=f"{width} x {height}", got=size, fix=fix)
    return matrix


def is_scannet(folder: Path) -> bool:
    """Whether the folder has depth/N.png, pose/N.txt and intrinsic/intrinsic_depth.txt, as ScanNet is exported."""
    return all((folder / part).exists() for part in ("depth", "pose", SCANNET_CAMERA))


def open_scannet(folder: Path, *, intrinsics: Ordered[float] | None = None, depth_scale: float = MILLIMETRES) -> Views:
    """A ScanNet scene as exported: poses are camera to world; frames whose pose is unknown (-inf) are left out."""
    depths = text.by_stem(folder / "depth", (".png",))
    poses = text.by_stem(folder / "pose", (".txt",))
    images = text.by_stem(folder / "color", text.IMAGES)
    frames, padded = {}, _padded(depths)
    for stem, name in padded.items():
        if stem in poses and np.isfinite(text.read_matrix(poses[stem], (4, 4))).all():
            frames[name] = _Frame(depths[stem], images.get(stem), poses[stem])
    camera = text.camera_matrix(intrinsics) if intrinsics else text.read_camera_matrix(folder / SCANNET_CAMERA)
    left = len(depths) - len(frames)
    note = f"{left} of {len(depths)} depth images left out: no known pose in pose/"
    return _sequence(folder, frames, camera, depth_scale, (note,) if left else ())


def _sequence(
    folder: Path,
    frames: Mapping[str, _Frame],
    intrinsics: np.ndarray,
    depth_scale: float,
    notes: tuple[str, ...] = (),
) -> Views:
    if not frames:
        raise FormatError(text.require_folder(folder), "no depth images", fix="Check the layout of the folder")
    if not depth_scale > 0:
        raise ParameterError(f"{folder}: depth_scale = {depth_scale!r}: expected a number > 0")

    def load(name: str, pictures: bool = True) -> View:
        frame = frames[name]
        depth = read_depth(frame.depth, depth_scale)
        world_from_cam = text.read_matrix(frame.pose, (4, 4)) if frame.world_from_cam is None else frame.world_from_cam
        cam_from_world = text.inverse(frame.pose, world_from_cam)
        image = text.image_at(frame.image if pictures else None, depth.shape)
        return check_view(View(name, depth, intrinsics, cam_from_world, image=image), frame.pose)

    def files(name: str) -> tuple[Path, ...]:
        frame = frames[name]
        return tuple(path for path in (frame.depth, frame.image, frame.pose) if path is not None)

    return Views(tuple(sorted(frames, key=natural)), "m", "depth", None, load, files, notes)


def _tum_index(path: Path, optional: bool = False) -> dict[float, Path]:
    """Time in seconds to file, from lines ``time path``."""
    if optional and not path.is_file():
        return {}
    entries = {}
    for line, content in text.comment_free(path):
        time, *rest = content.replace(",", " ", 1).split(maxsplit=1)
        if not rest:
            raise FormatError(
                path, f"line {line} is cut", expected="a time and a file name", got=content, fix="Check that line"
            )
        name = rest[0]
        entries[float(text.numbers(path, line, [time], [1])[0])] = path.parent / name.strip()
    return entries


def _tum_poses(path: Path) -> list[tuple[float, int, np.ndarray]]:
    rows = [(line, text.numbers(path, line, text.words(content), [8])) for line, content in text.comment_free(path)]
    return [(float(values[0]), line, values[1:]) for line, values in rows]


def _pose_from_quaternion(path: Path, line: int, values: np.ndarray) -> np.ndarray:
    """(4, 4) from tx ty tz qx qy qz qw."""
    x, y, z, w = values[3:]
    norm = np.linalg.norm(values[3:])
    if not abs(norm - 1) < 0.01:  # also catches NaN
        raise FormatError(
            path,
            f"line {line} has no unit quaternion",
            expected="|q| = 1",
            got=f"{norm:.3g}",
            fix="Order: tx ty tz qx qy qz qw",
        )
    x, y, z, w = values[3:] / norm
    pose = np.eye(4)
    pose[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    pose[:3, 3] = values[:3]
    return pose


def _nearest(times: Mapping[float, object], time: float, max_gap: float) -> float | None:
    known = np.fromiter(times, dtype=np.float64)
    if known.size == 0:
        return None
    best = known[np.argmin(np.abs(known - time))]
    return float(best) if abs(best - time) <= max_gap else None


def _freiburg(folder: Path) -> tuple[float, ...]:
    for name, values in FREIBURG.items():
        if name in folder.resolve().name:
            return values
    ros = ",".join(f"{value:g}" for value in PRIMESENSE)
    raise ParameterError(
        f"{folder}: intrinsics unknown, not named freiburg1, 2 or 3. Give fx,fy,cx,cy ({ros} is the ROS default)"
    )


def _padded(stems: Iterable[str]) -> dict[str, str]:
    """Stem to view name in the order of frames: zeros fill numbers to one width, so that names sort that way."""
    stems = list(stems)
    width = max((len(stem) for stem in stems if stem.isdecimal()), default=0)
    names = {stem: stem.zfill(width) if stem.isdecimal() else stem for stem in stems}
    return dict(sorted(names.items(), key=lambda item: item[1]))


def _matched(folder: Path, depths: Mapping[str, Path], poses: Mapping[int, np.ndarray]) -> list[np.ndarray]:
    """The pose of each depth image, in the order of frames."""
    stems = list(_padded(depths))
    if len(stems) == len(poses):
        return [pose for _, pose in sorted(poses.items())]
    numbers = [int((re.findall(r"\d+", stem) or ["-1"])[0]) for stem in stems]
    if missing := [stem for stem, number in zip(stems, numbers, strict=True) if number not in poses]:
        raise FormatError(
            folder,
            f"no pose of {len(missing)} of {len(stems)} depth images, the first is {missing[0]!r}",
            expected=f"a number of the trajectory's {len(poses)} frames",
            fix="Give the trajectory of these frames",
        )
    return [poses[number] for number in numbers]


def _require_vga(path: Path) -> None:
    height, width = read_depth(path, MILLIMETRES).shape
    if (width, height) != (640, 480):
        raise ParameterError(
            f"{path}: intrinsics unknown, the default is for 640 x 480 and this is {width} x {height}. Give fx,fy,cx,cy"
        )
