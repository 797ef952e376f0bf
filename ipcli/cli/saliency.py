"""`saliency`: what is likely to be looked at in a scene. `saliency train`, `predict`, `evaluate` are other commands."""

from __future__ import annotations

from pathlib import Path

import click

from ipcli.cli import options
from ipcli.params import Run
from ipcli.stages.saliency.parameters import Saliency

WORDS = {word: options.command(f"saliency-{word}") for word in ("train", "predict", "evaluate")}


@click.command("saliency", cls=options.first_word(**WORDS))
@click.argument("source", type=options.PATH)
@options.output("Saliency to write, such as x.saliency.h5.")
@options.parameters(Saliency)
@options.common
def main(source: Path, output: Path, params: Saliency, run: Run) -> None:
    """Tell what is likely to be looked at in the scene of SOURCE, and generate its proto-objects.

    SOURCE is an experiment of gaze-sfm, whose points of regard are learnt from, or views with depth and poses, for
    which --model gives what was learnt. Beside the output come a page (.html), a cloud (.ply; .turn.html to
    be turned), membranes to be run in time (.membranes.html) and a table of proto-objects (.objects.csv).
    `saliency train|predict|evaluate` do the same for pictures and meshes.
    """
    from ipcli.stages.saliency import saliency

    with options.progress("saliency", run) as tell:
        saliency.run(source, output, params, run, tell)
    if run.dry_run:
        options.conclude(output, run)
        return
    options.conclude(saliency.summary(output), run, with_figures=True)
