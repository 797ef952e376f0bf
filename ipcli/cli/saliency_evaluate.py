"""The command `saliency-evaluate`."""

from __future__ import annotations

from pathlib import Path

import click

from ipcli.cli import options
from ipcli.params import Run
from ipcli.stages.saliency.parameters import SaliencyEvaluate


@click.command("saliency-evaluate")
@click.argument("recorded", type=options.PATH, nargs=-1, required=True)
@options.output("Evaluation to write, with a table (.csv) and a page (.html) beside it.")
@click.option("--model", type=options.PATH, help="Judge what saliency-train learnt, in place of a cross-validation.")
@options.parameters(SaliencyEvaluate)
@options.common
def main(recorded: tuple[Path, ...], output: Path, model: Path | None, params: SaliencyEvaluate, run: Run) -> None:
    """Tell how well the fixations of RECORDED sets are predicted: by models, by each feature alone, by baselines.

    A set is the folder of OSIE, a folder of surfaces looked at in virtual reality, or pictures and fixations.csv.
    """
    from ipcli.stages.saliency import saliency_evaluate

    with options.progress("saliency-evaluate", run) as tell:
        saliency_evaluate.run(recorded, output, model, params, run, tell)
    options.conclude(saliency_evaluate.summary(output), run, with_figures=True)
