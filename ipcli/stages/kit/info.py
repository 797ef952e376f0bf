"""What a file of ipcli holds, told without reading its measurements."""

from __future__ import annotations

import dataclasses
from collections import Counter
from pathlib import Path
from typing import Any

from ipcli.errors import FormatError
from ipcli.io.files import h5, ply

MOST_VALUES = 20  # of a field of text that are told


def run(path: Path) -> dict[str, Any]:
    """A description ready for JSON: of an HDF5 artefact its kind, datasets, texts and provenance; of a PLY file its
    elements.

    Raises FormatError for any other file.
    """
    describe = {".ply": _ply, ".h5": _artefact}.get(path.suffix.lower())
    if describe is None:
        raise FormatError(
            path, "not a file that info describes", expected=".h5 or .ply", got=path.suffix or "no suffix"
        )
    return {"file": str(path)} | describe(path)


def _artefact(path: Path) -> dict[str, Any]:
    header = h5.peek(path)
    return dataclasses.asdict(header) | {"texts": _texts(path, header)}


def _texts(path: Path, header: h5.ArtefactHeader) -> dict[str, Any]:
    """Of each field of text how many values differ, and how often each of the first of them is there: actions, people,
    outcomes, names. Nothing of a file whose texts are unsound, which its header tells all the same.
    """
    wanted = {name for name, described in header.datasets.items() if described.dtype == "str"}
    try:
        arrays = h5.read(path, header.kind, wanted.__contains__).arrays
    except FormatError:
        return {}
    counts = {name: Counter(array.ravel().tolist()) for name, array in arrays.items()}
    return {
        name: {"distinct": len(found), "values": dict(list(found.items())[:MOST_VALUES])}
        for name, found in counts.items()
    }


def _ply(path: Path) -> dict[str, Any]:
    header = ply.header(path)
    elements = {
        name: {"count": count, "properties": dict(properties)} for name, (count, properties) in header.elements.items()
    }
    return {"kind": "ply", "format": header.format, "elements": elements, "comments": list(header.comments)}
