"""`ipcli tune-fusion`: the error of methods against lambda."""

from __future__ import annotations

from pathlib import Path

import click

from ipcli.cli import options
from ipcli.params import Run
from ipcli.stages.fusion.parameters import TuneFusion


@click.command("tune-fusion")
@click.argument("files", metavar="VIEWS...", type=options.PATH, nargs=-1, required=True)
@options.output("Artefact to write, such as X.tuning.h5.")
@options.parameters(TuneFusion)
@options.common
def main(files: tuple[Path, ...], output: Path, params: TuneFusion, run: Run) -> None:
    """Fuse each scene of VIEWS, whose truth is known, by several methods at several lambdas.

    Says which lambda is best for each method on average over the scenes, and how close the automatic one comes. Beside
    the output comes a page with the curves (.html). evaluate-fusion reports the methods at their best lambda on other
    scenes.
    """
    from ipcli.stages.fusion import tune_fusion

    with options.progress("tune-fusion", run) as tell:
        tune_fusion.run(files, output, params, run, tell)
    options.conclude(tune_fusion.summary(output), run, with_figures=True)
