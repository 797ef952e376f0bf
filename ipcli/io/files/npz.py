"""Flat sets of numeric arrays as NPZ. Nothing is pickled, written or read; the same arrays give the same bytes."""

from __future__ import annotations

import io
import struct
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from tokenize import TokenError

import numpy as np

from ipcli import memory
from ipcli.errors import FormatError, IpcliError
from ipcli.inputs import check_file
from ipcli.io.files import atomic

# all that zipfile and numpy.lib.format are known to raise on damaged files
UNREADABLE = (
    OSError, ValueError, EOFError, RuntimeError, KeyError, TypeError, SyntaxError, OverflowError, MemoryError,
    TokenError, struct.error, zipfile.BadZipFile, zlib.error,
)  # fmt: skip


def write(path: Path, arrays: Mapping[str, np.ndarray], *, durable: bool = True) -> None:
    """Write atomically, `durable` as in atomic.replacing. IpcliError for an array that is not numeric.

    numpy.savez is not used: it takes no array named `file` and stops half-way through at an object.
    """
    for name, array in arrays.items():
        if np.asarray(array).dtype.kind not in "biufc":
            raise IpcliError(f"{path}: {name} is of dtype {np.asarray(array).dtype}; NPZ holds numbers only")
    with atomic.replacing(path, durable=durable) as temporary, zipfile.ZipFile(temporary, "w") as archive:
        for name in sorted(arrays):
            with archive.open(zipfile.ZipInfo(f"{name}.npy"), "w", force_zip64=True) as stream:
                np.lib.format.write_array(stream, np.asarray(arrays[name]), allow_pickle=False)


def read(path: Path) -> dict[str, np.ndarray]:
    """All arrays by name, checksums verified. FormatError for what is not a sound NPZ of numbers, or does not fit into
    the memory.
    """
    check_file(path)
    try:
        with zipfile.ZipFile(path) as archive:
            sizes = [item.file_size for item in archive.infolist()]
            memory.check(path, sum(sizes) + max(sizes, default=0), "unpacked arrays")  # one is there as bytes, too
            return {name.removesuffix(".npy"): _array(archive.read(name)) for name in archive.namelist()}
    except UNREADABLE as error:
        raise FormatError(
            path, f"not a readable NPZ file: {error}", fix="Make it again with numeric arrays only"
        ) from error


def _array(data: bytes) -> np.ndarray:
    return np.lib.format.read_array(io.BytesIO(data), allow_pickle=False)
