"""Measured materials: networks and ABC fits of MERL's 100 in NPZ and JSON, and MERL's own binary tables."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ipcli.errors import FormatError, nearest
from ipcli.inputs import json_of
from ipcli.io.files import npz

TABLE = (90, 90, 180)
LAYERS = {"k1": (6, 21), "b1": (21,), "k2": (21, 21), "b2": (21,), "k3": (21, 3), "b3": (3,)}
SCALE = np.array([1.0, 1.15, 1.66]) / 1500.0  # of the stored numbers, after the authors' reader
ABC_SIZE = 1 << 24  # bytes


def read_network(path: Path, name: str) -> dict[str, np.ndarray]:
    """Weights k1 b1 k2 b2 k3 b3 of one material of an NPZ that stacks them along `names`."""
    arrays = npz.read(path)
    if set(LAYERS) - set(arrays):
        raise FormatError(
            path, "not a set of networks", expected=", ".join(LAYERS), got=", ".join(sorted(arrays)) or "nothing"
        )
    if "names" not in arrays or arrays["names"].dtype.kind != "U":
        raise FormatError(path, "the networks have no names", expected="an array `names` of text")
    index = _index(path, list(map(str, arrays["names"])), name)
    weights = {key: np.asarray(arrays[key], np.float32) for key in LAYERS}
    for key, shape in LAYERS.items():
        if weights[key].shape != (len(arrays["names"]), *shape) or not np.isfinite(weights[key]).all():
            raise FormatError(
                path, f"{key} is not sound", expected=(len(arrays["names"]), *shape), got=weights[key].shape
            )
    return {key: value[index] for key, value in weights.items()}


def read_abc(path: Path, name: str) -> dict[str, Any]:
    """Parameters kD, A (RGB), B, C and index of refraction of one material of a JSON of ABC fits."""
    try:
        if path.stat().st_size > ABC_SIZE:
            raise FormatError(path, "too large to be a table of fits")
        table = json_of(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise FormatError(path, f"not readable JSON: {' '.join(str(error).split())}") from error
    fits = table.get("abc") if isinstance(table, dict) else None
    if not isinstance(fits, dict):
        raise FormatError(path, "holds no ABC fits", expected="an object `abc`")
    _index(path, list(fits), name)
    try:
        one = fits[name]
        numbers = [tuple(float(v) for v in one[key]) for key in ("kD", "A", "BCior")]
    except (TypeError, KeyError, ValueError, OverflowError) as error:
        raise FormatError(
            path, f"the fit of '{name}' is not sound", expected="kD, A and BCior of three numbers"
        ) from error
    if any(len(part) != 3 or not np.isfinite(part).all() for part in numbers):
        raise FormatError(path, f"the fit of '{name}' is not sound", expected="three finite numbers each")
    return {
        "diffuse": numbers[0],
        "scale": numbers[1],
        "width": numbers[2][0],
        "falloff": numbers[2][1],
        "eta": numbers[2][2],
    }


def read_table(path: Path) -> np.ndarray:
    """A MERL `.binary` as (90, 90, 180, 3) float32 in 1/sr; entries that were not measured are negative."""
    count = int(np.prod(TABLE))
    size = 12 + 3 * 8 * count
    try:
        if path.stat().st_size != size:
            raise FormatError(path, "not a MERL table", expected=f"{size} bytes", got=path.stat().st_size)
        data = path.read_bytes()
    except OSError as error:
        raise FormatError(path, f"cannot be read: {error.strerror}") from error
    dims = tuple(int(v) for v in np.frombuffer(data, "<i4", 3))
    if dims != TABLE:
        raise FormatError(path, "not a MERL table", expected=TABLE, got=dims)
    values = np.frombuffer(data, "<f8", offset=12).reshape(3, *TABLE)
    return np.moveaxis(values, 0, -1).astype(np.float32) * SCALE.astype(np.float32)


def _index(path: Path, names: list[str], name: str) -> int:
    if name not in names:
        raise FormatError(path, f"has no material '{name}'{nearest(name, names)}")
    return names.index(name)
