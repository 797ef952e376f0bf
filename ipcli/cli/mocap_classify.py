"""`mocap-classify`: which action a motion is."""

from __future__ import annotations

from pathlib import Path

import click

from ipcli.cli import options
from ipcli.params import Run
from ipcli.stages.mocap.parameters import MocapClassify


@click.command("mocap-classify")
@click.argument("model", type=options.PATH)
@click.argument("clips", type=options.PATH, nargs=-1, required=True)
@options.output("Answers to write, such as X.recognition.h5.")
@options.parameters(MocapClassify)
@options.common
def main(model: Path, clips: tuple[Path, ...], output: Path, params: MocapClassify, run: Run) -> None:
    """Name the action of each of CLIPS by a MODEL of mocap-train, or `none` if it is like nothing that was learnt.

    CLIPS are read as mocap-train reads them. --unordered 20 asks about 20 frames of each clip in no order; --window 1
    asks along long takes, second by second. Beside the output come a page to open (.html) and a table (.csv), of
    segments with --window. Where an answer is `none`, the posterior is that of `best`, the likeliest of the actions.
    """
    from ipcli.stages.mocap import mocap_classify

    with options.progress("mocap-classify", run) as tell:
        mocap_classify.run(model, clips, output, params, run, tell)
    answers = {"answers": mocap_classify.answers(output)} if run.json and output.exists() else {}
    options.conclude(mocap_classify.summary(output) | answers, run, with_figures=True)
