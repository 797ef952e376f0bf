"""Triangle meshes of any origin, PLY or OBJ: what others wrote, with lost counts and odd faces. Our own go through
io.files.ply.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ipcli.errors import FormatError
from ipcli.inputs import warn_if_cut

SUFFIXES = (".ply", ".obj")


def read(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (n, 3) float64 and triangles (m, 3) int64 as they are in the file; several objects as one.

    Raises FormatError for another suffix, a file that cannot be parsed, one without faces, and vertices that are not
    finite.
    """
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES:
        raise FormatError(
            path, "not a mesh", expected=" or ".join(SUFFIXES), got=path.suffix or "no suffix", fix="Convert it"
        )
    vertices, faces = _parse(path)
    if not len(faces):
        raise FormatError(path, "holds no triangles", fix="Give a mesh, not a cloud of points")
    if not np.isfinite(vertices).all():
        raise FormatError(path, "holds vertices that are not finite", fix="Remove them")
    return vertices, faces


def _parse(path: Path) -> tuple[np.ndarray, np.ndarray]:
    import trimesh

    try:
        mesh: Any = trimesh.load(path, process=False, force="mesh", skip_materials=True)
        vertices, faces = np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int64)
    except Exception as error:  # trimesh lets out whatever its parsers stumble over
        raise FormatError(
            path, f"cannot be read ({type(error).__name__}: {error})", fix="Check that the file is whole"
        ) from error
    if len(faces) and (faces.min() < 0 or faces.max() >= len(vertices)):
        raise FormatError(path, "a face names a vertex that is not there", fix="Check that the file is whole")
    if path.suffix.lower() == ".obj":
        warn_if_cut(path, path.read_bytes()[-1:].decode("latin-1"))
    return vertices, faces


JOINED = (".ply", ".obj", ".stl", ".glb")
MOST_BYTES = 2_000_000_000  # of a mesh file


def read_joined(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (n, 3) float64 and triangles (m, 3) of PLY, OBJ, STL or GLB: all objects as one, equal vertices joined
    and triangles without an extent left out, as printers and viewers do. Raises FormatError.
    """
    path = Path(path)
    if path.suffix.lower() not in JOINED:
        raise FormatError(
            path, "not a mesh", expected=" ".join(JOINED), got=path.suffix or "no suffix", fix="Convert it"
        )
    if not path.is_file() or path.stat().st_size > MOST_BYTES:
        raise FormatError(path, "no file, or too large", expected=f"at most {MOST_BYTES} bytes", fix="Check the path")
    vertices, faces = _parse(path)
    if not len(faces) or not np.isfinite(vertices).all():
        raise FormatError(
            path, "holds no triangles, or vertices that are not finite", fix="Check that the file is whole"
        )
    _, first, joined = np.unique(vertices, axis=0, return_index=True, return_inverse=True)
    faces = joined.reshape(-1)[faces]
    a, b, c = faces.T
    return vertices[first], faces[(a != b) & (b != c) & (c != a)]
