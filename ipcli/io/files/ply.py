"""PLY meshes and clouds with named extra properties. Own code, because the libraries drop or merge attributes, and some
read a truncated mesh as an empty one. Written: binary little-endian. Read: that and ASCII, triangles only, every count
checked.
"""

from __future__ import annotations

import io
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ipcli.errors import FormatError, IpcliError
from ipcli.inputs import check_file
from ipcli.io.files import atomic
from ipcli.io.files.text import whole

POSITION, NORMAL, COLOUR = ("x", "y", "z"), ("nx", "ny", "nz"), ("red", "green", "blue")
TYPES = {
    "char": "i1",
    "uchar": "u1",
    "short": "<i2",
    "ushort": "<u2",
    "int": "<i4",
    "uint": "<u4",
    "float": "<f4",
    "double": "<f8",
}
ALIASES = {
    "int8": "i1",
    "uint8": "u1",
    "int16": "<i2",
    "uint16": "<u2",
    "int32": "<i4",
    "uint32": "<u4",
    "float32": "<f4",
    "float64": "<f8",
}
NAMES = {np.dtype(code): name for name, code in TYPES.items()}
FORMATS = ("binary_little_endian", "ascii")
END = b"end_header\n"


@dataclass(frozen=True, eq=False)
class Ply:
    """A cloud, or with `faces` a mesh. `extra`: further scalars of each vertex by name."""

    vertices: np.ndarray  # (n, 3) float32 or float64
    faces: np.ndarray | None = None  # (m, 3) int32
    normals: np.ndarray | None = None  # (n, 3), of the dtype of the vertices when written
    colors: np.ndarray | None = None  # (n, 3) uint8
    extra: dict[str, np.ndarray] = field(default_factory=dict)  # (n,) each
    comments: tuple[str, ...] = ()


@dataclass(frozen=True)
class PlyHeader:
    """What the header declares: per element its count and `(property, type code)`; a list has the pair of its types."""

    format: str
    elements: dict[str, tuple[int, tuple[tuple[str, Any], ...]]]
    comments: tuple[str, ...]
    size: int  # bytes of the header


def write(
    path: Path,
    vertices: np.ndarray,
    *,
    faces: np.ndarray | None = None,
    normals: np.ndarray | None = None,
    colors: np.ndarray | None = None,
    extra: Mapping[str, np.ndarray] | None = None,
    comments: Sequence[str] = (),
) -> None:
    """Write atomically. float32 vertices are stored as float, all others as double; extras in the type they have.

    Raises IpcliError for shapes that disagree, face indices out of range, or a type or name that PLY does not have.
    """
    band = vertex_table(path, vertices, normals, colors, extra)
    parts = None if faces is None else [np.asarray(faces)]
    write_bands(path, [band], (len(band), 0 if faces is None else len(faces)), parts, comments)


def write_bands(
    path: Path,
    bands: Iterable[np.ndarray],
    counts: tuple[int, int],
    faces: Iterable[np.ndarray] | None,
    comments: Sequence[str],
) -> None:
    """Write atomically what comes in parts: tables of vertices as `vertex_table` makes them, and triangles into all
    vertices. `counts` says how many of both there are; IpcliError if there are not, and as `write`.
    """
    found = [0, 0]
    with atomic.replacing(path) as draft, draft.open("wb") as stream:
        for band in bands:
            if not stream.tell():
                stream.write(_header_text(path, band.dtype, counts, faces is not None, comments))
            stream.write(band.tobytes())
            found[0] += len(band)
        for part in faces or ():
            stream.write(_pack_faces(path, part, counts[0]).tobytes())
            found[1] += len(part)
        if tuple(found) != counts:
            raise IpcliError(f"{path}: expected {counts} vertices and faces, got {tuple(found)}")


def vertex_table(
    path: Path,
    vertices: np.ndarray,
    normals: np.ndarray | None = None,
    colors: np.ndarray | None = None,
    extra: Mapping[str, np.ndarray] | None = None,
) -> np.ndarray:
    """Vertices (n, 3) and what belongs to them as a structured array (n,); IpcliError as `write`."""
    vertices = _floats(vertices)
    columns = dict(zip(POSITION, vertices.T, strict=True))
    if normals is not None:
        columns |= zip(NORMAL, np.asarray(normals, vertices.dtype).T, strict=True)
    if colors is not None:
        columns |= zip(COLOUR, np.asarray(colors, np.uint8).T, strict=True)
    for name, values in (extra or {}).items():
        columns[_new_name(path, name, columns)] = np.asarray(values)
    return _table(path, columns, len(vertices))


def _floats(vertices: np.ndarray) -> np.ndarray:
    vertices = np.asarray(vertices)
    return vertices if vertices.dtype == np.float32 else vertices.astype(np.float64)


def _new_name(path: Path, name: str, taken: Mapping[str, Any]) -> str:
    if name in taken or not name.isascii() or name.split() != [name]:
        raise IpcliError(f"{path}: '{name}' cannot name an extra property; use one ASCII word that is not taken")
    return name


def _table(path: Path, columns: Mapping[str, np.ndarray], count: int) -> np.ndarray:
    for name, values in columns.items():
        if values.shape != (count,) or values.dtype.newbyteorder("<") not in NAMES:
            got = f"{values.dtype} of shape {values.shape}"
            raise IpcliError(f"{path}: property {name}: expected ({count},) of a PLY type, got {got}")
    table = np.empty(count, dtype=[(name, values.dtype.newbyteorder("<")) for name, values in columns.items()])
    for name, values in columns.items():
        table[name] = values
    return table


def _pack_faces(path: Path, faces: np.ndarray, count: int) -> np.ndarray:
    if faces.ndim != 2 or faces.shape[1] != 3 or faces.dtype.kind not in "iu":
        raise IpcliError(f"{path}: faces: expected (m, 3) integers, got {faces.dtype} of shape {faces.shape}")
    if faces.size and (faces.min() < 0 or faces.max() >= count):
        raise IpcliError(f"{path}: faces: indices from {faces.min()} to {faces.max()}, but there are {count} vertices")
    packed = np.empty(len(faces), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    packed["count"], packed["corners"] = 3, faces
    return packed


def _header_text(
    path: Path, vertex: np.dtype, counts: tuple[int, int], has_faces: bool, comments: Sequence[str]
) -> bytes:
    lines = ["ply", "format binary_little_endian 1.0", *(f"comment {_escaped(text)}" for text in comments)]
    lines += [
        f"element vertex {counts[0]}",
        *(f"property {NAMES[vertex[name]]} {name}" for name in vertex.names or ()),
    ]
    if has_faces:
        lines += [f"element face {counts[1]}", "property list uchar int vertex_indices"]
    if any("\n" in line or not line.isascii() for line in lines):
        raise IpcliError(f"{path}: comments of a PLY file are single lines of ASCII")
    return "\n".join(lines).encode() + b"\n" + END


def _escaped(text: str) -> str:
    """The text with what a PLY header cannot hold written as Python would: a unit of µm is no reason to lose a mesh."""
    return text.encode("ascii", "backslashreplace").decode("ascii")


def header(path: Path) -> PlyHeader:
    """What the file declares, its data not read. Raises FormatError."""
    return _header(path, _bytes(path))


def read(path: Path) -> Ply:
    """The cloud or mesh at `path`. FormatError unless the file is of exactly the size that its header declares, faces
    are triangles of existing vertices, and vertices have x, y, z.
    """
    data = _bytes(path)
    declared = _header(path, data)
    vertex_count, vertex_properties = declared.elements.get("vertex", (0, ()))
    names = [name for name, _ in vertex_properties]
    if not set(POSITION) <= set(names) or len(set(names)) != len(names):
        raise FormatError(
            path, "no usable vertices", expected="properties x, y, z, none twice", got=", ".join(names) or "none"
        )
    try:
        tables = _ascii(path, data, declared) if declared.format == "ascii" else _binary(path, data, declared)
    except (ValueError, OverflowError, MemoryError) as error:
        raise FormatError(path, f"data do not fit the header: {error}") from error
    return _assemble(path, tables["vertex"], tables.get("face"), vertex_count, declared.comments)


def _bytes(path: Path) -> bytes:
    check_file(path)
    try:
        return Path(path).read_bytes()
    except OSError as error:
        raise FormatError(path, f"cannot be read: {error.strerror}") from error


def _header(path: Path, data: bytes) -> PlyHeader:
    end = data.find(END)
    if not data.startswith(b"ply\n") or end < 0:
        raise FormatError(path, "not a PLY file, or its header is cut", expected="ply ... end_header", got=data[:12])
    lines = [line.split() for line in data[:end].decode("latin-1").splitlines()[1:]]
    elements: dict[str, tuple[int, tuple]] = {}
    form, comments, current = "", [], ""
    for words in lines:
        match words:
            case ["format", name, "1.0"] if name in FORMATS:
                form = name
            case ["comment", *text]:
                comments.append(" ".join(text))
            case ["element", "vertex" | "face" as current, number] if (
                current not in elements and whole(number) is not None
            ):
                elements[current] = (int(number), ())
            case ["property", *kinds, name] if current and (code := _type_code(kinds, current)):
                count, properties = elements[current]
                elements[current] = (count, (*properties, (name, code)))
            case [] | ["obj_info", *_]:
                continue
            case _:
                raise FormatError(
                    path, f"header line not understood: {' '.join(words)}", fix="Save it as little-endian or ASCII PLY"
                )
    if not form:
        raise FormatError(path, "the header names no format", expected=" or ".join(FORMATS))
    return PlyHeader(form, elements, tuple(comments), end + len(END))


def _type_code(kinds: Sequence[str], element: str) -> Any:
    """numpy code of a vertex scalar, or the pair of codes of a face list; None for what neither may have."""
    is_list = kinds[:1] == ["list"]
    if is_list != (element == "face") or len(kinds) != (3 if is_list else 1):
        return None
    codes = tuple((TYPES | ALIASES).get(kind, "") for kind in kinds[1:] or kinds)
    if "" in codes or (is_list and any("f" in code for code in codes)):
        return None
    return codes if is_list else codes[0]


def _dtypes(path: Path, declared: PlyHeader) -> dict[str, np.dtype]:
    """Record types of the elements in order of the file; a face is one list of three."""
    dtypes = {}
    for element, (_, properties) in declared.elements.items():
        if element == "vertex":
            dtypes[element] = np.dtype(list(properties))
        elif len(properties) == 1:
            counter, index = properties[0][1]
            dtypes[element] = np.dtype([("count", counter), ("corners", index, 3)])
        else:
            raise FormatError(
                path, "faces with several properties", expected="the vertex indices only", got=len(properties)
            )
    return dtypes


def _binary(path: Path, data: bytes, declared: PlyHeader) -> dict[str, np.ndarray]:
    dtypes = _dtypes(path, declared)
    expected = declared.size + sum(declared.elements[element][0] * dtype.itemsize for element, dtype in dtypes.items())
    if len(data) != expected:
        raise FormatError(
            path, "truncated, too long, or not all triangles", expected=f"{expected} bytes", got=len(data)
        )
    tables, offset = {}, declared.size
    for element, dtype in dtypes.items():
        tables[element] = np.frombuffer(data, dtype, declared.elements[element][0], offset)
        offset += tables[element].nbytes
    return tables


def _ascii(path: Path, data: bytes, declared: PlyHeader) -> dict[str, np.ndarray]:
    dtypes = _dtypes(path, declared)
    lines = [line for line in data[declared.size :].decode("latin-1").splitlines() if line.strip()]
    expected = sum(declared.elements[element][0] for element in dtypes)
    if len(lines) != expected:
        raise FormatError(path, "truncated or too long", expected=f"{expected} lines of data", got=len(lines))
    tables, start = {}, 0
    for element, dtype in dtypes.items():
        count = declared.elements[element][0]
        flat = np.dtype([(f"{index}", code) for index, code in enumerate(_flat_codes(dtype))])
        text = io.StringIO("\n".join(lines[start : start + count]))
        rows = np.loadtxt(text, flat, ndmin=1, comments=None) if count else np.empty(0, flat)
        tables[element] = rows.view(dtype)
        start += count
    return tables


def _flat_codes(dtype: np.dtype) -> list[np.dtype]:
    parts = [dtype[name] for name in dtype.names or ()]
    return [part.base for part in parts for _ in range(int(np.prod(part.shape)))]


def _assemble(
    path: Path, table: np.ndarray, triangles: np.ndarray | None, count: int, comments: tuple[str, ...]
) -> Ply:
    names = table.dtype.names or ()
    faces = None
    if triangles is not None:
        faces = np.ascontiguousarray(triangles["corners"])
        if (triangles["count"] != 3).any():
            raise FormatError(path, "faces that are not triangles", fix="Triangulate the mesh first")
        if faces.size and (faces.min() < 0 or faces.max() >= count):
            raise FormatError(path, "faces of missing vertices", expected=f"indices below {count}", got=faces.max())
        faces = faces.astype(np.int32)
    groups = {group: _stack_columns(table, group) for group in (POSITION, NORMAL, COLOUR) if set(group) <= set(names)}
    used = {name for group in groups for name in group}
    extra = {name: np.ascontiguousarray(table[name]) for name in names if name not in used}
    return Ply(groups[POSITION], faces, groups.get(NORMAL), groups.get(COLOUR), extra, comments)


def _stack_columns(table: np.ndarray, group: Sequence[str]) -> np.ndarray:
    return np.stack([table[name] for name in group], axis=1)
