"""ASF skeletons and AMC motions (Acclaim; HDM05, CMU): latin-1 text, lengths in inches of a unit of the file, angles in
its axes.

A bone hangs from the far end of its parent and is named for its own far end. With C the rotation of its `axis`, M that
of its channels and `direction` d, both in the rest pose: Q = Q_parent C M C^T and p = p_parent + length Q d. Angles
turn about fixed axes in the order of `axis`; channels come in the order of `dof`. At rest all Q are the identity.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np

from ipcli.errors import FormatError, nearest
from ipcli.geometry.skeleton import NO_PARENT, Skeleton, forward_kinematics
from ipcli.inputs import CUT, cut_number
from ipcli.io.files.text import read_any_text, whole
from ipcli.measurements.motions import Motion, check_motion

INCH = 0.0254  # metres
CHANNELS = ("rx", "ry", "rz", "tx", "ty", "tz", "l")
MOST_GAPS = 100  # frames for each frame that there is
DAMAGED = "Check that the copy is complete, or fix the line"
Line = tuple[int, list[str]]  # number from 1, words


@dataclass(frozen=True)
class Bone:
    """A bone of the rest pose; the root is one of no length."""

    name: str
    direction: tuple[float, float, float] = (0.0, 0.0, 0.0)
    length: float = 0.0  # in the unit of the file
    axis: tuple[float, float, float] = (0.0, 0.0, 0.0)
    order: str = "xyz"
    channels: tuple[str, ...] = ()


@dataclass(frozen=True)
class Asf:
    """A skeleton at rest. `scale` is metres per unit of length."""

    path: Path
    bones: tuple[Bone, ...]
    parents: tuple[int, ...]
    scale: float
    degrees: bool
    notes: tuple[str, ...] = ()
    position: tuple[float, float, float] = field(default=(0.0, 0.0, 0.0))

    @cached_property
    def skeleton(self) -> Skeleton:
        return Skeleton(tuple(bone.name for bone in self.bones), self.parents)


def read(amc: Path, asf: Asf | Path | None = None, *, rate: float | None = None, unit: float | None = None) -> Motion:
    """The motion of an AMC file on its skeleton (found beside it if not given).

    The rate in Hz is the one given, else that of the file (`:samples-per-second`), else that of the name
    (HDM_bd_squat_001_120.amc). `unit` is metres per unit of length, where the file's own is wrong. Frame numbers that
    are left out become frames of NaN.
    """
    amc = Path(amc)
    skeleton = asf if isinstance(asf, Asf) else read_asf(asf or asf_of(amc))
    lines, degrees, stated = _amc_lines(amc, skeleton.degrees)
    frames, values = _channels(amc, lines, skeleton)
    rotations, positions = _pose(skeleton, values, degrees, unit or skeleton.scale)
    rotations, positions = (_with_gaps(amc, frames, part) for part in (rotations, positions))
    notes = (*skeleton.notes, CUT) if cut_number(read_any_text(amc)) else skeleton.notes
    return check_motion(Motion(skeleton.skeleton, positions, _rate(amc, rate or stated), rotations, notes), amc)


def asf_of(amc: Path) -> Path:
    """The skeleton of a motion: of the .asf files beside it the one whose name its name begins with, or the
    only one.
    """
    there = (
        sorted(path for path in amc.parent.iterdir() if path.suffix.lower() == ".asf") if amc.parent.is_dir() else []
    )
    fitting = [path for path in there if amc.stem.lower().startswith(path.stem.lower())] or (
        there if len(there) == 1 else []
    )
    if not fitting:
        got = ", ".join(path.name for path in there) or "none"
        fix = "Put the ASF file of this actor into the folder, with a name that the name of the AMC begins with"
        raise FormatError(
            amc, "a motion without its skeleton", expected=f"{amc.stem.split('_')[0]}*.asf beside it", got=got, fix=fix
        )
    return max(fitting, key=lambda path: len(path.stem))


def read_asf(path: Path) -> Asf:
    """The skeleton of an ASF file. Raises FormatError with the line of the first thing that is wrong."""
    path = Path(path)
    sections = _sections(path)
    units = {words[0].lower(): words[1] for _, words in sections["units"] if len(words) > 1}
    root = {words[0].lower(): (number, words[1:]) for number, words in sections["root"]}
    bones = (_root(path, root), *_bones(path, sections["bonedata"]))
    length = _number(path, 0, units.get("length", "1"))
    if length <= 0:
        raise FormatError(path, "the unit of length is not above 0", got=length, fix="Write `length 0.45` under :units")
    return Asf(
        path,
        bones,
        _parents(path, sections["hierarchy"], [bone.name for bone in bones]),
        INCH / length,
        not units.get("angle", "deg").lower().startswith("rad"),
        () if "length" in units else (f"{path.name} states no unit of length: taken as inches. If not, give --unit",),
        _triple(path, *root.get("position", (0, ["0", "0", "0"]))),
    )


def _lines(path: Path) -> Iterator[Line]:
    """Lines with words in them, comments left out."""
    for number, line in enumerate(re.split(r"\r\n|\r|\n", read_any_text(path)), start=1):
        if words := line.partition("#")[0].split():
            yield number, words


def _sections(path: Path) -> dict[str, list[Line]]:
    sections: dict[str, list[Line]] = {}
    current: list[Line] = []
    for number, words in _lines(path):
        if words[0].startswith(":"):
            current = sections.setdefault(words[0][1:].lower(), [])
        else:
            current.append((number, words))
    for name in ("root", "bonedata", "hierarchy"):
        if not sections.get(name):
            fix = "Give an ASF file; if it is one, check that the copy is complete"
            raise FormatError(
                path, f"no section :{name}, so no skeleton", expected=":root, :bonedata, :hierarchy", fix=fix
            )
    return sections | {"units": sections.get("units", [])}


def _root(path: Path, root: dict[str, tuple[int, list[str]]]) -> Bone:
    number, order = root.get("order", (0, ["TX", "TY", "TZ", "RX", "RY", "RZ"]))
    axis = root.get("axis", (0, ["XYZ"]))
    turned = _triple(path, *root.get("orientation", (0, ["0", "0", "0"])))
    return Bone("root", axis=turned, order=_order(path, *axis), channels=_channel_names(path, number, order))


def _bones(path: Path, lines: Sequence[Line]) -> Iterator[Bone]:
    facts: dict[str, Line] = {}
    opened = 0
    for number, words in lines:
        keyword = words[0].lower()
        if keyword == "begin":
            facts, opened = {}, number
        elif keyword == "end":
            yield _bone(path, opened, facts)
            opened = 0
        else:
            facts.setdefault(keyword, (number, words[1:]))
    if opened:
        raise FormatError(path, f"line {opened}: the bone that begins here does not end", fix=DAMAGED)


def _bone(path: Path, opened: int, facts: dict[str, Line]) -> Bone:
    if missing := [key for key in ("name", "direction", "length", "axis") if not facts.get(key, (0, []))[1]]:
        raise FormatError(path, f"line {opened}: a bone without its {missing[0]}", fix="Add the line to the bone")
    (_, [name, *_]), (at, [length, *_]) = facts["name"], facts["length"]
    extent = _number(path, at, length)
    if extent < 0:
        raise FormatError(
            path, f"line {at}: bone '{name}' has a negative length", expected=">= 0", got=extent, fix=DAMAGED
        )
    number, words = facts["axis"]
    return Bone(
        name,
        _triple(path, *facts["direction"]),
        extent,
        _triple(path, number, words[:3]),
        _order(path, number, words[3:]),
        _channel_names(path, *facts.get("dof", (opened, []))),
    )


def _parents(path: Path, lines: Sequence[Line], names: list[str]) -> tuple[int, ...]:
    parent_of: dict[str, str] = {}
    for number, words in lines:
        if words[0].lower() in ("begin", "end"):
            continue
        for name in words:
            if name not in names:
                fix = "Describe the bone under :bonedata, or correct its name"
                raise FormatError(path, f"line {number}: unknown bone '{name}'{nearest(name, names)}", fix=fix)
        parent_of |= dict.fromkeys(words[1:], words[0])
    if loose := [name for name in names[1:] if name not in parent_of]:
        raise FormatError(path, f"bone '{loose[0]}' has no place under :hierarchy", fix="Add it below its parent")
    return (NO_PARENT, *(names.index(parent_of[name]) for name in names[1:]))


def _number(path: Path, line: int, word: str) -> float:
    try:
        return float(word)
    except ValueError:
        raise FormatError(path, f"line {line}: '{word}' is not a number", fix=DAMAGED) from None


def _triple(path: Path, line: int, words: Sequence[str]) -> tuple[float, float, float]:
    if len(words) < 3:
        raise FormatError(path, f"line {line}: {len(words)} numbers", expected=3, fix=DAMAGED)
    x, y, z = (_number(path, line, word) for word in words[:3])
    return x, y, z


def _order(path: Path, line: int, words: Sequence[str]) -> str:
    order = words[0].lower() if words else "xyz"
    if sorted(order) != ["x", "y", "z"]:
        raise FormatError(path, f"line {line}: axis order '{order}'", expected="XYZ in some order", fix=DAMAGED)
    return order


def _channel_names(path: Path, line: int, words: Sequence[str]) -> tuple[str, ...]:
    names = tuple(word.lower() for word in words)
    for name in names:
        if name not in CHANNELS or names.count(name) > 1:
            raise FormatError(
                path, f"line {line}: channel '{name}'", expected=f"each once of {' '.join(CHANNELS)}", fix=DAMAGED
            )
    return names


def _amc_lines(path: Path, degrees: bool) -> tuple[list[Line], bool, float | None]:
    """The lines of the frames, and what the head says of angles and rate."""
    lines, rate = [], None
    for number, words in _lines(path):
        keyword = words[0].lower()
        if not keyword.startswith(":"):
            lines.append((number, words))
        elif keyword in (":degrees", ":radians"):
            degrees = keyword == ":degrees"
        elif keyword == ":samples-per-second" and len(words) > 1:
            rate = _number(path, number, words[1])
    if not lines or whole(lines[0][1][0]) is None:
        fix = "Give the AMC file of the motion; an ASF file holds the skeleton only"
        raise FormatError(
            path, "no frames, so no motion", expected="a line with the number of the first frame", fix=fix
        )
    return lines, degrees, rate


def _channels(path: Path, lines: list[Line], asf: Asf) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Frame numbers (f,) and the channels (f, c) of each bone. All frames have the lines of the first, in its order."""
    starts = [index for index, (_, words) in enumerate(lines) if len(words) == 1 and whole(words[0]) is not None]
    per_frame = (starts[1] if len(starts) > 1 else len(lines)) - 1
    names = [words[0] for _, words in lines[1 : per_frame + 1]]
    wanted = {bone.name: len(bone.channels) for bone in asf.bones}
    _check_first_frame(path, lines[1 : per_frame + 1], wanted, asf)
    columns = [wanted[name] + 1 for name in names]
    regular = len(lines) == len(starts) * (per_frame + 1) and starts == list(range(0, len(lines), per_frame + 1))
    words = [word for _, line in lines for word in line]
    if not regular or len(words) != len(starts) * (1 + sum(columns)):
        _complain(path, lines, names, wanted)
    table = np.array(words, object).reshape(len(starts), -1)
    at = np.cumsum([1, *columns[:-1]])
    if (table[:, at] != np.array(names, object)).any():
        _complain(path, lines, names, wanted)
    try:
        values = {
            name: table[:, i + 1 : i + width].astype(np.float64)
            for name, i, width in zip(names, at, columns, strict=True)
        }
    except ValueError:
        _complain(path, lines, names, wanted)
    return table[:, 0].astype(np.int64), values


def _check_first_frame(path: Path, lines: Sequence[Line], wanted: dict[str, int], asf: Asf) -> None:
    for number, (name, *values) in lines:
        if name not in wanted:
            fix = f"Give the skeleton that the motion was made for; {asf.path.name} was taken"
            raise FormatError(path, f"line {number}: unknown bone '{name}'{nearest(name, wanted)}", fix=fix)
        if len(values) != wanted[name]:
            fix = f"Check that {asf.path.name} is the skeleton of this motion, and that the copy is complete"
            raise FormatError(
                path, f"line {number}: bone '{name}'", expected=f"{wanted[name]} values", got=len(values), fix=fix
            )
    given = {words[0] for _, words in lines}
    if missing := [name for name, count in wanted.items() if count and name not in given]:
        fix = f"Check that {asf.path.name} is the skeleton of this motion"
        raise FormatError(path, f"no channels of bone '{missing[0]}', which moves in {asf.path.name}", fix=fix)


def _complain(path: Path, lines: list[Line], names: list[str], wanted: dict[str, int]) -> None:
    """Raise FormatError for the first line that is not the one that has to come."""
    expected = ["a frame number", *names]
    for index, (number, (name, *values)) in enumerate(lines):
        due = expected[index % len(expected)]
        if (name != due) if index % len(expected) else whole(name) is None or bool(values):
            raise FormatError(path, f"line {number}: '{name}' comes where {due} has to", fix=DAMAGED)
        if index % len(expected) and len(values) != wanted[name]:
            raise FormatError(
                path, f"line {number}: bone '{name}'", expected=f"{wanted[name]} values", got=len(values), fix=DAMAGED
            )
        for word in values:
            _number(path, number, word)
    raise FormatError(
        path, f"line {lines[-1][0]}: the file ends within a frame", expected=f"{len(names)} bones", fix=DAMAGED
    )


def _pose(asf: Asf, values: dict[str, np.ndarray], degrees: bool, scale: float) -> tuple[np.ndarray, np.ndarray]:
    """World rotations (f, j, 3, 3) and positions (f, j, 3) in metres."""
    from scipy.spatial.transform import Rotation

    frames = len(next(iter(values.values()))) if values else 1
    rotations = np.empty((frames, len(asf.bones), 3, 3))
    translations = np.empty((frames, len(asf.bones), 3))
    for joint, bone in enumerate(asf.bones):
        channels = dict(zip(bone.channels, values.get(bone.name, np.empty((frames, 0))).T, strict=False))
        angles, moved, stretch = (
            _columns(channels, names, frames) for names in ([f"r{a}" for a in bone.order], ["tx", "ty", "tz"], ["l"])
        )
        frame = Rotation.from_euler(
            bone.order, [bone.axis["xyz".index(axis)] for axis in bone.order], degrees=asf.degrees
        ).as_matrix()
        turn = frame @ Rotation.from_euler(bone.order, angles, degrees=degrees).as_matrix()
        rotations[:, joint] = turn @ frame.T if joint else turn
        extent = (bone.length + stretch) * bone.direction if joint else np.array(asf.position)
        translations[:, joint] = scale * (
            (rotations[:, joint] @ extent[..., None])[..., 0] + moved if joint else extent + moved
        )
    return forward_kinematics(asf.skeleton, rotations, translations)


def _columns(channels: dict[str, np.ndarray], names: Sequence[str], frames: int) -> np.ndarray:
    """Channels of these names, (f, n); 0 for those that there are not."""
    return np.stack([channels.get(name, np.zeros(frames)) for name in names], axis=-1)


def _with_gaps(path: Path, frames: np.ndarray, values: np.ndarray) -> np.ndarray:
    steps = np.diff(frames)
    if (steps < 1).any():
        at = int(np.argmax(steps < 1)) + 1
        raise FormatError(
            path, f"frame {frames[at]} comes after frame {frames[at - 1]}", expected="growing numbers", fix=DAMAGED
        )
    if (steps == 1).all():
        return values
    if frames[-1] - frames[0] > MOST_GAPS * len(frames):
        got = f"{frames[0]} to {frames[-1]}"
        raise FormatError(path, f"{len(frames)} frames with numbers far apart", got=got, fix=DAMAGED)
    spread = np.full((frames[-1] - frames[0] + 1, *values.shape[1:]), np.nan)
    spread[frames - frames[0]] = values
    return spread


def _rate(path: Path, rate: float | None) -> float:
    if rate is not None:
        return rate
    named = re.search(r"_(\d{2,3})$", path.stem) if path.stem.upper().startswith("HDM_") else None
    if named is None:
        fix = "Give it with --source-rate (HDM05 and most of CMU: 120)"
        raise FormatError(path, "an AMC file that does not say its frame rate", fix=fix)
    return float(named.group(1))
