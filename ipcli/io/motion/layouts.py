"""The layouts of motion that are read: a `clips` artefact, motion files alone, in a folder or archive, Kinect sets."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ipcli.io.motion import artefact, kinect, recordings
from ipcli.io.sources import Layout, open_source
from ipcli.measurements.motions import Clips

FLORENCE = "a folder with skeletal_data.mat and action_names.mat"
UTKINECT = "a folder or archive with joints_s01_e01.txt and actionLabel.txt"
LAYOUTS: dict[str, Layout[Clips]] = {
    "clips": Layout(lambda path: path.suffix in (".h5", ".hdf5"), artefact.read_clips, "an HDF5 clips artefact"),
    "florence3d": Layout(kinect.is_florence, kinect.open_florence, FLORENCE),
    "utkinect": Layout(kinect.is_utkinect, kinect.open_utkinect, UTKINECT),
    "files": Layout(
        recordings.is_recordings,
        recordings.open_recordings,
        f"{', '.join(recordings.READERS)} files, alone or in a folder",
    ),
}


def open_clips(path: Path, format: str = "auto", **hints: Any) -> Clips:
    """The clips at `path`, each read only when asked for. Raises what `io.sources.open_source` raises."""
    return open_source(path, LAYOUTS, "clips", "See docs/motions.md", format, **hints)
