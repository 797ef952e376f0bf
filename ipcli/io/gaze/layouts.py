"""The layouts of head-mounted recordings that are read: a `recording` artefact, or the folder of a data set."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ipcli.io.gaze import aria, artefact, boof, euroc, kitti, rgbd
from ipcli.io.sources import Layout, open_source
from ipcli.measurements.recording import HeadRecording

LAYOUTS: dict[str, Layout[HeadRecording]] = {
    "recording": Layout(artefact.is_recording, artefact.read_recording, "an HDF5 recording artefact"),
    "euroc": Layout(euroc.is_euroc, euroc.open_euroc, "mav0/cam0/sensor.yaml or cam0_sensor.yaml"),
    "kitti": Layout(kitti.is_kitti, kitti.open_kitti, "image_0/, image_1/ (or image_l/, image_r/) and calib.txt"),
    "aria": Layout(aria.is_aria, aria.open_aria, "an export of Project Aria: calib.json and slam-front-*_NS.png"),
    "vrs": Layout(aria.is_vrs, aria.open_vrs, "a .vrs file, to be exported first"),
    "boofcv": Layout(boof.is_boof, boof.open_boof, "left/, right/ and stereo_params.xml"),
    "tum": Layout(rgbd.is_tum, rgbd.open_tum, "rgb.txt and depth.txt"),
    "7scenes": Layout(rgbd.is_seven_scenes, rgbd.open_seven_scenes, "frame-XXXXXX.color.png and .depth.png"),
}


def open_recording(path: Path, format: str = "auto", **hints: Any) -> HeadRecording:
    """The recording at `path`, its frames read only when asked for. Raises what `io.sources.open_source` raises."""
    fix = "Rename the files to one of these layouts"
    return open_source(path, LAYOUTS, "recordings", fix, format, **hints)
