"""The only writer: a file appears whole under its name or not at all, whenever the process is killed."""

from __future__ import annotations

import os
import re
import secrets
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

ORPHAN = re.compile(r"\..+\.[0-9a-f]{16}\.ipcli")
NAME = 200  # bytes of a file's name that its temporary name keeps: file systems allow 255 in all
DAY = 86400.0  # seconds


@contextmanager
def drafting(path: Path) -> Iterator[Path]:
    """A private name in the folder of `path` (made if need be), to write to and then to `publish`.

    It holds 64 random bits, so that no two runs share one, on whatever machines they are.
    What is there is gone at the end if it was not published; after a kill `sweep` finds the orphan.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    start = os.fsencode(path.name)[:NAME].decode(errors="ignore")
    draft = path.with_name(f".{start}.{secrets.token_hex(8)}.ipcli")
    try:
        yield draft
    finally:
        with suppress(FileNotFoundError):
            draft.unlink()


def publish(draft: Path, path: Path, *, replace: bool = True, durable: bool = True) -> None:
    """Give a written draft its name. Unless `replace`, FileExistsError when there is a file of that name, however late.

    Unless `durable` the disk is not waited for: a kill still does no harm, but after a power cut the file may be
    damaged.
    """
    if durable:
        _flush(draft)
    if replace:
        os.replace(draft, path)
    else:
        _move_to_free_name(draft, path)
    if durable:
        _flush(path.parent)


def _move_to_free_name(draft: Path, path: Path) -> None:
    try:
        os.link(draft, path)  # fails when the name is taken, at one stroke
    except FileExistsError:
        raise
    except OSError:  # no hard links on this file system: look, then rename
        if os.path.lexists(path):
            raise FileExistsError(17, "file exists", str(path)) from None
        os.replace(draft, path)
    else:
        draft.unlink()


@contextmanager
def replacing(path: Path, *, durable: bool = True) -> Iterator[Path]:
    """A private name in the folder of `path`; what is written there replaces `path` at the end, `durable` as above.

    After an exception the temporary file is gone and `path` is as it was.
    """
    with drafting(path) as draft:
        yield draft
        publish(draft, path, durable=durable)


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
    """Remove temporary files that killed runs of ipcli left in `folder` more than a day ago."""
    if not folder.is_dir():
        return
    oldest = time.time() - DAY
    for entry in folder.iterdir():
        with suppress(FileNotFoundError):  # another process may sweep too
            if ORPHAN.fullmatch(entry.name) and entry.is_file() and entry.stat().st_mtime < oldest:
                entry.unlink()
