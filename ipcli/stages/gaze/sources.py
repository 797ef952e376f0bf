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
    calibrate_gaze: str | None = option(
        None, "Fixation targets (CSV: time [s],x [px],y [px]) that the gaze is corrected by.", flag="--calibrate-gaze"
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
    found = _with_targets(_calibrated(_with_gaze(found, source, path), source), path)
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


def _calibrated(found: HeadRecording, source: RecordingSource) -> HeadRecording:
    """The gaze corrected by the targets of --calibrate-gaze; how good that is goes with what is told of the gaze."""
    import numpy as np

    from ipcli.io.gaze.fixation_targets import read_fixation_targets
    from ipcli.models.gaze.gaze_calibration import calibrated

    if source.calibrate_gaze is None:
        return found
    if found.gaze is None or found.gaze.directions is not None:
        raise ParameterError("--calibrate-gaze: needs gaze in pixels of the picture")
    path, camera = Path(source.calibrate_gaze), found.cameras[0]
    made = calibrated(found.gaze, read_fixation_targets(path), camera.size[0])
    degrees = float(np.degrees(np.arctan(made.error / camera.intrinsics[0, 0])))
    words = (
        f"gaze calibrated on {made.targets} fixation targets ({made.kind}): "
        f"off by {made.before:.2f} px an axis before, by {made.error:.2f} px (about {degrees:.2f} degrees) at "
        "targets left out; --gaze-sigma should not be less"
    )
    gaze = replace(found.gaze, pixels=made.applied(found.gaze.pixels), dropped=(*found.gaze.dropped, words))
    return replace(found, gaze=gaze, files=(*found.files, path))


def _with_targets(found: HeadRecording, folder: Path) -> HeadRecording:
    """Places of what was looked at, from a targets.csv in the folder: name, x, y, z in the frame of the truth."""
    from ipcli.io.gaze import gaze_files

    path = folder / "targets.csv"
    if found.targets is not None or not path.is_file():
        return found
    names, places = gaze_files.read_targets(path)
    return replace(found, targets=places, target_names=names, files=(*found.files, path))
