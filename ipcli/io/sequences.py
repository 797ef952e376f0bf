"""Any source of depth views as one Sequence: an HDF5 `views` artefact or a folder in one of the known layouts."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ipcli.errors import FormatError, ParameterError, nearest
from ipcli.geometry.cameras import Sequence, View, check
from ipcli.io import colmap, folder, rgbd

PICTURES = ("image", "truth")
PER_VIEW = ("depth", "intrinsics", "cam_from_world", "confidence", *PICTURES)


@dataclass(frozen=True)
class Layout:
    """A known source: how to tell it, how to open it, and what it looks like in words."""

    recognise: Callable[[Path], bool]
    open: Callable[..., Sequence]
    looks_like: str


def open(path: Path, format: str = "auto", **hints: Any) -> Sequence:
    """The views at ``path``, lazily. ``format`` is a key of LAYOUTS or "auto"; hints that are None count as not given.

    Raises FormatError when no layout fits (listing what was looked for), and ParameterError for an unknown format or a
    hint that the layout has no use for.
    """
    path = Path(path)
    if not path.exists():
        raise FormatError(path, "no such file or folder", fix="Check the path")
    layout = _layout(path, format)
    given = {key: value for key, value in hints.items() if value is not None}
    known = [name for name, item in inspect.signature(layout.open).parameters.items() if item.kind is item.KEYWORD_ONLY]
    if unknown := [key for key in given if key not in known]:
        takes = ", ".join(known) or "no hints"
        raise ParameterError(f"{path}: '{unknown[0]}' means nothing to {layout.looks_like}; that takes {takes}")
    return layout.open(path, **given)


def open_views(path: Path) -> Sequence:
    """The sequence in a `views` artefact."""
    from ipcli.io import h5

    fields = h5.names(path)
    shared = h5.read(path, "views", only=lambda field: not field.startswith("views/")).arrays
    names = tuple(sorted({field.split("/")[1] for field in fields if field.startswith("views/")}))
    baseline_focal = float(shared["baseline_focal"]) if "baseline_focal" in shared else None

    def load(name: str, pictures: bool = True) -> View:
        prefix = f"views/{name}/"
        wanted = [prefix + field for field in PER_VIEW if pictures or field not in PICTURES]
        arrays = h5.read(path, "views", only=lambda field: field in wanted).arrays
        return check(View(name, **{field.removeprefix(prefix): array for field, array in arrays.items()}), path)

    return Sequence(names, str(shared["unit"]), str(shared["measured"]), baseline_focal, load, lambda name: (path,))


def views_artefact(
    views: Iterable[View], *, unit: str, measured: str, baseline_focal: float | None = None
) -> dict[str, np.ndarray]:
    """The fields of a `views` artefact that holds these views."""
    arrays: dict[str, np.ndarray] = {"unit": np.array(unit), "measured": np.array(measured)}
    if baseline_focal is not None:
        arrays["baseline_focal"] = np.array(baseline_focal, dtype=np.float64)
    for view in views:
        for field in PER_VIEW:
            if (array := getattr(view, field)) is not None:
                arrays[f"views/{view.name}/{field}"] = np.ascontiguousarray(array)
    return arrays


def _layout(path: Path, format: str) -> Layout:
    if format == "auto":
        for layout in LAYOUTS.values():
            if layout.recognise(path):
                return layout
        looked_for = "; ".join(f"{name}: {layout.looks_like}" for name, layout in LAYOUTS.items())
        raise FormatError(
            path,
            f"no known layout of views. Looked for {looked_for}",
            fix="Rename the files to one of these, or import them with kitti-views",
        )
    if format not in LAYOUTS:
        raise ParameterError(f"unknown format '{format}'{nearest(format, LAYOUTS)} Known: auto, {', '.join(LAYOUTS)}")
    return LAYOUTS[format]


LAYOUTS = {  # in the order in which they are tried: the more particular first
    "views": Layout(Path.is_file, open_views, "an HDF5 views artefact"),
    "colmap": Layout(colmap.is_colmap, colmap.open_colmap, "sparse/ and stereo/depth_maps/"),
    "tum": Layout(rgbd.is_tum, rgbd.open_tum, "depth.txt and groundtruth.txt"),
    "7scenes": Layout(rgbd.is_seven_scenes, rgbd.open_seven_scenes, "frame-XXXXXX.depth.png and .pose.txt"),
    "open3d": Layout(rgbd.is_open3d, rgbd.open_open3d, "depth/ and a trajectory .log"),
    "folder": Layout(folder.is_folder, folder.open_folder, "depth/ and poses.txt"),
}
