"""PASCAL-Part annotations (.mat; Chen et al., CVPR 2014), parsed in a process of its own: a damaged file can crash the
parser or make it ask for all memory.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ipcli.errors import FormatError
from ipcli.io.files.guarded import ParserFailed, guarded
from ipcli.memory import told

REST = "rest"  # the part that is left of an object
MOST_NAMED = 20  # objects that a message names
MOST_BYTES = 200_000_000  # of the file
MOST_MEMORY = 2_000_000_000  # that its parser may ask for


def read(path: Path, which: int = 0) -> tuple[tuple[str, ...], np.ndarray]:
    """Names of the parts of object number `which` and its labels (h, w) int16; smaller parts lie on larger ones, and
    what no part covers of the object is "rest". Raises FormatError, which lists the objects if there is none such.
    """
    classes, found = _parsed(path, which)
    if found is None:
        what = f"has no object {which}; it holds {counted(classes)}"
        raise FormatError(path, what, fix="Objects count from 0: say object = NUMBER")
    return found


def objects(path: Path) -> tuple[str, ...]:
    """What each object of the file is, such as "person", in the order of their numbers. Raises FormatError."""
    return _parsed(path, -1)[0]


def counted(classes: Sequence[str]) -> str:
    """Objects by their numbers, `0 person, 1 horse`, no more than a message can hold."""
    listed = ", ".join(f"{number} {name}" for number, name in enumerate(classes[:MOST_NAMED]))
    return listed + (f" and {len(classes) - MOST_NAMED} more" if len(classes) > MOST_NAMED else "")


def _parsed(path: Path, which: int) -> tuple[tuple[str, ...], tuple[tuple[str, ...], np.ndarray] | None]:
    if not path.is_file():
        raise FormatError(path, "no such file", fix="Check the path")
    if path.stat().st_size > MOST_BYTES:
        raise FormatError(path, "too large for annotations", expected=f"at most {told(MOST_BYTES)}")
    try:
        return guarded(parse, str(path), which, memory=MOST_MEMORY)
    except ParserFailed as error:
        raise FormatError(path, f"not PASCAL-Part annotations ({error})", fix="Copy it again") from None


def parse(path: str, which: int) -> tuple[tuple[str, ...], tuple[tuple[str, ...], np.ndarray] | None]:
    """The class of each object, and names and labels of object `which` if it is there; in the child. Raises whatever
    the parser stumbles over.
    """
    from scipy.io import loadmat

    content = loadmat(path, struct_as_record=False, squeeze_me=True)
    things = np.atleast_1d(content["anno"].objects)
    classes = tuple(str(getattr(thing, "class", "?")) for thing in things)
    return classes, _labels(things[which]) if 0 <= which < len(things) else None


def _labels(thing) -> tuple[tuple[str, ...], np.ndarray]:
    whole = np.asarray(thing.mask) > 0
    masks = {str(part.part_name): np.asarray(part.mask) > 0 for part in np.atleast_1d(thing.parts)}
    order = sorted(masks, key=lambda name: -int(masks[name].sum()))
    labels = np.where(whole, np.int16(len(order) + 1), np.int16(0))
    for number, name in enumerate(order, start=1):
        labels[masks[name]] = number
    return (*order, REST), labels
