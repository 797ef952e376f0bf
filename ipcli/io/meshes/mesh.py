"""Triangle meshes of any origin: what others wrote, with lost counts and odd faces. Our own go through io.files.ply."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ipcli.errors import FormatError
from ipcli.inputs import warn_if_cut
from ipcli.memory import told

SUFFIXES = (".ply", ".obj", ".off")
JOINED = (*SUFFIXES, ".stl", ".glb")
TEXT = (".obj", ".off")
MOST_BYTES = 2_000_000_000  # of a mesh file


def read(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (n, 3) float64 and triangles (m, 3) int64 as they are in the file; several objects as one.

    Raises FormatError for another suffix, a file that cannot be parsed, one without faces, and vertices that are not
    finite.
    """
    path = _checked(Path(path), SUFFIXES)
    vertices, faces = _parse(path)
    if not len(faces):
        raise FormatError(path, "holds no triangles", fix="Give a mesh, not a cloud of points")
    if not np.isfinite(vertices).all():
        raise FormatError(path, "holds vertices that are not finite", fix="Remove them")
    return vertices, faces


def _checked(path: Path, suffixes: tuple[str, ...]) -> Path:
    """The path, unless it is no file of these suffixes or too large a one: then FormatError."""
    if path.suffix.lower() not in suffixes:
        got = path.suffix or "no suffix"
        raise FormatError(path, "not a mesh", expected=" or ".join(suffixes), got=got, fix="Convert it")
    if not path.is_file():
        raise FormatError(path, "no such file", fix="Check the path")
    if path.stat().st_size > MOST_BYTES:
        size = told(path.stat().st_size)
        raise FormatError(path, "too large a mesh", expected=f"at most {told(MOST_BYTES)}", got=size, fix="Decimate it")
    return path


def _check_off(text: str) -> None:
    """ValueError for an OFF file of other lines than its counts ask for, or a face of fewer corners than it says, which
    trimesh takes as they are.
    """
    lines = [line for line in (line.partition("#")[0].strip() for line in text.splitlines()) if line]
    first = lines[0].removeprefix("C").removeprefix("OFF").split() or lines.pop(1).split()
    vertices, faces = (int(number) for number in first[:2])
    if len(lines) - 1 != vertices + faces:
        raise ValueError(f"{vertices} vertices and {faces} faces are said, but {len(lines) - 1} lines are there")
    for line in lines[1 + vertices :]:
        count, *corners = line.split()
        if len(corners) < int(count):
            raise ValueError(f"a face of {count} corners with {len(corners)} numbers")


def _parse(path: Path) -> tuple[np.ndarray, np.ndarray]:
    import trimesh

    suffix = path.suffix.lower()
    text = path.read_bytes().decode("latin-1") if suffix in TEXT else ""
    try:
        if suffix == ".off":
            _check_off(text)
        mesh: Any = trimesh.load(path, process=False, force="mesh", skip_materials=True)
        vertices, faces = np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int64)
    except Exception as error:  # trimesh lets out whatever its parsers stumble over
        raise FormatError(
            path, f"cannot be read ({type(error).__name__}: {error})", fix="Check that the file is whole"
        ) from error
    if len(faces) and (faces.min() < 0 or faces.max() >= len(vertices)):
        raise FormatError(path, "a face names a vertex that is not there", fix="Check that the file is whole")
    if text:
        warn_if_cut(path, text[-1:])
    return vertices, faces


def read_joined(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (n, 3) float64 and triangles (m, 3) of a mesh in JOINED: all objects as one, equal vertices joined
    and triangles without an extent left out, as printers and viewers do. Raises FormatError.
    """
    path = _checked(Path(path), JOINED)
    vertices, faces = _parse(path)
    if not len(faces) or not np.isfinite(vertices).all():
        raise FormatError(
            path, "holds no triangles, or vertices that are not finite", fix="Check that the file is whole"
        )
    _, first, joined = np.unique(vertices, axis=0, return_index=True, return_inverse=True)
    faces = joined.reshape(-1)[faces]
    a, b, c = faces.T
    return vertices[first], faces[(a != b) & (b != c) & (c != a)]
