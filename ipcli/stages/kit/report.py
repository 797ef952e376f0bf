"""An artefact drawn as an HTML page.

The page is a pure function of the artefact and made in well under a second, so that it is simply made anew and
compared: the same bytes are up to date, other bytes are replaced only when asked for.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ipcli.errors import OutputExists, ParameterError
from ipcli.params import Run, option
from ipcli.stages.kit.artefact import Outcome


@dataclass(frozen=True)
class Params:
    """How the page is drawn."""

    width: int = option(900, "Widest picture that is stored.", flag="--width", low=64, high=8192, unit="pixels")


def run(source: Path, output: Path, params: Params, run: Run) -> Outcome:
    """Write the page of the artefact ``source`` to ``output``.

    Raises FormatError for an unsound artefact, ParameterError for a kind that has no page or an output that is the
    artefact itself, OutputExists if another file is there and ``run.overwrite`` is not set.
    """
    if output.resolve() == source.resolve():
        raise ParameterError(f"{output}: the page would replace the artefact it shows. Give another --output")
    page = render(source, params).encode("utf-8")
    if output.exists() and not run.overwrite:
        if output.read_bytes() == page:
            return Outcome.UP_TO_DATE
        raise OutputExists(output, f"is not the page of {source.name}")
    if run.dry_run:
        return Outcome.WOULD_RUN
    from ipcli.io.files import atomic

    atomic.write_bytes(output, page)
    return Outcome.DONE


def render(source: Path, params: Params) -> str:
    """The HTML of an artefact of any kind that has a page; only the fields that the page shows are read."""
    from ipcli import report
    from ipcli.io.files import h5

    kind = h5.peek(source).kind
    draw = report.renderer(kind)
    artefact = h5.read(source, kind, only=report.needed(kind))
    return draw(artefact.arrays, artefact.provenance, widest=params.width)
