"""The project of an animal, a short TOML file: its parts, and which image shows what.

name = "giraffe"
size = 1.0                      # longest side of the model, in your unit

[parts]                         # part = parent; the root has ""
torso = ""
head = "torso"

[flatness]                      # optional: above 1 flatter than round
head = 1.2

[[images]]
masks = "left.png"              # index PNG, folder of one PNG a part, LabelMe .json or PASCAL-Part .mat
view = "left"                   # left right front back top bottom, or angles [40, 15]; left out when it is not known
# labels = ["torso", "head"]    # what the values 1, 2, ... of an index PNG mean; the order of [parts] if not given
# picture = "left.jpg"          # shown on the page
# pose = "other"                # not in the reference pose: a model of it is bent into the reference pose
# aspects = ["head"]            # parts that take their shape from here; all if not given
# rename = { lfleg = "leg" }    # names in the masks -> names of parts; "" drops a part
# object = 0                    # number of the object in a PASCAL-Part file

[[matches]]                     # optional: points of one part that two images show, four or more
part = "head"
images = ["left", "other"]      # names of images: those of their masks, without the ending
points = [[52, 31, 60, 28]]     # column and row in the first, column and row in the second
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ipcli.errors import FormatError, nearest
from ipcli.geometry.orthographic import NAMED, by_angles
from ipcli.inputs import read_toml
from ipcli.io.files import images
from ipcli.io.parts import masks
from ipcli.io.parts.pascal import REST
from ipcli.measurements.part_images import NONE, PartImage, PartMatches, PartTree

TOP = {"name": str, "size": (int, float), "parts": dict, "flatness": dict, "images": list, "matches": list}
IMAGE = {
    "name": str, "masks": str, "view": (str, list), "labels": list, "picture": str, "pose": str, "aspects": list,
    "rename": dict, "object": int,
}  # fmt: skip
MATCHES = {"part": str, "images": list, "points": list}
LEAST_MATCHES = 4  # that tell a similarity in space, with one to spare
POSES = ("reference", "other")


@dataclass(frozen=True, eq=False)
class Project:
    """An animal as its project describes it: what to model, from which images, and all files that were read."""

    name: str
    size: float
    tree: PartTree
    images: tuple[PartImage, ...]
    files: tuple[Path, ...]
    matches: tuple[PartMatches, ...] = ()


def read(path: Path) -> Project:
    """The project at `path` with all its masks. Raises FormatError, naming the file and the part."""
    path = Path(path)
    content = read_toml(path)
    _check_keys(path, content, TOP, "")
    tree = _tree(path, content.get("parts", {}), content.get("flatness", {}))
    entries = content.get("images", [])
    if not entries or not all(isinstance(entry, dict) for entry in entries):
        raise FormatError(path, "no images", fix="Add an [[images]] section with `masks` for each image")
    read_images = [_image(path, entry, tree, number) for number, entry in enumerate(entries, start=1)]
    pictures = tuple(image for image, _ in read_images)
    names = [image.name for image in pictures]
    if len(set(names)) < len(names):
        raise FormatError(path, "two images of one name", got=", ".join(names), fix="Give each a `name`")
    if not any(image.is_reference for image in pictures):
        raise FormatError(path, "no image of the reference pose", fix='Leave out pose = "other" in at least one')
    size = float(content.get("size", 1.0))
    if not 0 < size < 1e9:
        raise FormatError(path, "no size of an animal", expected="size > 0", got=size)
    files = (path, *(file for _, files in read_images for file in files))
    matches = tuple(_matches(path, entry, tree, pictures) for entry in content.get("matches", []))
    return Project(content.get("name", path.stem), size, tree, pictures, tuple(dict.fromkeys(files)), matches)


def _check_keys(path: Path, table: Mapping[str, Any], known: Mapping[str, Any], where: str) -> None:
    for key, value in table.items():
        if key not in known:
            raise FormatError(path, f"{where}unknown key '{key}'{nearest(key, known)}")
        if not isinstance(value, known[key]) or isinstance(value, bool):
            kinds = known[key] if isinstance(known[key], tuple) else (known[key],)
            words = " or ".join(kind.__name__ for kind in kinds)
            raise FormatError(path, f"{where}{key}: wrong type", expected=words, got=type(value).__name__)


def _tree(path: Path, parts: Mapping[str, Any], flatness: Mapping[str, Any]) -> PartTree:
    """The tree of the parts; FormatError for an unknown parent, no root or two, or parents in a circle."""
    names = tuple(parts)
    if not names or len(names) > masks.MOST_PARTS or not all(isinstance(parent, str) for parent in parts.values()):
        raise FormatError(path, "no parts", fix='Add a section [parts] with lines such as head = "torso"')
    for part, parent in parts.items():
        if parent and parent not in parts:
            raise FormatError(path, f"part '{part}' has the unknown parent '{parent}'{nearest(parent, parts)}")
    roots = [part for part, parent in parts.items() if not parent]
    if len(roots) != 1:
        raise FormatError(path, "not one root", expected='one part with the parent ""', got=", ".join(roots) or "none")
    for part in names:
        seen, at = {part}, parts[part]
        while at:
            if at in seen:
                raise FormatError(path, f"the parents of '{part}' go in a circle", got=" - ".join([*seen, at]))
            seen.add(at)
            at = parts[at]
    for part, value in flatness.items():
        if part not in parts or not isinstance(value, (int, float)) or not 0.05 <= value <= 20:
            raise FormatError(path, f"flatness of '{part}'", expected="a part = 0.05 to 20", got=value)
    parents = tuple(names.index(parts[part]) if parts[part] else NONE for part in names)
    return PartTree(names, parents, tuple(float(flatness.get(part, 1.0)) for part in names))


def _image(path: Path, entry: Mapping[str, Any], tree: PartTree, number: int) -> tuple[PartImage, list[Path]]:
    where = f"image {number}: "
    _check_keys(path, entry, IMAGE, where)
    if "masks" not in entry:
        raise FormatError(path, f"{where}no masks", fix='Add masks = "FILE"')
    view, pose = _view(path, where, entry.get("view")), entry.get("pose", "reference")
    if pose not in POSES:
        raise FormatError(path, f"{where}unknown pose '{pose}'{nearest(pose, POSES)}")
    source = path.parent / entry["masks"]
    if not os.path.exists(source):  # no error, as Path's has, for a name that no file can have
        raise FormatError(source, "no such file or folder", fix=f"It is the masks of image {number} in {path.name}")
    which = entry.get("object", 0)
    read_masks = masks.read(source, tuple(map(str, entry.get("labels", tree.names))), which)
    rename = entry.get("rename", {})
    labels = _renamed(path, source, read_masks, rename, tree, which)
    dropped = {
        part: int((read_masks.labels == number).sum())
        for number, part in enumerate(read_masks.names, start=1)
        if rename.get(part) == ""
    }
    picture, shown = _picture(path, entry, labels.shape)
    aspects = _aspects(path, where, entry.get("aspects"), tree)
    name = entry.get("name", source.stem)
    image = PartImage(name, labels, view, pose == "reference", aspects, picture, dropped)
    return image, [source, *shown]


def _view(path: Path, where: str, given: str | list | None) -> str | None:
    """The word for the view that an image has; FormatError for an unknown name and for what are no angles."""
    if isinstance(given, list):
        try:
            if len(given) == 2 and all(type(angle) in (int, float) for angle in given):
                return by_angles(*map(float, given))
        except (ValueError, OverflowError):
            pass
        expected = "azimuth (-360 to 360) and elevation (-90 to 90) in degrees, such as [40, 15]"
        raise FormatError(path, f"{where}view", expected=expected, got=given)
    if given is not None and given not in NAMED:
        raise FormatError(path, f"{where}unknown view '{given}'{nearest(given, NAMED)}")
    return given


def _renamed(
    path: Path, source: Path, found: masks.Masks, rename: Mapping[str, Any], tree: PartTree, which: int
) -> np.ndarray:
    """Labels of a file as numbers of the tree's parts."""
    table = np.zeros(len(found.names) + 1, np.int16)
    present = set(np.unique(found.labels).tolist())
    unknown = {}
    for number, name in enumerate(found.names, start=1):
        part = rename.get(name, name)
        if part in tree.names:
            table[number] = tree.names.index(part) + 1
        elif part and number in present:
            unknown[name] = part
    if unknown:
        known = nearest(str(next(iter(unknown.values()))), tree.names) if len(unknown) == 1 else ""
        what = ", ".join(f"'{part}'" for part in unknown.values())
        said = f"unknown part{'s' if len(unknown) > 1 else ''} {what}{masks.object_told(source, which)}{known}"
        raise FormatError(source, said, fix=_naming(path, list(unknown), tree))
    labels = table[found.labels]
    if not labels.any():
        raise FormatError(source, "shows no part", expected=", ".join(tree.names))
    return labels


def _naming(path: Path, unknown: Sequence[str], tree: PartTree) -> str:
    """How to name parts that the project does not know."""
    root = tree.names[tree.parents.index(NONE)]
    table = ", ".join(f'"{name}" = "{root if name == REST else "PART"}"' for name in unknown)
    rest = f"; '{REST}' is what no part of the object covers, mostly {root}" if REST in unknown else ""
    return f'Add to [parts], or say rename = {{ {table} }} in {path.name}; "" drops one{rest}'


def _picture(path: Path, entry: Mapping[str, Any], shape: tuple[int, int]) -> tuple[np.ndarray | None, list[Path]]:
    if "picture" not in entry:
        return None, []
    file = path.parent / entry["picture"]
    picture = images.read_image(file)
    if picture.shape[:2] != shape:
        raise FormatError(file, "another size than its masks", expected=shape, got=picture.shape[:2])
    return picture, [file]


def _aspects(path: Path, where: str, names: Any, tree: PartTree) -> tuple[int, ...] | None:
    if names is None:
        return None
    for name in names:
        if name not in tree.names:
            raise FormatError(path, f"{where}aspects: unknown part '{name}'{nearest(str(name), tree.names)}")
    return tuple(tree.names.index(name) for name in names)


def _matches(path: Path, entry: Any, tree: PartTree, pictures: Sequence[PartImage]) -> PartMatches:
    where = "matches: "
    if not isinstance(entry, dict):
        raise FormatError(path, f"{where}not a section [[matches]]")
    _check_keys(path, entry, MATCHES, where)
    part, shown = entry.get("part", ""), entry.get("images", [])
    if part not in tree.names:
        raise FormatError(path, f"{where}unknown part '{part}'{nearest(part, tree.names)}")
    shapes = {image.name: image.labels.shape for image in pictures}
    if len(shown) != 2 or shown[0] == shown[1] or not all(name in list(shapes) for name in shown):
        raise FormatError(path, f"{where}two images of {', '.join(shapes)}", got=shown)
    rows = entry.get("points", [])
    if not all(isinstance(row, list) and [type(x) in (int, float) for x in row] == [True] * 4 for row in rows):
        raise FormatError(path, f"{where}points of {part}", expected="[column, row, column, row] each", got=rows)
    points = np.array(rows, np.float64).reshape(-1, 2, 2)
    within = [[0 <= x < shapes[name][1] and 0 <= y < shapes[name][0] for name, (x, y) in zip(shown, pair, strict=True)]
              for pair in points]  # fmt: skip
    if not np.all(within):
        place = rows[int(np.flatnonzero(~np.all(within, axis=1))[0])]
        raise FormatError(path, f"{where}points of {part}", expected="places within both images", got=place)
    if min(len(np.unique(points[:, k], axis=0)) for k in (0, 1)) < LEAST_MATCHES:
        expected = f"{LEAST_MATCHES} or more different ones of [column, row, column, row]"
        raise FormatError(path, f"{where}points of {part}", expected=expected, got=len(rows))
    return PartMatches(tree.names.index(part), (shown[0], shown[1]), points)
