"""What a command needs to be told of a source of views that its files do not say."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ipcli.params import as_dict, option

if TYPE_CHECKING:
    from ipcli.measurements.views import Views


@dataclass(frozen=True)
class Source:
    """Hints; each is refused where the layout has no use for it, and None leaves the layout's own default."""

    format: str = option("auto", "Layout: auto, views, colmap, tum, 7scenes, open3d or folder.", flag="--format")
    unit: str | None = option(None, "Unit of length of a plain folder.", flag="--unit")
    depth_scale: float | None = option(
        None, "Stored value of one unit of depth in 16-bit images.", flag="--depth-scale", low=0.0
    )
    intrinsics: tuple[float, ...] | None = option(None, "fx,fy,cx,cy of all views.", flag="--intrinsics", unit="px")
    pose: str | None = option(
        None, "Direction of poses.txt.", flag="--pose", choices=("cam_from_world", "world_from_cam")
    )
    measured: str | None = option(
        None, "What the files of a plain folder hold.", flag="--measured", choices=("depth", "disparity")
    )
    baseline_focal: float | None = option(
        None, "Turns disparity into depth.", flag="--baseline-focal", low=0.0, unit="px * unit"
    )
    depth: str | None = option(None, "Depth maps of COLMAP to take.", choices=("geometric", "photometric"))
    trajectory: str | None = option(None, "Trajectory file of an Open3D folder.")
    max_gap: float | None = option(None, "Longest time between a depth image and its pose (TUM).", low=0.0, unit="s")


def open_source(path: Path, source: Source) -> Views:
    """The views at ``path``. Raises what io.sequences.open raises."""
    from ipcli.io.views import layouts

    return layouts.open_views(path, **as_dict(source))


def source_files(sequence: Views, names: tuple[str, ...]) -> tuple[Path, ...]:
    """The files that these views are made of, each once."""
    return tuple(dict.fromkeys(file for name in names for file in sequence.files(name)))
