"""Which names a run may write to: none that is an input, and of those that are taken only what it made itself.

An artefact records the name it was written under and the digest of each file beside it; so does the journal that stands
beside it while they are published. Any other file under one of these names is somebody else's, or was changed since.
"""

from __future__ import annotations

import hashlib
import json
import os
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
    beside: Mapping[str, str]  # digest of each side file that is there, by name
    status: Status | None  # of the artefact's file

    @classmethod
    def of(cls, output: Path, kind: str, beside: Iterable[Path]) -> Standing:
        """Look. Raises OutputRefused for a file that is not of our making, or was changed since."""
        record, status = _record(output, kind), file_status(output)
        ours = _vouched(record, journal(output))
        found = {}
        for path in beside:
            if os.path.lexists(path):
                found[path.name] = provenance.sha256(path)
                if found[path.name] not in ours.get(path.name, ()):
                    raise OutputRefused(path, f"exists and is not what ipcli wrote there with {output.name}")
        _check_run_record(output)
        return cls(record, found, status)


def _record(output: Path, kind: str) -> Mapping[str, Any] | None:
    if not os.path.lexists(output):
        return None
    try:
        header = h5.peek(output)
    except FormatError as error:
        raise OutputRefused(output, f"exists and is not a sound artefact of ipcli ({error})") from error
    if header.kind != kind:
        raise OutputRefused(output, f"exists and is of kind '{header.kind}', not '{kind}'")
    if (name := header.provenance.get("output")) != output.name:
        raise OutputRefused(output, f"exists and was written under another name, {name}")
    return header.provenance


def _vouched(record: Mapping[str, Any] | None, entries: Mapping[str, list[str]]) -> dict[str, set[str]]:
    found = {name: set(digests) for name, digests in entries.items()}
    for name, digest in (record or {}).get("beside", {}).items():
        found.setdefault(name, set()).add(digest)
    return found


def run_record_path(output: Path) -> Path:
    """Where what varies from run to run is kept."""
    return output.with_suffix(".run.json")


def _check_run_record(output: Path) -> None:
    path = run_record_path(output)
    if os.path.lexists(path) and _json(path).get("output") != output.name:
        raise OutputRefused(path, f"exists and is not what ipcli wrote there with {output.name}")


def journal_path(output: Path) -> Path:
    """A hidden file beside the output, there only while its files are published (or after a kill in that moment)."""
    return output.with_name(f".{hashlib.sha256(os.fsencode(output.name)).hexdigest()[:32]}.journal.ipcli")


def journal(output: Path) -> dict[str, list[str]]:
    """Digests that each side file may have had while they were published; empty when nobody was interrupted."""
    entries = _json(journal_path(output)).get("beside", {})
    return {str(name): [str(digest) for digest in digests] for name, digests in entries.items()}


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
