"""Which names a run may write to: none that is an input, and of those that are taken only what it made itself.

X.run.json records under which name the files of a run were written, and the digest of each; while they are published, a
journal does. Any other file under one of these names is somebody else's, or was changed since.
"""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ipcli import provenance
from ipcli.errors import FormatError, IpcliError, OutputRefused, ParameterError
from ipcli.io.files import h5

ARTEFACT = ".h5"
Status = tuple[int, int, int, int]


def check_names(output: Path, beside: Iterable[Path], inputs: Iterable[Path]) -> None:
    """Raise ParameterError for a name no artefact can have, OutputRefused for one that belongs to an input."""
    if output.suffix != ARTEFACT:
        got = f"'{output.suffix}'" if output.suffix else "no suffix"
        raise ParameterError(f"{output}: results are written as X{ARTEFACT}, got {got}. Give such a name")
    known = list(inputs)
    for path in (output, *beside):
        check_place(path)
        for source in known:
            if _is_within(path, source):
                what = "is an input of this run" if not source.is_dir() else f"lies in the input folder {source}"
                raise OutputRefused(path, f"{what} and would be written to")


def check_place(path: Path, *, folder: bool = False) -> None:
    """Raise ParameterError unless a file (or a folder of files) can have this name."""
    if path.name == "-":
        raise ParameterError("-: results are files, standard output has only their names. Give a name")
    if folder and os.path.lexists(path) and not path.is_dir():
        raise ParameterError(f"{path}: is a file, but the results go into a folder. Give another name")
    if not folder and os.path.lexists(path) and not path.is_file():
        raise ParameterError(f"{path}: is {'a folder' if path.is_dir() else 'no plain file'}. Give the name of a file")
    nearest = next(parent for parent in path.absolute().parents if os.path.lexists(parent))
    if not nearest.is_dir():
        raise ParameterError(f"{path}: {nearest} is no folder. Give another name")


def check_writable(path: Path) -> None:
    """Raise ParameterError if no file can be made where `path` would be, before hours of work; nothing stays there."""
    nearest = next(parent for parent in path.absolute().parents if os.path.lexists(parent))
    try:
        tempfile.TemporaryFile(dir=nearest).close()
    except OSError as error:
        words = f"{nearest} cannot be written to ({error.strerror})"
        raise ParameterError(f"{path}: {words}. Give a name in another folder") from None


def _is_within(path: Path, source: Path) -> bool:
    """Whether `path` is `source` under any name, or lies in that folder."""
    real, origin = Path(os.path.realpath(path)), Path(os.path.realpath(source))
    if real == origin or (origin.is_dir() and origin in real.parents):
        return True
    return path.is_file() and source.is_file() and os.path.samefile(path, source)


@dataclass(frozen=True)
class Standing:
    """What is there of an artefact and of the files beside it, all of our own making."""

    record: Mapping[str, Any] | None  # provenance of the artefact; None: there is none
    files: Mapping[str, str]  # digest of each file that is there, by name
    is_recorded: bool  # whether a record says that ipcli wrote the artefact under this name

    @classmethod
    def of(cls, output: Path, kind: str, beside: Iterable[Path]) -> Standing:
        """Look. Raises OutputRefused for a file that is not of our making, or was changed since."""
        record, ours = _provenance(output, kind), _written(output)
        found = {path.name: provenance.sha256(path) for path in (output, *beside) if os.path.lexists(path)}
        for path in beside:
            if path.name in found and found[path.name] not in ours.get(path.name, ()):
                raise OutputRefused(path, f"exists and is not what ipcli wrote there with {output.name}")
        written = ours.get(output.name, ())
        if record is not None and written and found[output.name] not in written:
            raise OutputRefused(output, "exists and was damaged or changed since ipcli wrote it")
        return cls(record, found, bool(written))

    def check_replaceable(self, output: Path) -> None:
        """Raise OutputRefused when there is an artefact that nothing says was written under this name."""
        if self.record is not None and not self.is_recorded:
            beside = run_record_path(output).name
            raise OutputRefused(output, f"exists, and no {beside} beside it says that ipcli wrote it under this name")


def _provenance(output: Path, kind: str) -> Mapping[str, Any] | None:
    if not os.path.lexists(output):
        return None
    try:
        header = h5.peek(output)
    except FormatError as error:
        raise OutputRefused(output, f"exists and is not a sound artefact of ipcli ({error})") from error
    if header.kind != kind:
        raise OutputRefused(output, f"exists and is of kind '{header.kind}', not '{kind}'")
    return header.provenance


def run_record_path(output: Path) -> Path:
    """Where what varies from run to run is kept, and what was written."""
    return output.with_suffix(".run.json")


def journal_path(output: Path) -> Path:
    """A hidden file beside the output, there only while its files are published (or after a kill in that moment)."""
    return output.with_name(f".{hashlib.sha256(os.fsencode(output.name)).hexdigest()[:32]}.journal.ipcli")


def _written(output: Path) -> dict[str, set[str]]:
    """Digests that each file may have by what the run record and the journal say, by name.

    Raises OutputRefused for a run record that is not of our making.
    """
    record = run_record_path(output)
    if os.path.lexists(record) and _json(record).get("output") != output.name:
        raise OutputRefused(record, f"exists and is not what ipcli wrote there with {output.name}")
    found: dict[str, set[str]] = {}
    for path in (record, journal_path(output)):
        files = _json(path).get("files")
        for name, digests in files.items() if isinstance(files, dict) else ():
            found.setdefault(name, set()).update(map(str, digests if isinstance(digests, list) else [digests]))
    return found


def journal(output: Path, files: Iterable[tuple[str, str]]) -> str:
    """The text of a journal: each file may have these digests, and those that were known before."""
    known = _written(output)
    for name, digest in files:
        known.setdefault(name, set()).add(digest)
    listed = {name: sorted(digests) for name, digests in sorted(known.items())}
    return json.dumps({"output": output.name, "files": listed}, indent=1) + "\n"


def _json(path: Path) -> dict[str, Any]:
    """A JSON object of ours; empty for anything else."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}


def file_status(path: Path) -> Status | None:
    """What changes whenever a file is written to; None for one that is not there."""
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_ctime_ns, found.st_size, found.st_ino


def statuses(inputs: Iterable[Path]) -> dict[Path, Any]:
    """The status of every input, of a folder those of all its files."""
    return {
        path: {item: file_status(item) for item in sorted(path.rglob("*"))} if path.is_dir() else file_status(path)
        for path in inputs
    }


def check_unchanged(before: Mapping[Path, Any], digests: Mapping[Path, str]) -> None:
    """Raise IpcliError when an input is no longer what its digest was taken of."""
    for path, status in statuses(before).items():
        if status != before[path] and provenance.sha256(path) != digests[path]:
            raise IpcliError(f"{path}: changed while it was read; nothing was written. Run again")
