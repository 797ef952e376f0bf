"""A camera without a picture, described in TOML: the pose of one's choice to fuse into."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ipcli import memory
from ipcli.errors import FormatError
from ipcli.inputs import read_toml
from ipcli.io.files.text import camera_matrix
from ipcli.measurements.views import View, check_view

KEYS = {"width": int, "height": int, "intrinsics": list, "cam_from_world": list}
EXAMPLE = "Write width = 640, height = 480, intrinsics = [fx, fy, cx, cy] and cam_from_world = [16 numbers, row by row]"


def read(path: Path) -> View:
    """The camera of a TOML file, named after it, as a view that has seen nothing. Raises FormatError."""
    given = read_toml(path, fix=EXAMPLE)
    if wrong := sorted(given.keys() ^ KEYS.keys()):
        raise FormatError(
            path, f"'{wrong[0]}' is {'not a key of a camera' if wrong[0] in given else 'missing'}", fix=EXAMPLE
        )
    for key, type_ in KEYS.items():
        if not isinstance(given[key], type_):
            raise FormatError(path, f"{key} has the wrong type", expected=type_.__name__, got=given[key], fix=EXAMPLE)
    if min(given["width"], given["height"]) < 2:
        raise FormatError(
            path, "the image has no size", expected="width, height >= 2", got=(given["width"], given["height"])
        )
    pose, values = (_numbers(path, given, key, count) for key, count in (("cam_from_world", 16), ("intrinsics", 4)))
    memory.check(path, 4 * given["width"] * given["height"], f"{given['width']} x {given['height']} pixels")
    nothing = np.full((given["height"], given["width"]), np.nan, np.float32)
    return check_view(View(path.stem, nothing, camera_matrix(values), pose.reshape(4, 4)), path)


def _numbers(path: Path, given: dict, key: str, count: int) -> np.ndarray:
    try:
        values = np.array(given[key], np.float64).ravel()
    except (TypeError, ValueError):
        raise FormatError(path, f"{key} holds something else than numbers", got=given[key], fix=EXAMPLE) from None
    if values.size != count:
        raise FormatError(
            path, f"{key} has the wrong length", expected=f"{count} numbers", got=values.size, fix=EXAMPLE
        )
    return values
