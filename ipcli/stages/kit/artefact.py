"""When to make an artefact and how to publish it, for all stages.

Up to date means: the file is there whole with the digest this run would have, and so is every file beside it, as it was
written. All files are written under temporary names and then published at once, the artefact last, so that its presence
vouches for the others; in place of an older one, that goes first.
"""

from __future__ import annotations

import json
import logging
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np

from ipcli import params, provenance
from ipcli.errors import FormatError, OutputExists, OutputRefused
from ipcli.io.files import atomic, h5
from ipcli.stages.kit import outputs
from ipcli.stages.kit.checkpoint import Checkpoint
from ipcli.stages.kit.outputs import Standing

log = logging.getLogger(__name__)  # "warning" is what a user hears without -v

Arrays = dict[str, np.ndarray]
Beside = Callable[[Path, Arrays, dict[str, Any]], None]


class Outcome(Enum):
    """What became of a job."""

    DONE = "done"
    UP_TO_DATE = "up to date"
    WOULD_RUN = "would run"


@dataclass(frozen=True)
class Job:
    """An artefact to make: where, of what kind, by which command with what parameters, from which files (or folders).

    `beside` maps each side file to a writer(path, arrays, provenance); it is called with a temporary path. `look` opens
    what a run opens first, cheaply, and raises what it raises: a dry run calls it where the job would have to run.
    """

    output: Path
    kind: str
    command: str
    params: object
    inputs: tuple[Path, ...]
    beside: Mapping[Path, Beside] = field(default_factory=dict)
    look: Callable[[], object] | None = None

    def standing(self) -> Standing:
        """What is there of it. Raises OutputRefused for a file that is not of our making."""
        return Standing.of(self.output, self.kind, self.beside)


def make(job: Job, build: Callable[[], Arrays], run: params.Run) -> Outcome:
    """Bring the artefact and its side files up to date, calling `build` for the arrays only if need be.

    Raises OutputExists when another result is there, unless `run.overwrite`, which always makes the artefact anew;
    OutputRefused, whatever the options, for a name that is an input or a file not made by this command under that name;
    IpcliError when an input changed meanwhile.
    """
    return make_resumable(job, lambda work: build(), run)


def make_resumable(job: Job, build: Callable[[Checkpoint], Arrays], run: params.Run) -> Outcome:
    """`make` for long work: `build` keeps its state in a checkpoint, which a run that was killed goes on from."""
    started = time.monotonic()
    outputs.check_names(job.output, (*job.beside, outputs.run_record_path(job.output)), job.inputs)
    standing, before = job.standing(), outputs.statuses(job.inputs)
    record = provenance.record(job.command, params.as_dict(job.params), job.inputs, job.kind, run.seed)
    work = Checkpoint.of(job.output, record["digest"])
    reason = _reason(job, standing, record["digest"], run.overwrite)
    if reason is None:
        log.warning("%s: up to date", job.output)
        if not run.dry_run:
            _tidy(job, work, standing)
        return Outcome.UP_TO_DATE
    if run.dry_run and job.look:
        job.look()
    log.log(logging.WARNING if run.dry_run else logging.INFO, "%s: run, since %s", job.output, reason)
    if run.dry_run:
        return Outcome.WOULD_RUN
    outputs.check_writable(job.output)
    arrays = build(work)
    outputs.check_unchanged(before, dict(zip(job.inputs, (item["sha256"] for item in record["inputs"]), strict=True)))
    files = _publish(job, arrays, record, standing)
    _write_run_record(job.output, files, provenance.run_record(time.monotonic() - started))
    _tidy(job, work, standing)
    return Outcome.DONE


def _tidy(job: Job, work: Checkpoint, standing: Standing) -> None:
    """Remove what only an unfinished run needs; one that was killed before its run record gets a short one."""
    work.clear()
    journal = outputs.journal_path(job.output)
    if journal.exists():
        if not outputs.run_record_path(job.output).exists():
            _write_run_record(job.output, standing.files, {})
        journal.unlink()


def _reason(job: Job, standing: Standing, digest: str, overwrite: bool) -> str | None:
    """Why the job has to run, or None when its result is there."""
    if standing.record is None:
        return "it does not exist"
    if overwrite:
        standing.check_replaceable(job.output)
        return "--overwrite is given"
    if standing.record.get("digest") != digest:
        raise OutputExists(job.output, "was made with other parameters, inputs or seed")
    missing = [path.name for path in job.beside if path.name not in standing.files]
    if missing:
        standing.check_replaceable(job.output)
        return f"{', '.join(missing)} beside it does not exist"
    if not standing.is_recorded:
        _check_sound(job)
    return None


def _check_sound(job: Job) -> None:
    try:
        h5.read(job.output, job.kind)
    except FormatError as error:
        raise OutputRefused(job.output, f"exists and is damaged ({error})") from error


def _publish(job: Job, arrays: Arrays, record: dict[str, Any], standing: Standing) -> Mapping[str, str]:
    """Write all files and give them their names; the digest of each by its name."""
    atomic.sweep(job.output.parent)
    with ExitStack() as stack:
        drafts = {path: stack.enter_context(atomic.drafting(path)) for path in (*job.beside, job.output)}
        with ThreadPoolExecutor() as pool:
            shared = _read_only(arrays)
            writing = [pool.submit(write, drafts[path], shared, record) for path, write in job.beside.items()]
            h5.write(drafts[job.output], job.kind, arrays, record)
        for written in writing:
            written.result()
        files = {path.name: provenance.sha256(draft) for path, draft in drafts.items()}
        if _is_still(job, standing, record["digest"]):
            _give_names(job, drafts, files, standing)
    return files


def _read_only(arrays: Arrays) -> Arrays:
    """The same data, not to be written to: what draws a page would otherwise draw into the artefact being written."""
    views = {name: np.asarray(array).view() for name, array in arrays.items()}
    for view in views.values():
        view.flags.writeable = False
    return views


def _is_still(job: Job, standing: Standing, digest: str) -> bool:
    """Whether the names are as they were before the work; not when another run has made the very same meanwhile.

    Raises OutputExists when another run, or somebody else, has been there.
    """
    now = job.standing()
    if now == standing:
        return True
    if now.record is None or now.record.get("digest") != digest:
        raise OutputExists(job.output, "was written by another run while this one was at work")
    return False


def _give_names(job: Job, drafts: Mapping[Path, Path], files: Mapping[str, str], standing: Standing) -> None:
    """Publish the drafts. Whenever the process is killed, the journal or the run record vouches for every file."""
    text = outputs.journal(job.output, (*standing.files.items(), *files.items()))
    atomic.write_text(outputs.journal_path(job.output), text)
    if standing.record is not None:
        job.output.unlink()
    try:
        for path in job.beside:
            atomic.publish(drafts[path], path, replace=path.name in standing.files)
        atomic.publish(drafts[job.output], job.output, replace=False)
    except FileExistsError as error:
        raise OutputExists(job.output, "was written by another run while this one was at work") from error


def _write_run_record(output: Path, files: Mapping[str, str], record: dict[str, Any]) -> None:
    text = json.dumps({"output": output.name, "files": dict(files)} | record, indent=2) + "\n"
    atomic.write_text(outputs.run_record_path(output), text)
