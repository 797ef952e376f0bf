"""What a file of ipcli holds, told without reading its data."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

from ipcli.errors import FormatError
from ipcli.io.files import h5, ply


def run(path: Path) -> dict[str, Any]:
    """A description ready for JSON: of an HDF5 artefact its kind, datasets and provenance; of a PLY file its elements.

    Raises FormatError for any other file.
    """
    describe = {".ply": _ply, ".h5": _artefact}.get(path.suffix.lower())
    if describe is None:
        raise FormatError(
            path, "not a file that info describes", expected=".h5 or .ply", got=path.suffix or "no suffix"
        )
    return {"file": str(path)} | describe(path)


def _artefact(path: Path) -> dict[str, Any]:
    return dataclasses.asdict(h5.peek(path))


def _ply(path: Path) -> dict[str, Any]:
    header = ply.header(path)
    elements = {
        name: {"count": count, "properties": dict(properties)} for name, (count, properties) in header.elements.items()
    }
    return {"kind": "ply", "format": header.format, "elements": elements, "comments": list(header.comments)}
