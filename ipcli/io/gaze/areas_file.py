"""Areas of interest from a table (boxes or polygons) or from a labelled cloud (PLY)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ipcli.errors import FormatError
from ipcli.io.files import ply
from ipcli.io.gaze.gaze_files import AXES, columns_of
from ipcli.measurements.recording import Areas

LOW, HIGH = ("x0 [m]", "y0 [m]", "z0 [m]"), ("x1 [m]", "y1 [m]", "z1 [m]")
LABEL = "label"
MOST = 1000  # labels of a cloud


def read_areas(path: Path) -> Areas:
    """Boxes of a table `name, x0 [m], ..., z1 [m]`, polygons of one `name, x [m], y [m], z [m]` with a line a corner,
    or the labels of a PLY cloud (property `label`; 0: none). Raises FormatError.
    """
    if path.suffix.lower() == ".ply":
        return _cloud(path)
    columns = columns_of(path)
    if "name" not in columns:
        raise FormatError(path, "areas of interest have no names", expected="a column name", got=", ".join(columns))
    names = [str(name) for name in columns["name"]]
    if all(axis in columns for axis in (*LOW, *HIGH)):
        return _boxes(path, names, np.stack([_numbers(path, columns, LOW), _numbers(path, columns, HIGH)], axis=1))
    if all(axis in columns for axis in AXES):
        return _polygons(path, names, _numbers(path, columns, AXES))
    wanted = " or ".join(", ".join(("name", *axes)) for axes in ((*LOW, *HIGH), AXES))
    raise FormatError(path, "no table of areas of interest", expected=wanted, got=", ".join(columns))


def _numbers(path: Path, columns: dict[str, np.ndarray], axes: tuple[str, ...]) -> np.ndarray:
    values = [columns[axis] for axis in axes]
    if not all(value.dtype.kind == "f" and np.isfinite(value).all() for value in values):
        raise FormatError(path, "an area of interest has no place", expected="finite numbers")
    return np.stack(values, axis=1)


def _boxes(path: Path, names: list[str], corners: np.ndarray) -> Areas:
    if len(set(names)) != len(names):
        raise FormatError(path, "two boxes have one name", got=max(names, key=names.count))
    ordered = np.sort(corners, axis=1)
    return Areas(tuple(names), boxes=dict(enumerate(ordered)))


def _polygons(path: Path, names: list[str], corners: np.ndarray) -> Areas:
    unique = tuple(dict.fromkeys(names))
    found = {i: corners[[name == wanted for name in names]] for i, wanted in enumerate(unique)}
    for i, polygon in found.items():
        if len(polygon) < 3:
            raise FormatError(path, f"{unique[i]} is no polygon", expected="3 corners", got=str(len(polygon)))
    return Areas(unique, polygons=found)


def _cloud(path: Path) -> Areas:
    cloud = ply.read(path)
    if LABEL not in cloud.extra:
        raise FormatError(path, "the cloud has no labels", expected=f"a property {LABEL}", got=", ".join(cloud.extra))
    labels = cloud.extra[LABEL]
    values = [value for value in np.unique(labels) if value != 0]
    if not 0 < len(values) <= MOST:
        raise FormatError(path, "labels of the cloud", expected=f"1 to {MOST}", got=str(len(values)))
    points = {i: cloud.vertices[labels == value].astype(np.float64) for i, value in enumerate(values)}
    if not all(np.isfinite(part).all() for part in points.values()):
        raise FormatError(path, "a point of the cloud has no place", expected="finite numbers")
    return Areas(tuple(f"{value:g}" for value in values), clouds=points)
