"""An artefact drawn as an HTML page.

The page is a pure function of the artefact and made in well under a second, so that it is simply made anew and
compared: the same bytes are up to date, another page that was made under that name is replaced only when asked for, and
any other file never.
"""

from __future__ import annotations

import os
from pathlib import Path

from ipcli import report
from ipcli.errors import FormatError, OutputExists, OutputRefused, ParameterError
from ipcli.io.files import atomic, h5, seal
from ipcli.params import Run
from ipcli.report.kit.page import with_turning_page
from ipcli.stages.kit import outputs
from ipcli.stages.kit.artefact import Outcome
from ipcli.stages.kit.pages import turning_page
from ipcli.stages.kit.parameters import Report

SUFFIXES = (".html", ".htm")


def run(source: Path, output: Path, params: Report, run: Run) -> Outcome:
    """Write the page of the artefact `source` to `output`.

    Raises FormatError for an unsound artefact, ParameterError for a kind that has no page or a name that no page can
    have, OutputRefused for a file that is no page made under that name, OutputExists if another page is there and
    `run.overwrite` is not set.
    """
    if output.suffix not in SUFFIXES:
        raise ParameterError(f"{output}: a page is written as X.html. Give such a name")
    outputs.check_place(output)
    turned = turning_page(source)
    page = with_turning_page(
        render(source, params), os.path.relpath(turned, output.parent) if turned.exists() else None
    )
    data = seal.sealed(page, output.name).encode("utf-8")
    if os.path.lexists(output):
        if output.read_bytes() in (data, page.encode("utf-8")):
            return Outcome.UP_TO_DATE
        if not seal.is_sealed(output):
            raise OutputRefused(output, "exists and is not a page that ipcli report wrote there")
        if not run.overwrite:
            raise OutputExists(output, f"is not the page of {source.name}")
    if run.dry_run:
        return Outcome.WOULD_RUN
    atomic.write_bytes(output, data)
    return Outcome.DONE


def render(source: Path, params: Report) -> str:
    """The HTML of an artefact of any kind that has a page; only the fields that the page shows are read."""
    kind = h5.peek(source).kind
    draw = report.renderer(kind)
    artefact = h5.read(source, kind, only=report.needed(kind))
    try:
        return draw(artefact.arrays, artefact.provenance, widest=params.width)
    except FormatError:
        raise
    except Exception as error:  # each field is sound for itself; the page met what does not go together
        got = f"{type(error).__name__}: {' '.join(str(error).split())[:120]}"
        what = f"its fields do not go together, so that '{kind}' cannot be drawn"
        raise FormatError(source, what, got=got, fix=h5.FIX) from error
