"""MSR Action3D in world coordinates: a01_s01_e01_skeleton3D.txt, a line `x y z confidence` a joint, twenty a frame.

Its frame is the sensor's, x to the right, y up, z away: left-handed, so z is turned round. A joint at exactly 0 0 0 was
lost; one of confidence 0 was guessed by the sensor's software and is kept.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from ipcli.errors import FormatError
from ipcli.inputs import CUT, cut_number
from ipcli.io.files.text import comment_free, numbers, read_text
from ipcli.io.motion.kinect import KINECT
from ipcli.measurements.motions import Motion, check_motion

NAME = re.compile(r"a(?P<action>\d\d)_s(?P<actor>\d\d)_e(?P<repeat>\d\d)(_skeleton(3D)?)?", re.IGNORECASE)
RATE = 15.0  # Hz, the sensor's; the files do not say it
JOINTS = (  # in the order of the files
    ("right_shoulder", "left_shoulder", "shoulder_center", "spine", "right_hip", "left_hip", "hip_center")
    + ("right_elbow", "left_elbow", "right_wrist", "left_wrist", "right_hand", "left_hand", "right_knee", "left_knee")
    + ("right_ankle", "left_ankle", "right_foot", "left_foot", "head")
)
ACTIONS = (
    ("high arm wave", "horizontal arm wave", "hammer", "hand catch", "forward punch", "high throw", "draw x")
    + ("draw tick", "draw circle", "hand clap", "two hand wave", "side boxing", "bend", "forward kick", "side kick")
    + ("jogging", "tennis swing", "tennis serve", "golf swing", "pick up and throw")
)
FARTHEST = 15.0  # metres; pixels are more


def is_msr(path: Path) -> bool:
    """Whether the name is one of MSR Action3D."""
    return path.suffix.lower() == ".txt" and NAME.fullmatch(path.stem) is not None


def label_of(stem: str) -> tuple[str, str] | None:
    """The action and the actor that a name tells; None for a name of another kind."""
    found = NAME.fullmatch(stem)
    if found is None:
        return None
    action = int(found["action"])
    return (ACTIONS[action - 1] if 1 <= action <= len(ACTIONS) else f"a{action:02d}"), f"s{found['actor']}"


def read(path: Path, *, rate: float | None = None, unit: float | None = None) -> Motion:
    """The motion of one file, on the skeleton of the Kinect. `unit` is metres a unit of length (default: metres)."""
    lines = comment_free(path)
    if not lines or len(lines) % len(JOINTS):
        got = f"{len(lines)} lines"
        raise FormatError(path, "not whole frames", expected="20 lines a frame", got=got, fix="Check the copy")
    table = np.array([numbers(path, line, text.replace(",", " ").split(), [4, 3])[:3] for line, text in lines])
    positions = table.reshape(-1, len(JOINTS), 3)
    if unit is None and np.nanmax(np.abs(positions)) > FARTHEST:
        fix = "Give the files of the release in world coordinates (MSRAction3DSkeletonReal3D), or --unit"
        raise FormatError(path, "coordinates of pixels, not of the world", expected="metres", fix=fix)
    positions[(positions == 0).all(axis=-1)] = np.nan
    ordered = positions[:, [JOINTS.index(name) for name in KINECT.joints]] * [1.0, 1.0, -1.0]
    notes = (CUT,) if cut_number(read_text(path)) else ()
    return check_motion(Motion(KINECT, ordered * (1.0 if unit is None else unit), rate or RATE, notes=notes), path)
