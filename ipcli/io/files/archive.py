"""Archives opened as folders: unpacked into a temporary one that lives as long as somebody holds it."""

from __future__ import annotations

import tarfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from lzma import LZMAError
from pathlib import Path
from tarfile import HeaderError, ReadError
from tempfile import TemporaryDirectory

from ipcli import memory
from ipcli.errors import FormatError

CHUNK = 1 << 20
SUFFIXES = (".tar", ".tar.gz", ".tgz", ".tar.xz", ".txz", ".tar.bz2")


@dataclass(frozen=True)
class Unpacked:
    """A folder, and what keeps it: None when it was there before."""

    folder: Path
    keeper: TemporaryDirectory | None = None


def is_archive(path: Path) -> bool:
    """Whether the name is that of a tar archive."""
    return path.is_file() and path.name.lower().endswith(SUFFIXES)


def listing(path: Path) -> tuple[str, ...]:
    """Names of the files in an archive, or of those below a folder, sorted; none of anything else."""
    if is_archive(path):
        return _members(path, path.stat().st_mtime_ns)
    return (
        tuple(sorted(file.relative_to(path).as_posix() for file in path.rglob("*") if file.is_file()))
        if path.is_dir()
        else ()
    )


@cache
def _members(path: Path, changed: int) -> tuple[str, ...]:
    """The list of a whole archive costs its decompression: once for each state of the file."""
    with _opened(path) as tar:
        names, size = [], 0
        for member in tar:
            size += member.size
            memory.check(path, size, "files", "Raise --max-memory, or unpack it yourself and give the folder")
            names += [member.name] if member.isfile() else []
        _check_end(path, tar)
    return tuple(sorted(names))


def unpacked(path: Path) -> Unpacked:
    """A folder as it is, an archive unpacked. Raises FormatError for a damaged archive, or one that writes
    elsewhere.
    """
    if not is_archive(path):
        return Unpacked(path)
    listing(path)  # which looks at all of it
    keeper = TemporaryDirectory(prefix="ipcli-")
    with _opened(path) as tar:
        tar.extractall(keeper.name, filter="data")
    return Unpacked(Path(keeper.name), keeper)


class Header(tarfile.TarInfo):
    """A member of an archive. tarfile takes a damaged header, or none, for the end of the archive without a word."""

    @classmethod
    def fromtarfile(cls, tarfile: tarfile.TarFile) -> Header:
        try:
            return super().fromtarfile(tarfile)
        except HeaderError as error:
            if type(error).__name__ == "EOFHeaderError":  # the zeros of the end
                raise
            raise ReadError(f"neither a member nor the end at byte {tarfile.offset} ({error})") from None


def _check_end(path: Path, tar: tarfile.TarFile) -> None:
    """FormatError unless nothing but zeros follows the end, as where a second archive was joined to the first."""
    assert tar.fileobj is not None
    while block := tar.fileobj.read(CHUNK):
        if block.strip(b"\0"):
            fix = "Unpack them yourself, each archive by itself, and give the folder"
            raise FormatError(path, "more follows the end of the archive: several were joined", fix=fix)


@contextmanager
def _opened(path: Path) -> Iterator[tarfile.TarFile]:
    """The open archive; whatever goes wrong with it becomes a FormatError of this path."""
    try:
        with tarfile.open(path, tarinfo=Header) as tar:
            yield tar
    except (tarfile.TarError, EOFError, OSError, ValueError, LZMAError, zlib.error) as error:
        fix = "Check that the copy is complete, or unpack it yourself and give the folder"
        raise FormatError(path, f"not a readable archive: {' '.join(str(error).split())}", fix=fix) from None
