"""The layouts of depth views that are read: an HDF5 `views` artefact, or the folder of a data set."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ipcli.io.sources import Layout, open_source
from ipcli.io.views import artefact, colmap, folder, rgbd
from ipcli.measurements.views import Views

LAYOUTS: dict[str, Layout[Views]] = {
    "views": Layout(Path.is_file, artefact.read_views, "an HDF5 views artefact"),
    "colmap": Layout(colmap.is_colmap, colmap.open_colmap, "sparse/ and stereo/depth_maps/"),
    "tum": Layout(rgbd.is_tum, rgbd.open_tum, "depth.txt and groundtruth.txt"),
    "7scenes": Layout(rgbd.is_seven_scenes, rgbd.open_seven_scenes, "frame-XXXXXX.depth.png and .pose.txt"),
    "open3d": Layout(rgbd.is_open3d, rgbd.open_open3d, "depth/ and a trajectory .log"),
    "folder": Layout(folder.is_folder, folder.open_folder, "depth/ and poses.txt"),
}


def open_views(path: Path, format: str = "auto", **hints: Any) -> Views:
    """The views at `path`, each read only when asked for. Raises what `io.sources.open_source` raises."""
    fix = "Rename the files to one of these, or import them with kitti-views"
    return open_source(path, LAYOUTS, "views", fix, format, **hints)
