"""PASCAL-Part annotations (.mat; Chen et al., CVPR 2014), parsed in a process of its own: a damaged file can crash the
parser or make it ask for all memory.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ipcli.errors import FormatError
from ipcli.io.files.guarded import ParserFailed, guarded
from ipcli.memory import told

MOST_NAMED = 20  # objects that a message names
MOST_BYTES = 200_000_000  # of the file
MOST_MEMORY = 2_000_000_000  # that its parser may ask for


def read(path: Path, which: int = 0) -> tuple[tuple[str, ...], np.ndarray]:
    """Names of the parts of object number `which` and its labels (h, w) int16; smaller parts lie on larger ones, and
    what no part covers of the object is "rest". Raises FormatError.
    """
    if not path.is_file():
        raise FormatError(path, "no such file", fix="Check the path")
    if path.stat().st_size > MOST_BYTES:
        raise FormatError(path, "too large for annotations", expected=f"at most {told(MOST_BYTES)}")
    try:
        return guarded(parse, str(path), which, memory=MOST_MEMORY)
    except ParserFailed as error:
        raise FormatError(path, f"not PASCAL-Part annotations ({error})", fix="Copy it again") from None


def parse(path: str, which: int) -> tuple[tuple[str, ...], np.ndarray]:
    """Names and labels of an object, in the child. Raises whatever the parser stumbles over."""
    from scipy.io import loadmat

    content = loadmat(path, struct_as_record=False, squeeze_me=True)
    objects = np.atleast_1d(content["anno"].objects)
    if not 0 <= which < len(objects):
        held = ", ".join(
            f"{number} {getattr(thing, 'class', '?')}" for number, thing in enumerate(objects[:MOST_NAMED])
        )
        raise ValueError(f"it holds {len(objects)} objects ({held}), number {which} is asked for")
    return _labels(objects[which])


def _labels(thing) -> tuple[tuple[str, ...], np.ndarray]:
    whole = np.asarray(thing.mask) > 0
    masks = {str(part.part_name): np.asarray(part.mask) > 0 for part in np.atleast_1d(thing.parts)}
    order = sorted(masks, key=lambda name: -int(masks[name].sum()))
    labels = np.where(whole, np.int16(len(order) + 1), np.int16(0))
    for number, name in enumerate(order, start=1):
        labels[masks[name]] = number
    return (*order, "rest"), labels
