"""HDF5 artefacts of the registered kinds. A file is trusted in nothing: marks, names, sizes, checksums, dtypes, values.

The 1.8 file layout is used because it checksums its metadata, so that a damaged file is refused and not misread. Text
is of fixed length: the heap of variable lengths has no checksum, and a flipped byte there can send HDF5 into an endless
loop.
"""

from __future__ import annotations

import io
import json
import zlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ipcli import memory, schema
from ipcli.errors import FormatError, IpcliError, VersionTooNew, VersionTooOld
from ipcli.inputs import check_file
from ipcli.io.files import atomic

LAYOUT = ("v108", "v108")
BLOCK = 1 << 22  # bytes by which a file in memory grows
IN_MEMORY = 1 << 27  # bytes: a larger artefact is written straight to the disk
DEFLATE_LIMIT = 1100  # deflate cannot expand further; a dataset that claims more is damaged
FIX = "Make it again, or check that the copy is complete"
# all that h5py is known to raise on damaged files
UNREADABLE = (OSError, RuntimeError, KeyError, ValueError, TypeError, AttributeError, OverflowError, MemoryError)


@dataclass(frozen=True, eq=False)
class Artefact:
    """What a file holds: text as numpy str arrays, everything else as the schema says."""

    kind: str
    version: int
    arrays: dict[str, np.ndarray]
    provenance: dict[str, Any]


@dataclass(frozen=True)
class Dataset:
    """What is known of a dataset without reading it."""

    shape: tuple[int, ...]
    dtype: str
    units: str
    doc: str


@dataclass(frozen=True)
class ArtefactHeader:
    """All of a file but the numbers."""

    kind: str
    version: int
    datasets: dict[str, Dataset]
    provenance: dict[str, Any]


def write(path: Path, kind_name: str, arrays: Mapping[str, np.ndarray], provenance: Mapping[str, Any]) -> None:
    """Write a whole artefact atomically; the same arguments give the same bytes.

    Raises schema.SchemaError when `arrays` do not make up this kind, IpcliError when the disk refuses.
    """
    import h5py

    kind = schema.kind(kind_name)
    schema.validate(kind, arrays)
    record = json.dumps(provenance, allow_nan=False)
    try:
        if sum(np.asarray(array).nbytes for array in arrays.values()) > IN_MEMORY:
            with atomic.replacing(path) as draft, draft.open("w+b", buffering=0) as disk:
                _write_to(ForgivingFile(disk), kind, arrays, record)
            return
        # HDF5 that is refused by a full disk half-way through takes the process down with it.
        with h5py.File(path.name, "w", libver=LAYOUT, driver="core", backing_store=False, block_size=BLOCK) as file:
            _fill(file, kind, arrays, record)
            file.flush()
            image = file.id.get_file_image()
        atomic.write_bytes(path, image)
    except OSError as error:
        raise IpcliError(f"{path}: cannot be written: {_one_line(error)}") from error


class ForgivingFile(io.RawIOBase):
    """A file on disk that keeps the first error of a write to itself, and takes the rest for written."""

    def __init__(self, disk: Any):
        self._disk = disk
        self.error: OSError | None = None

    def seek(self, offset: int, whence: int = 0) -> int:
        """Go to an offset."""
        return self._disk.seek(offset, whence)

    def tell(self) -> int:
        """The offset."""
        return self._disk.tell()

    def readinto(self, buffer: Any) -> int:
        """Read what was written."""
        return self._disk.readinto(buffer)

    def write(self, data: Any) -> int:
        """Write all of it, or nothing any more after an error."""
        try:
            rest = memoryview(data).cast("B")
            while self.error is None and len(rest):
                rest = rest[self._disk.write(rest) :]
        except OSError as error:
            self.error = error
        return memoryview(data).nbytes

    def truncate(self, size: int | None = None) -> int:
        """Cut or lengthen the file."""
        try:
            return self._disk.truncate(size)
        except OSError as error:
            self.error = self.error or error
            return size or 0


def _write_to(disk: ForgivingFile, kind: schema.Kind, arrays: Mapping[str, np.ndarray], record: str) -> None:
    """The artefact on a disk; the OSError of the first write that it refused."""
    import h5py

    try:
        with h5py.File(disk, "w", libver=LAYOUT) as file:
            _fill(file, kind, arrays, record)
    except Exception:  # what was taken for written cannot be read back
        if disk.error is None:
            raise
    if disk.error is not None:
        raise disk.error


def _fill(file: Any, kind: schema.Kind, arrays: Mapping[str, np.ndarray], record: str) -> None:
    _set_text(file, "ipcli_kind", kind.name)
    file.attrs["ipcli_version"] = kind.version
    _set_text(file, "provenance", record)
    for name in sorted(arrays):
        _write_dataset(file, name, kind.field(name)[0], np.asarray(arrays[name]))
    file.attrs["ipcli_complete"] = 1


def _write_dataset(file: Any, name: str, field: schema.Field, array: np.ndarray) -> None:
    import h5py

    if field.dtype == "str":
        encoded = np.char.encode(array, "utf-8")
        dtype = h5py.string_dtype("utf-8", max(encoded.dtype.itemsize, 1))
        dataset = file.create_dataset(name, data=encoded.astype(dtype), dtype=dtype, track_times=False)
    else:
        dense = array.dtype.kind in "iu" and array.ndim and array.size
        packing = {"compression": "gzip", "compression_opts": 1, "shuffle": True} if dense else {}
        dataset = file.create_dataset(name, data=array, track_times=False, **packing)
    _set_text(dataset, "units", field.units)
    _set_text(dataset, "dims", " ".join(map(str, field.dims)))
    _set_text(dataset, "description", field.doc)
    dataset.attrs["crc32"] = np.uint32(_checksum(array))


def _set_text(holder: Any, name: str, text: str) -> None:
    import h5py

    data = text.encode("utf-8")
    holder.attrs.create(name, data, dtype=h5py.string_dtype("utf-8", max(len(data), 1)))


def _attribute(holder: Any, name: str) -> Any:
    """An attribute, text decoded. ValueError for variable length, which must not even be looked at."""
    if holder.attrs.get_id(name).dtype.kind == "O":
        raise ValueError(f"attribute {name} is of variable length")
    value = holder.attrs[name]
    return value.decode("utf-8") if isinstance(value, bytes) else value


def _checksum(array: np.ndarray) -> int:
    if array.dtype.kind == "U":
        return zlib.crc32("".join(text + "\0" for text in array.flat).encode("utf-8"))
    return zlib.crc32(np.ascontiguousarray(array).data)


def read(path: Path, kind_name: str, only: Callable[[str], bool] | None = None) -> Artefact:
    """The artefact at `path`, or of it just the datasets whose name `only` accepts; those are fully checked.

    Raises FormatError (VersionTooNew, VersionTooOld) for anything that is not a sound file of this kind.
    """
    with _opened(path) as file:
        kind = _identified(path, file)
        if kind.name != kind_name:
            fix = f"Give an artefact of kind '{kind_name}'; 'ipcli info' tells what a file is"
            raise FormatError(path, "wrong kind of artefact", expected=kind_name, got=kind.name, fix=fix)
        present = _names(file)
        schema.check_names(kind, present)
        arrays = {name: _read_dataset(path, file, name) for name in present if only is None or only(name)}
        schema.check_arrays(kind, arrays)
        return Artefact(kind.name, kind.version, arrays, _provenance(path, file))


def peek(path: Path) -> ArtefactHeader:
    """What `path` holds, without reading the data. Raises FormatError as `read` does."""
    with _opened(path) as file:
        kind = _identified(path, file)
        present = _names(file)
        schema.check_names(kind, present)
        datasets = {name: _described(path, file, name, kind.field(name)[0]) for name in present}
        return ArtefactHeader(kind.name, kind.version, datasets, _provenance(path, file))


def names(path: Path) -> tuple[str, ...]:
    """Sorted names of the datasets in the artefact at `path`."""
    with _opened(path) as file:
        _identified(path, file)
        return tuple(_names(file))


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """The open file; whatever goes wrong inside becomes a FormatError of this path."""
    import h5py

    if not check_file(path).is_file():
        raise FormatError(path, "no such file")
    try:
        # complete files are never written again, so no lock is needed, and network disks often have none
        with h5py.File(path, "r", locking=False) as file:
            yield file
    except schema.SchemaError as error:
        raise FormatError(path, str(error), fix=FIX) from error
    except UNREADABLE as error:
        fix = FIX if path.suffix.lower() in (".h5", ".hdf5") else "Give an artefact that a command of ipcli wrote (.h5)"
        raise FormatError(path, f"not a readable HDF5 artefact: {_one_line(error)}", fix=fix) from error


def _one_line(error: BaseException) -> str:
    return " ".join(str(error).split()) or type(error).__name__


def _identified(path: Path, file: Any) -> schema.Kind:
    """The kind that the marks of a complete file name, of a version that is known."""
    if "ipcli_kind" not in file.attrs or "ipcli_version" not in file.attrs:
        raise FormatError(
            path, "an HDF5 file, but not an artefact of ipcli", fix="Only files written by ipcli can be read"
        )
    if "ipcli_complete" not in file.attrs or _attribute(file, "ipcli_complete") != 1:
        raise FormatError(path, "incomplete artefact", fix=FIX)
    kind, version = schema.kind(str(_attribute(file, "ipcli_kind"))), int(_attribute(file, "ipcli_version"))
    if version > kind.version:
        fix = "Update ipcli to read it"
        raise VersionTooNew(path, f"'{kind.name}' of a newer version", expected=kind.version, got=version, fix=fix)
    if version < kind.version:
        fix = "Make it again with this ipcli"
        raise VersionTooOld(path, f"'{kind.name}' of an older version", expected=kind.version, got=version, fix=fix)
    return kind


def _names(file: Any) -> list[str]:
    """Sorted names of datasets, and of groups that are empty (which the schema refuses).

    ValueError names a link to elsewhere, and a second name of one thing: an artefact has neither, and what h5py's own
    walk leaves out would be missed in silence.
    """
    import h5py

    found: list[str] = []
    seen = {h5py.h5o.get_info(file.id).addr}
    groups = [("", file)]
    while groups:
        prefix, group = groups.pop()
        if prefix and not len(group):
            found.append(prefix[:-1])
        for key in group:
            name = f"{prefix}{key}"
            _check_link(name, group.get(key, getlink=True))
            thing = group[key]
            address = h5py.h5o.get_info(thing.id).addr
            if address in seen:
                raise ValueError(f"{name} is a second name of something else in the file")
            seen.add(address)
            if isinstance(thing, h5py.Group):
                groups.append((f"{name}/", thing))
            else:
                found.append(name)
    return sorted(found)


def _check_link(name: str, link: Any) -> None:
    """ValueError for a soft or an external link."""
    import h5py

    if isinstance(link, h5py.ExternalLink):
        raise ValueError(f"{name} is a link to {link.path} in another file, {link.filename}")
    if isinstance(link, h5py.SoftLink):
        raise ValueError(f"{name} is a soft link to {link.path}")


def _dataset(path: Path, file: Any, name: str) -> Any:
    import h5py

    dataset = file[name]
    if not isinstance(dataset, h5py.Dataset) or dataset.shape is None or dataset.dtype.kind == "O":
        raise FormatError(path, f"{name} is not a plain array", fix=FIX)
    if dataset.external or dataset.is_virtual:
        raise FormatError(path, f"{name} lies in another file, which is not followed", fix=FIX)
    return dataset


def _read_dataset(path: Path, file: Any, name: str) -> np.ndarray:
    dataset = _dataset(path, file, name)
    if dataset.nbytes > DEFLATE_LIMIT * dataset.id.get_storage_size():
        raise FormatError(path, f"{name} claims more data than is stored", fix=FIX)
    memory.check(path, dataset.nbytes, f"{name} of shape {dataset.shape}")
    array = np.asarray(dataset[()])
    if array.dtype.kind == "S":
        array = np.char.decode(array, "utf-8")
    if _attribute(dataset, "crc32") != _checksum(array):
        raise FormatError(path, f"{name} is damaged: its checksum is not that of its data", fix=FIX)
    return array


def _described(path: Path, file: Any, name: str, field: schema.Field) -> Dataset:
    dataset = _dataset(path, file, name)
    dtype = "str" if dataset.dtype.kind == "S" else str(dataset.dtype)
    return Dataset(dataset.shape, dtype, field.units, field.doc)


def _provenance(path: Path, file: Any) -> dict[str, Any]:
    record = json.loads(_attribute(file, "provenance"))
    if not isinstance(record, dict):
        raise FormatError(path, "the provenance is not a JSON object", fix=FIX)
    return record
