"""BoofCV stereo sequences: `left/leftN.jpg`, `right/rightN.jpg` and `stereo_params.xml` (two radial coefficients)."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from ipcli.errors import FormatError
from ipcli.io.files import text as layout
from ipcli.io.gaze import pictures
from ipcli.measurements.recording import Camera, HeadRecording

RATE = 15.0  # frames a second: the files do not tell
LARGEST = 1 << 20  # bytes of a calibration


def is_boof(folder: Path) -> bool:
    """Whether the folder holds such a sequence."""
    return (folder / "stereo_params.xml").is_file() and (folder / "left").is_dir()


def open_boof(folder: Path) -> HeadRecording:
    """The sequence, frames in the order of their numbers."""
    left, right = (
        {re.sub(r"^\D+", "", stem): path for stem, path in layout.by_stem(folder / side, layout.IMAGES).items()}
        for side in ("left", "right")
    )
    names, words = pictures.matched(folder, left, right)
    width = max(map(len, names))
    cameras = _cameras(folder / "stereo_params.xml")
    pairs = [(left[name], right[name]) for name in names]
    return HeadRecording(
        tuple(name.zfill(width) for name in names),
        np.arange(len(names)) / RATE,
        cameras,
        pictures.loader(pairs, cameras),
        (folder / "stereo_params.xml", *(path for pair in pairs for path in pair)),
        source="BoofCV",
        dropped=words,
    )


def _cameras(path: Path) -> tuple[Camera, ...]:
    text = layout.read_text(path)
    if len(text) > LARGEST or "<!" in text:
        raise FormatError(path, "not a plain calibration file", fix="Remove entities and comments")
    try:
        root = ElementTree.fromstring(text)
        values = [{key: float(root.findtext(f"{side}/{key}", "")) for key in KEYS} for side in ("left", "right")]
        radial = [
            [float(node.text or "") for node in root.findall(f"{side}/radial/double")] for side in ("left", "right")
        ]
        turn = np.array([float(node.text or "") for node in root.findall("rightToLeft/r/data/double")]).reshape(3, 3)
        move = np.array([float(root.findtext(f"rightToLeft/t/{axis}", "")) for axis in "xyz"])
    except (ElementTree.ParseError, ValueError) as error:
        raise FormatError(path, f"calibration cannot be read: {error}", fix="Give BoofCV's StereoParameters") from None
    if not np.isfinite([*turn.ravel(), *move]).all() or not np.allclose(turn @ turn.T, np.eye(3), atol=1e-3):
        raise FormatError(path, "rightToLeft is not rigid")
    found = []
    for value, coefficients, pose in zip(values, radial, (np.eye(4), _inverse(turn, move)), strict=True):
        if not all(0 < value[key] < 1e5 for key in ("width", "height")) or len(coefficients) > 2:
            raise FormatError(path, "calibration makes no sense", got=f"{value}, radial {coefficients}")
        size = (int(value["width"]), int(value["height"]))
        lens = np.array([*coefficients, 0.0, 0.0, 0.0][:2] + [0.0, 0.0])
        focal = [value[key] for key in ("fx", "fy", "cx", "cy")]
        found.append(pictures.camera_of(path, focal, size, model="radtan", distortion=lens, cam_from_rig=pose))
    return tuple(found)


KEYS = ("fx", "fy", "cx", "cy", "width", "height")


def _inverse(turn: np.ndarray, move: np.ndarray) -> np.ndarray:
    """right_from_left of left_from_right."""
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn.T, -turn.T @ move
    return pose
