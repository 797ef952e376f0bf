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
    "scannet": Layout(rgbd.is_scannet, rgbd.open_scannet, "depth/, pose/N.txt and intrinsic/intrinsic_depth.txt"),
    "open3d": Layout(rgbd.is_open3d, rgbd.open_open3d, "depth/ and a trajectory .log"),
    "folder": Layout(folder.is_folder, folder.open_folder, "depth/ and poses.txt"),
}


def open_views(path: Path, format: str = "auto", **hints: Any) -> Views:
    """The views at `path`, each read only when asked for. Raises what `io.sources.open_source` raises."""
    return open_source(path, LAYOUTS, "views", advice(Path(path)), format, **hints)


PARTS = {  # what a folder of each layout has
    "a plain folder": ("depth", "poses.txt", "intrinsics.txt"),
    "an Open3D folder": ("depth", "*.log"),
    "a ScanNet scene": ("depth", "pose", rgbd.SCANNET_CAMERA),
    "a TUM recording": ("depth.txt", "groundtruth.txt"),
    "a COLMAP dense workspace": ("sparse", "stereo"),
    "a 7-Scenes recording": ("frame-*.depth.png", "frame-*.pose.txt"),
}


def advice(path: Path) -> str:
    """What to do with a folder that is no known layout: the nearest one and what it lacks."""

    def missing(parts: tuple[str, ...]) -> list[str]:
        return [part for part in parts if not any(path.glob(part))]

    lacks = {name: missing(parts) for name, parts in PARTS.items()} if path.is_dir() else {}
    near = [name for name, parts in PARTS.items() if name in lacks and 0 < len(lacks[name]) < len(parts)]
    if not near:
        return "Rename the files to one of these, or import them with kitti-views"
    best = min(near, key=lambda name: len(lacks[name]) / len(PARTS[name]))
    return f"It is most like {best}, but lacks {' and '.join(lacks[best])}: add that"
