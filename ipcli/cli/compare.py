"""`ipcli compare`: methods side by side."""

from __future__ import annotations

from pathlib import Path

import click

from ipcli.cli import options
from ipcli.params import Run
from ipcli.stages.fusion.parameters import CompareFusion


@click.command("compare")
@click.argument("files", type=options.PATH, nargs=-1, required=True)
@options.output("Table to write, such as X.comparison.h5.")
@options.parameters(CompareFusion)
@options.common
def main(files: tuple[Path, ...], output: Path, params: CompareFusion, run: Run) -> None:
    """Compare the errors of fused maps with a truth, or of trials (FILES), over scenes and methods.

    A file's scene is its name up to the first dot. Beside the output come a page to open (.html) and all figures (.csv,
    .json).
    """
    from ipcli.stages.fusion import compare

    compare.run(files, output, params, run)
    options.conclude(compare.summary(output), run, with_figures=True)
