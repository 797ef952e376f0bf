"""What a command needs to be told of a recording and of the gaze that goes with it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from ipcli.errors import ParameterError
from ipcli.params import option

if TYPE_CHECKING:
    from ipcli.measurements.recording import HeadRecording


@dataclass(frozen=True)
class RecordingSource:
    """Hints on the recording; None leaves the layout's own default."""

    format: str = option(
        "auto", "Layout: auto, recording, euroc, kitti, aria, boofcv, tum or 7scenes.", flag="--format"
    )
    gaze: str | None = option(None, "Gaze export, a file or its folder; beside or in place of its own.", flag="--gaze")
    gaze_shift: float = option(0.0, "Added to the times of the gaze.", flag="--gaze-shift", unit="s")
    gaze_size: tuple[int, ...] | None = option(
        None, "Width,height of the picture that the gaze was given for, if not the camera's.", flag="--gaze-size", low=1
    )
    intrinsics: tuple[float, ...] | None = option(
        None, "fx,fy,cx,cy of an RGB-D camera.", flag="--intrinsics", unit="px"
    )
    depth_scale: float | None = option(None, "Stored value of one metre of depth.", low=0.0)
    start: int = option(0, "First frame to take.", flag="--start", low=0)
    stop: int = option(0, "Frame to stop before; 0: the end.", flag="--stop", low=0)
    step: int = option(1, "Take every so many-th frame.", flag="--step", low=1)


def open_source(path: Path, source: RecordingSource) -> HeadRecording:
    """The recording with its gaze. Raises what io.gaze.layouts.open_recording and gaze_files.read_gaze raise."""
    from ipcli.io.gaze import layouts
    from ipcli.measurements.recording import window

    found = layouts.open_recording(path, source.format, intrinsics=source.intrinsics, depth_scale=source.depth_scale)
    found = _with_targets(_with_gaze(found, source, path), path)
    if (source.start, source.stop, source.step) != (0, 0, 1):
        found = window(found, source.start, source.stop, source.step)
    if not found.names:
        raise ParameterError(f"{path}: no frame between --start {source.start} and --stop {source.stop}")
    return found


def _with_gaze(found: HeadRecording, source: RecordingSource, beside: Path) -> HeadRecording:
    """Gaze of --gaze, else the recording's own, else of a gaze.csv in its folder."""
    from ipcli.io.gaze import gaze_files

    own = beside / "gaze.csv"
    if source.gaze is None:
        if found.gaze is not None or not own.is_file():
            return found
        source = replace(source, gaze=str(own))
    assert source.gaze is not None
    if source.gaze_size is not None and len(source.gaze_size) != 2:
        raise ParameterError("--gaze-size: expected W,H, two numbers")
    path, camera = Path(source.gaze), found.cameras[0].size
    width, height = source.gaze_size or camera
    gaze = gaze_files.on_clock(gaze_files.read_gaze(path, (width, height)), found.times, source.gaze_shift, path)
    scale = (camera[0] / width, camera[1] / height)
    pixels = (gaze.pixels + 0.5) * scale - 0.5
    files = (path,) if path.is_file() else tuple(sorted(p for p in path.rglob("*") if p.is_file()))
    return replace(found, gaze=replace(gaze, pixels=pixels), files=(*found.files, *files))


def _with_targets(found: HeadRecording, folder: Path) -> HeadRecording:
    """Places of what was looked at, from a targets.csv in the folder: name, x, y, z in the frame of the truth."""
    from ipcli.io.gaze import gaze_files

    path = folder / "targets.csv"
    if found.targets is not None or not path.is_file():
        return found
    names, places = gaze_files.read_targets(path)
    return replace(found, targets=places, target_names=names, files=(*found.files, path))
