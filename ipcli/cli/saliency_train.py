"""The command `saliency-train`."""

from __future__ import annotations

from pathlib import Path

import click

from ipcli.cli import options
from ipcli.params import Run
from ipcli.stages.saliency.parameters import SaliencyTrain


@click.command("saliency-train")
@click.argument("recorded", type=options.PATH, nargs=-1, required=True)
@options.output("Model to write, for --model of saliency-predict, with a page (.html) beside it.")
@options.parameters(SaliencyTrain)
@options.common
def main(recorded: tuple[Path, ...], output: Path, params: SaliencyTrain, run: Run) -> None:
    """Learn from RECORDED sets of pictures or of surfaces with recorded fixations where people look.

    A set is the folder of OSIE, a folder of surfaces looked at in virtual reality, or pictures and fixations.csv.
    """
    from ipcli.stages.saliency import saliency_train

    with options.progress("saliency-train", run) as tell:
        saliency_train.run(recorded, output, params, run, tell)
    options.conclude(saliency_train.summary(output), run, with_figures=True)
