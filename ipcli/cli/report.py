"""`ipcli report`: an artefact as a page to look at."""

from __future__ import annotations

from pathlib import Path

import click

from ipcli.cli import options
from ipcli.params import Run
from ipcli.stages.kit.parameters import Report


@click.command("report")
@click.argument("file", type=options.PATH)
@click.option("-o", "--output", type=options.PATH, metavar="PAGE.html", help="Page to write.  [default: FILE.html]")
@options.parameters(Report)
@options.common
def main(file: Path, output: Path | None, params: Report, run: Run) -> None:
    """Draw the artefact FILE (a fused depth map, or views) as one self-contained HTML page."""
    from ipcli.stages.kit import report

    output = output or file.with_suffix(".html")
    outcome = report.run(file, output, params, run)
    options.conclude({"output": output, "outcome": outcome.value}, run)
