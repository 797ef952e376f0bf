"""A recording and the gaze that goes with it, opened with what a command was told of them."""

from __future__ import annotations

import logging
from dataclasses import replace
from pathlib import Path

import numpy as np

from ipcli.errors import ParameterError
from ipcli.io.gaze import gaze_files, layouts
from ipcli.io.gaze.fixation_targets import read_fixation_targets
from ipcli.measurements.recording import HeadRecording, window
from ipcli.models.gaze.gaze_calibration import calibrated
from ipcli.stages.gaze.parameters import RecordingSource

log = logging.getLogger(__name__)


def open_source(path: Path, source: RecordingSource) -> HeadRecording:
    """The recording with its gaze. Raises what io.gaze.layouts.open_recording and gaze_files.read_gaze raise."""
    found = layouts.open_recording(path, source.format, intrinsics=source.intrinsics, depth_scale=source.depth_scale)
    found = _with_targets(_calibrated(_with_gaze(found, source, path), source), path)
    for words in found.dropped:
        log.warning("%s: %s", path, words)
    count = len(found.names)
    if (source.start, source.stop, source.step) != (0, 0, 1):
        found = window(found, source.start, source.stop, source.step)
    if not found.names:
        raise ParameterError(
            f"{path}: none of its {count} frames lies between --start {source.start} and --stop {source.stop or count}"
        )
    return found


def _with_gaze(found: HeadRecording, source: RecordingSource, beside: Path) -> HeadRecording:
    """Gaze of --gaze, else the recording's own, else of a gaze.csv in its folder."""
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
    path = folder / "targets.csv"
    if found.targets is not None or not path.is_file():
        return found
    names, places = gaze_files.read_targets(path)
    return replace(found, targets=places, target_names=names, files=(*found.files, path))
