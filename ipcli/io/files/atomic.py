"""The only writer: a file appears whole under its name or not at all, whenever the process is killed."""

from __future__ import annotations

import os
import re
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

ORPHAN = re.compile(r"\..+\.\d+\.tmp")
DAY = 86400.0  # seconds


@contextmanager
def replacing(path: Path, *, durable: bool = True) -> Iterator[Path]:
    """A private name in the folder of `path` (made if need be); what is written there replaces `path` at the end.

    Unless `durable` the disk is not waited for: a kill still does no harm, but after a power cut the file may be
    damaged. After an exception the temporary file is gone and `path` is as it was; after a kill `sweep` finds the
    orphan.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        yield temporary
        if durable:
            _flush(temporary)
        os.replace(temporary, path)
        if durable:
            _flush(path.parent)
    finally:
        with suppress(FileNotFoundError):
            temporary.unlink()


def _flush(path: Path) -> None:
    """Wait until a file, or the names in a folder, are on the disk."""
    if os.name == "nt" and path.is_dir():
        return  # Windows has no handle on a folder to flush
    descriptor = os.open(path, os.O_RDWR if os.name == "nt" else os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def write_bytes(path: Path, data: bytes) -> None:
    """Put `data` at `path`."""
    with replacing(path) as temporary:
        temporary.write_bytes(data)


def write_text(path: Path, text: str) -> None:
    """Put `text` at `path` as UTF-8 with plain newlines."""
    write_bytes(path, text.encode("utf-8"))


def sweep(folder: Path) -> None:
    """Remove temporary files that killed runs left in `folder` more than a day ago."""
    if not folder.is_dir():
        return
    oldest = time.time() - DAY
    for entry in folder.iterdir():
        with suppress(FileNotFoundError):  # another process may sweep too
            if ORPHAN.fullmatch(entry.name) and entry.is_file() and entry.stat().st_mtime < oldest:
                entry.unlink()
