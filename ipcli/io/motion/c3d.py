"""C3D markers, by ezc3d (the extra `c3d`): positions only, each marker a joint that hangs from nothing."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

import numpy as np

from ipcli.errors import FormatError, IpcliError
from ipcli.geometry.skeleton import NO_PARENT, Skeleton
from ipcli.io.files.guarded import ParserFailed, guarded
from ipcli.io.motion.names import numbered
from ipcli.measurements.motions import Motion, check_motion

PROCESSORS = {
    84: ("<", 3),
    85: ("<", 1),
    86: (">", 0),
}  # Intel, DEC, SGI: order of bytes, and the byte of a float with its sign
UNITS = {"m": 1.0, "dm": 0.1, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}
OUTPUTS = ("ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS", "REACTIONS", "MODELED_SCALARS")  # groups of labels
COPY = "Check that the copy is complete, and that it is a C3D file"


def read(path: Path, *, rate: float | None = None, unit: float | None = None) -> Motion:
    """The markers of a C3D file. `unit` is metres a unit of length (default: as POINT:UNITS says), `rate` in Hz
    replaces its own.

    A marker that was lost (negative residual, or exactly at 0 0 0) is NaN. Raises IpcliError without the extra,
    FormatError for a file that is damaged, has no markers, or has none with a name.
    """
    if find_spec("ezc3d") is None:
        raise IpcliError(f"{path}: C3D files need the package ezc3d. Install it with pip install 'ipcli[c3d]'")
    if not path.is_file():
        raise FormatError(path, "no such file", fix="Check the path")
    _check_size(path)
    try:
        about, points, residuals = guarded(content, str(path))
    except ParserFailed as error:
        raise FormatError(path, f"not readable as C3D: {error}", fix=COPY) from None
    labels, outputs = _labels(about)[: points.shape[1]], _outputs(about)
    kept = [index for index, label in enumerate(labels) if label not in outputs]
    names, notes = numbered([labels[index] for index in kept])
    if len(kept) < len(labels):
        notes += (f"{len(labels) - len(kept)} outputs of a model (angles, forces ...) are no markers: left out",)
    if not kept:
        raise FormatError(
            path, "no markers in it (analog channels or rotations only)", fix="Export the trajectories of the markers"
        )
    positions = np.moveaxis(points[:3, kept], -1, 0).swapaxes(1, 2) * (_unit(path, about) if unit is None else unit)
    lost = (positions == 0).all(axis=-1) | (residuals[0, kept].T < 0)
    positions[lost] = np.nan
    skeleton = Skeleton(names, (NO_PARENT,) * len(names))
    return check_motion(Motion(skeleton, positions, rate or float(about["RATE"]["value"][0]), notes=notes), path)


def content(path: str) -> tuple[dict[str, dict[str, list]], np.ndarray, np.ndarray]:
    """The group POINT of the parameters, points (4, markers, frames) and residuals (1, markers, frames) by ezc3d, which
    may crash on a damaged file.
    """
    import ezc3d

    found = ezc3d.c3d(path)
    about = {
        name: {"value": list(item["value"])} for name, item in found["parameters"]["POINT"].items() if "value" in item
    }
    return about, np.array(found["data"]["points"]), np.array(found["data"]["meta_points"]["residuals"])


def _check_size(path: Path) -> None:
    """FormatError for a file shorter than its header says: ezc3d reads what is there without a word, or for ever."""
    data = path.read_bytes()[: 512 * 256]
    at = 512 * (data[0] - 1) if len(data) >= 512 else 0
    if at <= 0 or len(data) < at + 4 or data[1] != 0x50 or data[at + 3] not in PROCESSORS:
        raise FormatError(path, "not readable as C3D: it has no header of that format", fix=COPY)
    order, sign = PROCESSORS[data[at + 3]]
    points, analog, first, last, _, _, _, block = np.frombuffer(data, f"{order}u2", 8, offset=2).tolist()
    width = 4 if data[12 + sign] & 0x80 else 2  # a negative scale announces numbers of four bytes
    frames = (last - first + 1) % 65536  # longer recordings wrap, and say more elsewhere
    needed, got = 512 * (block - 1) + frames * width * (4 * points + analog), path.stat().st_size
    if got < needed:
        raise FormatError(path, "the file is cut off", expected=f"at least {needed} bytes", got=got, fix=COPY)


def _labels(about: dict) -> list[str]:
    """The names of all markers; of more than 255 they go on in LABELS2, LABELS3 ..."""
    blocks = ("LABELS", *(f"LABELS{index}" for index in range(2, 100)))
    names = [name.strip() for block in blocks if block in about for name in about[block]["value"]]
    return [name or f"marker{index}" for index, name in enumerate(names)]


def _outputs(about: dict) -> set[str]:
    """The labels of what a model computed, which has no place in the world, by the groups that list them."""
    blocks = [group + number for group in OUTPUTS for number in ("", *map(str, range(2, 100)))]
    return {name.strip() for block in blocks if block in about for name in about[block]["value"]}


def _unit(path: Path, about: dict) -> float:
    named = about["UNITS"]["value"][0].strip().lower() if about.get("UNITS", {"value": ()})["value"] else "mm"
    if named not in UNITS:
        raise FormatError(path, f"unknown unit '{named}'", expected=", ".join(UNITS), fix="Give the unit with --unit")
    return UNITS[named]
