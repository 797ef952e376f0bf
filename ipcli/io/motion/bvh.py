"""BVH motions: any order of channels in any joint, position channels on any joint, end sites as joints of their own.

The angles of a joint turn about its own axes in the order in which its channels are written: "Zrotation Xrotation
Yrotation" is R = Rz Rx Ry, and another joint of the same file may do it otherwise. A joint stands at its OFFSET from
its parent; position channels take the place of the OFFSET, as in Blender, axis by axis. An end site is the joint
NAME_end. A prefix "mixamorig:" is taken off.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ipcli.errors import FormatError, nearest
from ipcli.geometry.skeleton import NO_PARENT, Skeleton, forward_kinematics
from ipcli.inputs import CUT, cut_number
from ipcli.io.files.text import read_any_text
from ipcli.measurements.motions import Motion, check_motion

UNIT = 0.01  # metres: files do not say their unit; most are in centimetres
CHANNELS = tuple(f"{axis}{kind}" for kind in ("position", "rotation") for axis in "XYZ")
DAMAGED = "Check that the copy is complete, or fix the line"
FRAME_TIME = re.compile(r"\s*frame\s*time\s*:?", re.IGNORECASE)
FRAMES = re.compile(r"\s*frames\s*:", re.IGNORECASE)
# a joint and all of its name, which may hold spaces; an end site and whatever it is called; a brace; a word
WORDS = re.compile(r"(ROOT|JOINT)\s+([^{}]+)|(END)\s+SITE[^{}]*|([{}]|[^\s{}:]*:|[^\s{}:]+)", re.IGNORECASE)
GLUED = re.compile(r"(?<=[0-9.])(?=[-+])")  # between two numbers without a space, the second with a sign


@dataclass
class Joint:
    """A joint as its block describes it."""

    name: str
    parent: int
    offset: tuple[float, ...] = ()
    channels: tuple[str, ...] = ()
    line: int = 0


@dataclass
class Words:
    """The words of a file with their lines, taken one after the other."""

    path: Path
    words: Iterator[tuple[int, str]]
    line: int = field(default=1)

    def take(self, what: str) -> str:
        """The next word; FormatError when the file ends before `what`."""
        try:
            self.line, word = next(self.words)
        except StopIteration:
            raise FormatError(self.path, f"line {self.line}: the file ends", expected=what, fix=DAMAGED) from None
        return word

    def number(self, what: str) -> float:
        """The next word as a number."""
        word = self.take(what)
        try:
            return float(word)
        except ValueError:
            raise self.wrong(what, word) from None

    def wrong(self, expected: str, got: str) -> FormatError:
        """The error for a word that is not the one that has to come."""
        return FormatError(self.path, f"line {self.line}: '{got}'", expected=expected, fix=DAMAGED)


def read(path: Path, *, rate: float | None = None, unit: float | None = None) -> Motion:
    """The motion of a BVH file. `unit` is metres a unit of length (default: centimetres), `rate` in Hz replaces the
    frame time.

    Raises FormatError with the line of the first thing that is wrong.
    """
    path = Path(path)
    head, body, first = _parts(path)
    joints = _hierarchy(head)
    frames, frame_time = _heading(head)
    count = sum(len(joint.channels) for joint in joints)
    notes = (CUT,) if body and cut_number(body[-1]) else ()
    if body != (apart := _apart(body, frames * count)):
        notes, body = (*notes, "numbers stand side by side without a space and were taken apart at their signs"), apart
    values = _values(path, body, first, (frames, count))
    skeleton = Skeleton(tuple(joint.name for joint in joints), tuple(joint.parent for joint in joints))
    scale = UNIT if unit is None else unit
    rotations, positions = forward_kinematics(skeleton, *_local(joints, values, scale))
    return check_motion(Motion(skeleton, positions, rate or 1 / frame_time, rotations, notes), path)


def _parts(path: Path) -> tuple[Words, list[str], int]:
    """The words up to and with the frame time, the lines after it, and the number of the first of these."""
    lines = re.split(r"\r\n|\r|\n", read_any_text(path))
    end = next((index for index, line in enumerate(lines) if FRAME_TIME.match(line)), len(lines) - 1) + 1
    return Words(path, _words(lines[:end])), lines[end:], end + 1


def _words(lines: Sequence[str]) -> Iterator[tuple[int, str]]:
    """The words of the head with their lines; the name of a joint is one word."""
    for number, line in enumerate(lines, start=1):
        plain = FRAMES.sub("Frames: ", FRAME_TIME.sub("Frame Time: ", line, count=1), count=1)
        for keyword, name, end, word in WORDS.findall(plain):
            for found in (keyword, name.strip(), end, word):
                if found:
                    yield number, found


def _apart(lines: list[str], wanted: int) -> list[str]:
    """The lines with their numbers taken apart where that makes as many as are wanted."""
    if sum(len(line.split()) for line in lines) >= wanted:
        return lines
    apart = [GLUED.sub(" ", line) for line in lines]
    return apart if sum(len(line.split()) for line in apart) == wanted else lines


def _hierarchy(words: Words) -> list[Joint]:
    """The joints in order of the file, up to the word MOTION."""
    if (word := words.take("HIERARCHY")).upper() != "HIERARCHY":
        raise words.wrong("HIERARCHY, the first word of a BVH file", word)
    joints: list[Joint] = []
    open_blocks: list[int] = []
    while (word := words.take("MOTION")).upper() != "MOTION":
        match word.upper():
            case "ROOT" | "JOINT" | "END":
                joints.append(_named(words, word, joints, open_blocks[-1] if open_blocks else NO_PARENT))
                if (brace := words.take("{")) != "{":
                    raise words.wrong("{", brace)
                open_blocks.append(len(joints) - 1)
            case "OFFSET" if open_blocks:
                joints[open_blocks[-1]].offset = tuple(words.number("three numbers after OFFSET") for _ in range(3))
            case "CHANNELS" if open_blocks:
                joints[open_blocks[-1]].channels = _channels(words)
            case "}" if open_blocks:
                _closed(words, joints[open_blocks.pop()])
            case _:
                raise words.wrong("ROOT, JOINT, End Site, OFFSET, CHANNELS, } or MOTION", word)
    if open_blocks:
        raise words.wrong(f"}} of joint '{joints[open_blocks[-1]].name}'", word)
    if not joints:
        raise words.wrong("ROOT", word)
    return joints


def _named(words: Words, keyword: str, joints: Sequence[Joint], parent: int) -> Joint:
    if keyword.upper() == "END":
        if parent == NO_PARENT:
            raise words.wrong("ROOT", "End Site")
        name = f"{joints[parent].name}_end"
        again = sum(joint.parent == parent and joint.name.startswith(name) for joint in joints)
        return Joint(name + (str(again + 1) if again else ""), parent, line=words.line)
    name = words.take("the name of a joint")
    name = name.rpartition(":")[2].strip() or name  # a namespace
    if (keyword.upper() == "ROOT") != (parent == NO_PARENT):
        raise words.wrong("ROOT outermost and JOINT inside", f"{keyword} {name}")
    return Joint(name, parent, line=words.line)


def _channels(words: Words) -> tuple[str, ...]:
    count = words.number("the number of channels")
    if count not in range(7):
        raise words.wrong("0 to 6 channels", f"{count:g}")
    names = []
    for _ in range(int(count)):
        word = words.take("a channel")
        name = word[:1].upper() + word[1:].lower()
        if name not in CHANNELS or name in names:
            what = f"line {words.line}: channel '{word}'{nearest(word, CHANNELS)}"
            raise FormatError(words.path, what, expected=" ".join(CHANNELS), fix="Give each of these at most once")
        names.append(name)
    return tuple(names)


def _closed(words: Words, joint: Joint) -> None:
    if not joint.offset:
        raise FormatError(words.path, f"line {joint.line}: joint '{joint.name}' has no OFFSET", fix=DAMAGED)


def _heading(words: Words) -> tuple[int, float]:
    """Number of frames and seconds a frame."""
    if (word := words.take("Frames:")).upper() != "FRAMES:":
        raise words.wrong("Frames:", word)
    frames = words.number("the number of frames")
    if frames < 1 or frames != int(frames):
        raise words.wrong("at least one frame", f"{frames:g}")
    for expected in ("FRAME", "TIME:"):
        if (word := words.take("Frame Time:")).upper() != expected:
            raise words.wrong("Frame Time:", word)
    seconds = words.number("the frame time in seconds")
    if not 0 < seconds < np.inf:
        raise words.wrong("a frame time in seconds above 0", f"{seconds:g}")
    return int(frames), seconds


def _values(path: Path, lines: Sequence[str], first: int, shape: tuple[int, int]) -> np.ndarray:
    """The table of all channels, (frames, channels). A frame may take several lines."""
    words = " ".join(lines).split()
    try:
        table = np.array(words, dtype=np.float64)
    except ValueError:
        raise _not_a_number(path, lines, first) from None
    if len(words) != shape[0] * shape[1]:
        fix = "Check that the copy is complete, and that Frames: is the number of frames"
        expected = f"{shape[0]} frames of {shape[1]} numbers"
        raise FormatError(path, "wrong number of values", expected=expected, got=f"{len(words)} numbers", fix=fix)
    return table.reshape(shape)


def _not_a_number(path: Path, lines: Sequence[str], first: int) -> FormatError:
    for number, line in enumerate(lines, start=first):
        for word in line.split():
            try:
                float(word)
            except ValueError:
                return FormatError(path, f"line {number}: '{word[:40]}' is not a number", fix=DAMAGED)
    return FormatError(path, "something that is not a number", fix=DAMAGED)


def _local(joints: Sequence[Joint], values: np.ndarray, scale: float) -> tuple[np.ndarray, np.ndarray]:
    """parent_from_joint: rotations (f, j, 3, 3) and translations (f, j, 3) in metres."""
    from scipy.spatial.transform import Rotation

    rotations = np.broadcast_to(np.eye(3), (len(values), len(joints), 3, 3)).copy()
    translations = np.empty((len(values), len(joints), 3))
    column = 0
    for index, joint in enumerate(joints):
        own = values[:, column : column + len(joint.channels)]
        column += len(joint.channels)
        translations[:, index] = joint.offset
        for position, channel in enumerate(joint.channels):
            if channel.endswith("position"):
                translations[:, index, "XYZ".index(channel[0])] = own[:, position]
        turns = [position for position, channel in enumerate(joint.channels) if channel.endswith("rotation")]
        if turns:
            order = "".join(joint.channels[position][0] for position in turns)
            rotations[:, index] = _turned(Rotation, order, own[:, turns])
    return rotations, scale * translations


def _turned(Rotation: Any, order: str, angles: np.ndarray) -> np.ndarray:
    known = np.isfinite(angles).all(axis=-1)
    turned = np.full((len(angles), 3, 3), np.nan)
    if known.any():
        turned[known] = Rotation.from_euler(order, angles[known], degrees=True).as_matrix()
    return turned
