"""Parts of the body, described in TOML: files of one's own, and those beside this module for the skeletons in common
use.

up = [0, 1, 0]
root = "hips"
left = ["left_hip", "left_shoulder"]    # the body faces up x (right - left)
right = ["right_hip", "right_shoulder"]
top = "head"                            # the height is the length of the bones from here ...
bottom = ["left_foot", "right_foot"]    # ... to here

[groups]                                # from the trunk outwards
left_arm = ["left_shoulder", "left_elbow", "left_wrist"]
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ipcli.errors import FormatError, ParameterError, nearest
from ipcli.geometry.skeleton import Groups, Skeleton
from ipcli.inputs import read_toml

SHIPPED = {path.stem: path for path in sorted(Path(__file__).parent.glob("*.toml"))}
LISTS, NAMES = ("left", "right", "bottom"), ("root", "top")


def find(name: str, skeleton: Skeleton) -> Groups:
    """The groups for a skeleton: "auto" (the first shipped ones whose joints it has), the name of shipped ones, or a
    file.

    Raises FormatError for a bad file, ParameterError for a joint that the skeleton has not or when none of the shipped
    ones fit.
    """
    if name != "auto":
        path = SHIPPED.get(name, Path(name))
        if not path.exists():
            raise ParameterError(
                f"no groups '{name}'{nearest(name, SHIPPED)} Give a TOML file, auto, or one of {', '.join(SHIPPED)}"
            )
        groups = read(path)
        groups.indices(skeleton)
        return groups
    for path in SHIPPED.values():
        groups = read(path)
        if joints_of(groups) <= set(skeleton.joints):
            return groups
    some = ", ".join(skeleton.joints[:4])
    raise ParameterError(
        f"no groups of joints fit this skeleton ({some}, ...). Known are those of {', '.join(SHIPPED)}; "
        "give a TOML file of your own with --groups (docs/motions.md)"
    )


def joints_of(groups: Groups) -> set[str]:
    """All joints that the groups name."""
    return {groups.root, groups.top, *groups.left, *groups.right, *groups.bottom}.union(*groups.parts.values())


def read(path: Path) -> Groups:
    """The groups of a TOML file. Raises FormatError for what is missing, unknown or of a wrong type."""
    path = Path(path)
    given = read_toml(path, fix="See docs/motions.md for an example")
    known = (*NAMES, *LISTS, "up", "groups")
    for key in given:
        if key not in known:
            raise FormatError(
                path, f"'{key}' is not a key of groups{nearest(key, known)}", fix=f"Known: {', '.join(known)}"
            )
    for key in known:
        if key not in given and key != "up":
            raise FormatError(path, f"'{key}' is missing", fix="See docs/motions.md for an example")
    if not isinstance(given["groups"], dict) or not given["groups"]:
        raise FormatError(
            path, "no table [groups]", fix='Add lines such as left_arm = ["left_shoulder", "left_elbow"] under [groups]'
        )
    parts = {part: _joints(path, f"groups.{part}", names) for part, names in given["groups"].items()}
    lists = {key: _joints(path, key, given[key]) for key in LISTS}
    root, top = (_joints(path, key, [given[key]])[0] for key in ("root", "top"))
    if len(lists["left"]) != len(lists["right"]):
        got = f"{len(lists['left'])} and {len(lists['right'])}"
        raise FormatError(
            path, "left and right are not pairs", expected="as many joints in each", got=got, fix="Give both of a pair"
        )
    up = _up(path, given.get("up", [0, 1, 0]))
    return Groups(parts, root, lists["left"], lists["right"], top, lists["bottom"], up, path.name)


def _joints(path: Path, key: str, names: Any) -> tuple[str, ...]:
    if not isinstance(names, list) or not names or not all(isinstance(name, str) for name in names):
        raise FormatError(
            path, f"{key} is not a list of joints", expected="names", got=names, fix='Write ["hips", "spine"], say'
        )
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise FormatError(path, f"{key} names '{twice}' twice", fix="Name each joint once")
    return tuple(names)


def _up(path: Path, axis: Any) -> tuple[float, float, float]:
    if not isinstance(axis, list) or sorted(axis) not in ([0, 0, 1], [-1, 0, 0]):
        raise FormatError(
            path, "up is not an axis", expected="[0, 1, 0], say", got=axis, fix="Give one number 1 or -1 and two 0"
        )
    x, y, z = map(float, axis)
    return x, y, z
