"""Files without a name, for arrays that do not fit into the memory: they are gone with the process, however it ends."""

from __future__ import annotations

import tempfile
import threading
from collections.abc import Hashable
from contextlib import ExitStack
from pathlib import Path
from typing import BinaryIO

import numpy as np

STRIP = 1 << 20  # bytes that are read at once


class ScratchFiles:
    """Arrays (h, w) of one dtype each by their keys, on the disk of a folder; a context manager."""

    def __init__(self, folder: Path):
        self._folder, self._lock, self._files = folder, threading.Lock(), ExitStack()
        self._held: dict[Hashable, tuple[BinaryIO, tuple[int, int], np.dtype]] = {}

    def __enter__(self) -> ScratchFiles:
        self._folder.mkdir(parents=True, exist_ok=True)
        return self

    def __exit__(self, *error: object) -> None:
        self._files.close()
        self._held.clear()

    def __contains__(self, key: Hashable) -> bool:
        return key in self._held

    def put(self, key: Hashable, array: np.ndarray) -> None:
        """Keep an array; one that is there under that key stays. OSError names the folder when its disk is full."""
        file = self._files.enter_context(tempfile.TemporaryFile(dir=self._folder))  # noqa: SIM115 (the stack closes it)
        try:
            file.write(np.ascontiguousarray(array).data)
            file.flush()
        except OSError as error:  # a full disk, which the file without a name does not name
            raise OSError(error.errno, error.strerror, str(self._folder)) from error
        with self._lock:
            self._held.setdefault(key, (file, array.shape, array.dtype))

    def get(self, key: Hashable, rows: slice = slice(None), columns: slice = slice(None)) -> np.ndarray:
        """That rectangle of an array, read in strips of rows; slices may reach over its end."""
        file, (h, w), dtype = self._held[key]
        (top, bottom, _), (left, right, _) = rows.indices(h), columns.indices(w)
        out = np.empty((bottom - top, right - left), dtype)
        step = max(STRIP // (w * dtype.itemsize), 1)
        for at in range(top, bottom, step):
            count = min(step, bottom - at)
            with self._lock:
                file.seek(at * w * dtype.itemsize)
                strip = file.read(count * w * dtype.itemsize)
            out[at - top : at - top + count] = np.frombuffer(strip, dtype).reshape(count, w)[:, left:right]
        return out
