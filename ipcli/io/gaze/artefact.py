"""Recordings as an HDF5 artefact: pictures as the PNG or JPEG files they were, read frame by frame."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from ipcli.errors import FormatError
from ipcli.io.files import h5
from ipcli.io.files.images import decoded
from ipcli.io.gaze.pictures import check_size, grey
from ipcli.measurements.recording import Camera, Frame, Gaze, HeadRecording


def is_recording(path: Path) -> bool:
    """Whether the file may be such an artefact."""
    return path.is_file() and path.suffix.lower() in (".h5", ".hdf5")


def read_recording(path: Path) -> HeadRecording:
    """The recording in a `recording` artefact."""
    a = h5.read(path, "recording", only=lambda field: not field.startswith("frames/")).arrays
    names = tuple(str(name) for name in a["names"])
    cameras = _cameras(path, a)
    if len(names) == 0 or not (np.diff(a["times"]) > 0).all():
        raise FormatError(path, "frames are not in order of time", expected="ascending times", got=len(names))

    def load(k: int) -> Frame:
        prefix = f"frames/{names[k]}/"
        found = h5.read(path, "recording", only=lambda field: field.startswith(prefix)).arrays
        if f"{prefix}left" not in found:
            raise FormatError(path, f"frame '{names[k]}' has no picture", fix="Import the recording again")
        images = [
            decoded(path, found[prefix + side].tobytes(), as_colour=True)
            for side in ("left", "right")
            if prefix + side in found
        ]
        for image, camera in zip(images, cameras, strict=False):
            check_size(path, image.shape[:2], camera)
        left = grey(images[0])
        colour = None if (images[0][..., 0] == left).all() else images[0]
        return Frame(left, grey(images[1]) if len(images) > 1 else None, found.get(f"{prefix}depth"), colour)

    return HeadRecording(
        names, a["times"], cameras, load, (path,), _gaze(a), a.get("truth"), a.get("imu"), a.get("targets"),
        tuple(str(name) for name in a.get("target_names", ())), str(a["source"]),
    )  # fmt: skip


def _cameras(path: Path, a: dict[str, np.ndarray]) -> tuple[Camera, ...]:
    found = []
    for size, k, model, distortion, pose in zip(
        a["rig/sizes"], a["rig/intrinsics"], a["rig/models"], a["rig/distortion"], a["rig/cam_from_rig"], strict=True
    ):
        known = distortion[np.isfinite(distortion)]
        found.append(Camera((int(size[0]), int(size[1])), k, str(model), known, pose))
    if len(found) not in (1, 2):
        raise FormatError(path, "a rig has one or two cameras", got=len(found))
    return tuple(found)


def _gaze(a: dict[str, np.ndarray]) -> Gaze | None:
    if "gaze/times" not in a:
        return None
    return Gaze(
        a["gaze/times"], a["gaze/pixels"], a["gaze/valid"].astype(bool), a.get("gaze/directions"),
        a.get("gaze/origins"), a.get("gaze/labels"), "recording",
    )  # fmt: skip


def recording_arrays(
    recording: HeadRecording, encoded: Callable[[int], dict[str, np.ndarray]]
) -> dict[str, np.ndarray]:
    """The fields of a `recording` artefact, rig and gaze apart; `encoded` gives the files of a frame's pictures."""
    arrays: dict[str, np.ndarray] = {
        "names": np.array(recording.names),
        "times": np.asarray(recording.times, np.float64),
        "source": np.array(recording.source),
    }
    for k, name in enumerate(recording.names):
        arrays |= {f"frames/{name}/{field}": value for field, value in encoded(k).items()}
    for field in ("truth", "targets", "imu"):
        if getattr(recording, field) is not None:
            arrays[field] = np.asarray(getattr(recording, field), np.float64)
    if recording.target_names:
        arrays["target_names"] = np.array(recording.target_names)
    return arrays
