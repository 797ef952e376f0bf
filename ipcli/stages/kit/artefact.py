"""When to make an artefact and how to publish it, for all stages.

Up to date means: the file is there with the digest this run would have, and so are the files beside it. A different
file is never replaced unasked. All files are written under temporary names and then published at once, the artefact
last, so that its presence vouches for the others.
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
from typing import TYPE_CHECKING, Any

from ipcli import params
from ipcli.errors import FormatError, OutputExists

if TYPE_CHECKING:
    import numpy as np

log = logging.getLogger(__name__)  # "warning" is what a user hears without -v

Beside = Callable[[Path, "dict[str, np.ndarray]", dict[str, Any]], None]


class Outcome(Enum):
    """What became of a job."""

    DONE = "done"
    UP_TO_DATE = "up to date"
    WOULD_RUN = "would run"


@dataclass(frozen=True)
class Job:
    """An artefact to make: where, of what kind, by which command with what parameters, from which files (or folders).

    `beside` maps each side file to a writer(path, arrays, provenance); it is called with a temporary path.
    """

    output: Path
    kind: str
    command: str
    params: object
    inputs: tuple[Path, ...]
    beside: Mapping[Path, Beside] = field(default_factory=dict)


def make(job: Job, build: Callable[[], dict[str, np.ndarray]], run: params.Run) -> Outcome:
    """Bring the artefact and its side files up to date, calling `build` for the arrays only if need be.

    Raises OutputExists when another file is there, unless `run.overwrite`, which always makes the artefact anew.
    """
    from ipcli import provenance

    started = time.monotonic()
    record = provenance.record(job.command, params.as_dict(job.params), job.inputs, job.kind, run.seed)
    reason = _reason(job, record["digest"], run.overwrite)
    if reason is None:
        log.warning("%s: up to date", job.output)
        return Outcome.UP_TO_DATE
    log.log(logging.WARNING if run.dry_run else logging.INFO, "%s: run, since %s", job.output, reason)
    if run.dry_run:
        return Outcome.WOULD_RUN
    _publish(job, build(), record)
    _write_run_record(job.output, provenance.run_record(time.monotonic() - started))
    return Outcome.DONE


def _reason(job: Job, digest: str, overwrite: bool) -> str | None:
    """Why the job has to run, or None when its result is there."""
    if not job.output.exists():
        return "it does not exist"
    if overwrite:
        return "--overwrite is given"
    found = _digest(job)
    if found != digest:
        raise OutputExists(job.output, "was made with other parameters, inputs or seed")
    missing = [path.name for path in job.beside if not path.is_file()]
    return f"{', '.join(missing)} beside it does not exist" if missing else None


def _digest(job: Job) -> str | None:
    from ipcli.io.files import h5

    try:
        header = h5.peek(job.output)
    except FormatError as error:
        raise OutputExists(job.output, f"is not a sound artefact of ipcli ({error})") from error
    if header.kind != job.kind:
        raise OutputExists(job.output, f"is of kind '{header.kind}', not '{job.kind}'")
    return header.provenance.get("digest")


def _publish(job: Job, arrays: dict[str, np.ndarray], record: dict[str, Any]) -> None:
    from ipcli.io.files import atomic, h5

    atomic.sweep(job.output.parent)
    with ExitStack() as stack:  # leaves in reverse: nothing is published before all is written, the artefact last
        artefact = stack.enter_context(atomic.replacing(job.output))
        beside = [(write, stack.enter_context(atomic.replacing(path))) for path, write in job.beside.items()]
        with ThreadPoolExecutor() as pool:
            writing = [pool.submit(write, path, arrays, record) for write, path in beside]
            h5.write(artefact, job.kind, arrays, record)
        for written in writing:
            written.result()


def _write_run_record(output: Path, record: dict[str, Any]) -> None:
    from ipcli.io.files import atomic

    atomic.write_text(output.with_suffix(".run.json"), json.dumps(record, indent=2) + "\n")
