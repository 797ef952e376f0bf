"""`ipcli evaluate-fusion`: all methods on one scene."""

from __future__ import annotations

from pathlib import Path

import click

from ipcli.cli import options
from ipcli.params import Run
from ipcli.stages.fusion.parameters import EvaluateFusion


@click.command("evaluate-fusion")
@click.argument("views", type=options.PATH)
@options.output("Artefact to write, such as SCENE.trials.h5.")
@click.option("--tuning", type=options.PATH, help="Artefact of tune-fusion: try each method at its best lambda too.")
@options.parameters(EvaluateFusion)
@options.common
def main(views: Path, output: Path, tuning: Path | None, params: EvaluateFusion, run: Run) -> None:
    """Fuse VIEWS, whose truth is known, by several methods and measure the errors of each.

    Beside the output comes a page with the table, the surfaces in light and what the confidences are worth (.html).
    `ipcli compare` joins several scenes to one table.
    """
    from ipcli.stages.fusion import evaluate_fusion

    with options.progress("evaluate-fusion", run) as tell:
        evaluate_fusion.run(views, output, params, run, tuning, tell)
    options.conclude(evaluate_fusion.summary(output), run, with_figures=True)
