"""A generated room seen by a head-mounted stereo rig, with gaze on known targets: truth for tests and experiments.

A box with smaller boxes in it, all covered by noise of several scales, ray cast in closed form. The wearer walks on a
smooth loop and looks at one target after the other; eyes and head follow at their own pace.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import numpy as np

from ipcli.geometry import lie
from ipcli.io.files import atomic
from ipcli.io.files.images import encode_png
from ipcli.io.gaze.pictures import GREY
from ipcli.measurements.recording import Camera, Frame, Gaze, HeadRecording

ROOM = np.array([[-3.0, -1.4, -2.5], [3.0, 1.4, 2.8]])  # metres; y points down
BOXES = np.array(
    [
        [[-2.6, 0.3, 2.2], [-1.4, 1.4, 2.8]],
        [[1.2, -0.1, 1.8], [2.2, 1.4, 2.6]],
        [[-0.5, 0.6, 2.0], [0.6, 1.4, 2.8]],
        [[-3.0, -0.6, -0.5], [-2.4, 0.4, 0.8]],
        [[2.3, 0.4, -1.2], [3.0, 1.4, 0.4]],
    ]
)
TARGETS = np.array([[-2.0, 0.8, 2.2], [0.0, -0.4, 2.8], [1.7, 0.6, 1.8], [-2.4, -0.1, 0.2], [3.0, -0.3, 1.2]])
NAMES = ("chest", "picture", "cupboard", "shelf", "window")
WAVES = (0.05, 0.11, 0.27, 0.7)  # metres: wavelengths of the noise
BASELINE = 0.11


@dataclass(frozen=True, eq=False)
class Place:
    """A room with boxes in it and what may be looked at there."""

    boxes: np.ndarray = field(default_factory=lambda: BOXES)  # (b, 2, 3) least and greatest corner, metres
    targets: np.ndarray = field(default_factory=lambda: TARGETS)  # (t, 3) metres
    names: tuple[str, ...] = NAMES
    attention: Callable | None = None  # (rng, end, dwell) -> times at which attention turns, and to which target
    tint: np.ndarray | None = None  # (1 + b, 3) colour of the room and of each box, 1 is as grey; None: no colour


@dataclass(frozen=True)
class Course:
    """What is generated."""

    frames: int = 120
    rate: float = 15.0  # frames a second
    gaze_rate: float = 120.0
    width: int = 640
    height: int = 480
    noise: float = 1.0  # degrees: root mean square angle of the gaze's error
    picture_noise: float = 2.0  # grey levels
    dwell: tuple[float, float] = (0.8, 2.0)  # seconds on a target
    dark: tuple[int, int] = (0, 0)  # frames without light
    offset: float = 0.0  # pixels: unknown shift of the right camera's principal point
    still: bool = False


@dataclass(frozen=True, eq=False)
class Walk:
    """A recording with all its truth."""

    recording: HeadRecording
    looked_at: np.ndarray  # (n,) target of each gaze sample
    keyframes: np.ndarray  # frames with which attention turns to another target
    depth: Callable[[int], np.ndarray]  # true depth (h, w) of the left camera


def walk(course: Course, seed: int, place: Place | None = None) -> Walk:
    """The same bytes for the same course, seed and place."""
    place = Place() if place is None else place
    rng = np.random.default_rng(seed)
    times = np.arange(course.frames) / course.rate
    gaze_times = np.arange(0.0, times[-1] + 1e-9, 1 / course.gaze_rate) + 1e-4
    turning = place.attention or _attention
    switches, order = turning(rng, times[-1], course.dwell)
    at = np.searchsorted(switches, gaze_times, side="right") - 1
    pose_at = _head(rng, switches, place.targets[order], times[-1], course.still)
    cameras = _cameras(course)
    truth = np.stack([pose_at(time) for time in times])
    gaze = _gaze(rng, gaze_times, order[at], pose_at, course, place)
    started = np.searchsorted(times, switches[1:])
    keys = np.unique(np.concatenate([[0], started[started < course.frames]]))

    def load(k: int) -> Frame:
        dark = course.dark[0] <= k < course.dark[1]
        own = np.random.default_rng([seed, k])
        images = [_picture(cameras[c], truth[k], course, own, dark, course.offset * c, place) for c in range(2)]
        return Frame(images[0][0], images[1][0], colour=images[0][1])

    recording = HeadRecording(
        tuple(f"{k:05d}" for k in range(course.frames)), times, cameras, load, (), gaze, truth,
        targets=place.targets, target_names=place.names, source="generated room",
    )  # fmt: skip
    return Walk(recording, order[at], keys, lambda k: _cast(cameras[0], truth[k], 0.0, place.boxes)[0])


def _attention(rng: np.random.Generator, end: float, dwell: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """When attention turns (first at 0) and to which target."""
    switches, order = [0.0], [int(rng.integers(len(TARGETS)))]
    while switches[-1] < end:
        switches.append(switches[-1] + rng.uniform(*dwell))
        others = [k for k in range(len(TARGETS)) if k != order[-1]]
        order.append(int(rng.choice(others)))
    return np.array(switches), np.array(order)


def _head(rng, switches: np.ndarray, towards: np.ndarray, end: float, still: bool) -> Callable[[float], np.ndarray]:
    """world_from_rig at any time: a smooth loop; the head turns after the eyes `towards` one place after the next."""
    phase = rng.uniform(0, 2 * np.pi)
    grid = np.arange(-2.0, end + 2.0, 0.01)
    index = np.clip(np.searchsorted(switches, grid, side="right") - 1, 0, len(towards) - 1)
    aims = towards[index]
    kernel = np.exp(-0.5 * (np.arange(-60, 61) / 20.0) ** 2)
    kernel /= kernel.sum()
    padded = np.pad(aims, ((60, 60), (0, 0)), mode="edge")
    smooth = np.stack([np.convolve(padded[:, axis], kernel, mode="valid") for axis in range(3)], axis=1)

    def pose(time: float) -> np.ndarray:
        t = 0.0 if still else time
        centre = np.array(
            [0.6 * np.sin(0.5 * t + phase), 0.05 * np.sin(5.0 * t), -0.4 + 0.4 * np.sin(0.31 * t + phase)]
        )
        aim = towards[0] if still else np.array([np.interp(time, grid, smooth[:, axis]) for axis in range(3)])
        ahead = np.array([0.0, 0.0, 2.5])
        direction = 0.75 * (aim - centre) / np.linalg.norm(aim - centre) + 0.25 * ahead / np.linalg.norm(ahead)
        z = direction / np.linalg.norm(direction)
        x = np.cross([0.0, 1.0, 0.0], z)
        x /= np.linalg.norm(x)
        out = np.eye(4)
        out[:3, :3], out[:3, 3] = np.stack([x, np.cross(z, x), z], axis=1), centre
        return out

    return pose


def _cameras(course: Course) -> tuple[Camera, Camera]:
    focal = 0.62 * course.width
    k = np.array([[focal, 0, course.width / 2 - 0.5], [0, focal, course.height / 2 - 0.5], [0, 0, 1]])
    right = np.eye(4)
    right[0, 3] = -BASELINE
    lens = np.array([-0.12, 0.03, 0.0005, -0.0003])
    size = (course.width, course.height)
    return (Camera(size, k, "radtan", lens), Camera(size, k, "radtan", lens, right))


def _gaze(rng, times: np.ndarray, looked_at: np.ndarray, pose_at, course: Course, place: Place) -> Gaze:
    """Pixels of the gaze in camera 0; its error is spread alike to all sides."""
    from ipcli.geometry import lens

    camera = _cameras(course)[0]
    sigma = np.radians(course.noise) / np.sqrt(2)
    pixels = np.empty((len(times), 2))
    for n, (time, target) in enumerate(zip(times, looked_at, strict=True)):
        seen = lie.se3_inverse(pose_at(time)) @ np.append(place.targets[target], 1.0)
        ray = seen[:3] / np.linalg.norm(seen[:3])
        side = np.cross(ray, [0.0, 1.0, 0.0])
        side /= np.linalg.norm(side)
        turn = rng.normal(0, sigma, 2)
        off = lie.exp(turn[0] * side + turn[1] * np.cross(ray, side)) @ ray
        ideal = off[:2] / off[2]
        pixels[n] = lens.pixels_of(lens.distort(camera.model, camera.distortion, ideal), camera.intrinsics)
    inside = np.asarray(np.logical_and(pixels > 0, pixels < np.array(camera.size) - 1).all(axis=1))
    return Gaze(times, pixels, inside, labels=np.array(place.names)[looked_at], source="generated")


def _picture(
    camera: Camera, world_from_rig, course: Course, rng, dark: bool, offset: float, place: Place
) -> tuple[np.ndarray, np.ndarray | None]:
    """Grey picture (h, w), and the one with colours (h, w, 3) where the place has some."""
    if dark:
        return np.full((course.height, course.width), 3, np.uint8), None
    _, points, face = _cast(camera, world_from_rig, offset, place.boxes)
    grey = 120 + 95 * _noise(points) + 6 * np.cos(1.7 * face)
    noisy = grey + rng.normal(0, course.picture_noise, grey.shape)
    if place.tint is None:
        return np.clip(np.rint(noisy), 0, 255).astype(np.uint8), None
    colour = np.clip(np.rint(noisy[..., None] * place.tint[face // 6]), 0, 255).astype(np.uint8)
    return np.rint(colour @ GREY).astype(np.uint8), colour


def _cast(
    camera: Camera, world_from_rig: np.ndarray, offset: float, boxes: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Depth (h, w), world points (h, w, 3) and face numbers of what each pixel sees."""
    world_from_cam = world_from_rig @ np.linalg.inv(camera.cam_from_rig)
    ideal = _ideal(camera.size, camera.model, camera.intrinsics.tobytes(), camera.distortion.tobytes(), offset)
    rays = ideal @ world_from_cam[:3, :3].T
    origin = world_from_cam[:3, 3]
    length, face = meet(origin, rays, boxes)
    return length, origin + length[..., None] * rays, face


def meet(origins: np.ndarray, rays: np.ndarray, boxes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How far rays (..., 3) go until they meet the room or a box, in lengths of theirs, and the face that they meet."""
    with np.errstate(divide="ignore", invalid="ignore"):
        length, face = _inside(origins, rays)
        for number, box in enumerate(boxes, start=1):
            near, side = _outside(origins, rays, box)
            closer = near < length
            length, face = np.where(closer, near, length), np.where(closer, 6 * number + side, face)
    return length, face


@cache
def _ideal(size, model: str, intrinsics: bytes, distortion: bytes, offset: float) -> np.ndarray:
    from ipcli.geometry import lens

    v, u = np.indices((size[1], size[0]), dtype=np.float64)
    pixels = np.stack([u - offset, v], axis=-1)
    k = np.frombuffer(intrinsics).reshape(3, 3)
    flat = lens.undistort(model, np.frombuffer(distortion), lens.normalised_of(pixels, k))
    return np.concatenate([flat, np.ones((*flat.shape[:2], 1))], axis=-1)


def _inside(origin: np.ndarray, rays: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where rays leave the room."""
    far = np.where(rays > 0, (ROOM[1] - origin) / rays, (ROOM[0] - origin) / rays)
    axis = far.argmin(axis=-1)
    return _least(far), 2 * axis + (np.take_along_axis(rays, axis[..., None], -1)[..., 0] > 0)


def _outside(origin: np.ndarray, rays: np.ndarray, box: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where rays enter a box; infinite when they miss it."""
    a, b = (box[0] - origin) / rays, (box[1] - origin) / rays
    near, far = np.minimum(a, b), np.maximum(a, b)
    enter = -_least(-near)
    return np.where((enter < _least(far)) & (enter > 0), enter, np.inf), near.argmax(axis=-1)


def _least(values: np.ndarray) -> np.ndarray:
    """The least of x, y and z: several times as quick as min over an axis of three."""
    return np.minimum(np.minimum(values[..., 0], values[..., 1]), values[..., 2])


@cache
def _lattice() -> np.ndarray:
    return np.random.default_rng(7).uniform(-1, 1, (len(WAVES), 32, 32, 32)).astype(np.float32)


def _noise(points: np.ndarray) -> np.ndarray:
    """Smooth noise in [-1, 1] of several scales, fixed to the world."""
    from scipy.ndimage import map_coordinates

    total = np.zeros(points.shape[:-1])
    for wave, lattice in zip(WAVES, _lattice(), strict=True):
        at = np.moveaxis(points / wave + 100.5, -1, 0)
        total += map_coordinates(lattice, at, order=1, mode="grid-wrap") / len(WAVES) ** 0.5
    return np.clip(total, -1, 1)


def write_euroc(walked: Walk, folder: Path, *, jpeg: int | None = None) -> None:
    """The recording as an EuRoC folder with gaze.csv and targets.csv."""
    recording = walked.recording
    stamps = [int(round(time * 1e9)) + 1_000_000_000 for time in recording.times]
    for camera in range(2):
        _write_sensor(folder / f"cam{camera}_sensor.yaml", recording.cameras[camera])
    for k, stamp in enumerate(stamps):
        frame = recording.load(k)
        for camera, image in enumerate((frame.left if frame.colour is None else frame.colour, frame.right)):
            assert image is not None
            _write_picture(folder / f"cam{camera}" / str(stamp), image, jpeg)
    from ipcli.io.gaze.trajectories import write_tum

    gaze, truth = recording.gaze, recording.truth
    assert gaze is not None
    assert gaze.labels is not None
    assert truth is not None
    assert recording.targets is not None
    path = write_tum(np.array(stamps) * 1e-9, truth, "generated room: world_from_cam0")
    atomic.write_text(folder / "gt_cam0.tum", path)
    lines = ["time [s],x [px],y [px],valid,label"]
    lines += [
        f"{time + 1:.6f},{x:.3f},{y:.3f},{int(valid)},{label}"
        for time, (x, y), valid, label in zip(gaze.times, gaze.pixels, gaze.valid, gaze.labels, strict=True)
    ]
    atomic.write_text(folder / "gaze.csv", "\n".join(lines) + "\n")
    places = [
        f"{name},{x:g},{y:g},{z:g}" for name, (x, y, z) in zip(recording.target_names, recording.targets, strict=True)
    ]
    atomic.write_text(folder / "targets.csv", "\n".join(["name,x [m],y [m],z [m]", *places]) + "\n")


def _write_picture(stem: Path, image: np.ndarray, jpeg: int | None) -> None:
    if jpeg is None:
        atomic.write_bytes(stem.with_suffix(".png"), encode_png(image))
        return
    import cv2

    ordered = image if image.ndim == 2 else np.ascontiguousarray(image[..., ::-1])  # OpenCV takes BGR
    data = cv2.imencode(".jpg", ordered, [cv2.IMWRITE_JPEG_QUALITY, jpeg])[1]
    atomic.write_bytes(stem.with_suffix(".jpg"), data.tobytes())


def _write_sensor(path: Path, camera: Camera) -> None:
    body_from_cam = np.linalg.inv(camera.cam_from_rig)
    k = camera.intrinsics
    lines = [
        "sensor_type: camera",
        "T_BS:",
        f"  data: [{', '.join(f'{value:.12g}' for value in body_from_cam.ravel())}]",
        f"resolution: [{camera.size[0]}, {camera.size[1]}]",
        f"intrinsics: [{k[0, 0]:.9g}, {k[1, 1]:.9g}, {k[0, 2]:.9g}, {k[1, 2]:.9g}]",
        "distortion_model: radial-tangential",
        f"distortion_coefficients: [{', '.join(f'{value:.9g}' for value in camera.distortion)}]",
    ]
    atomic.write_text(path, "\n".join(lines) + "\n")


def main() -> None:
    """`python -m experiments.gaze.room --seed 1 FOLDER`."""
    import argparse

    parser = argparse.ArgumentParser(description="Write a generated room as an EuRoC folder with gaze and targets.")
    parser.add_argument("folder", type=Path)
    for name, default in (("seed", 1), ("frames", 120), ("width", 640), ("height", 480)):
        parser.add_argument(f"--{name}", type=int, default=default)
    given = parser.parse_args()
    write_euroc(walk(Course(given.frames, width=given.width, height=given.height), given.seed), given.folder)


if __name__ == "__main__":
    main()
