"""`ipcli mocap-evaluate`: how well actions are told apart."""

from __future__ import annotations

from pathlib import Path

import click

from ipcli.cli import options
from ipcli.params import Run
from ipcli.stages.mocap.parameters import MocapEvaluate


@click.command("mocap-evaluate")
@click.argument("clips", type=options.PATH, nargs=-1, required=True)
@options.output("Evaluation to write, such as X.evaluation.h5.")
@options.parameters(MocapEvaluate)
@options.common
def main(clips: tuple[Path, ...], output: Path, params: MocapEvaluate, run: Run) -> None:
    """Learn from a part of labelled CLIPS and tell how often the others are named right, single frames and whole clips
    apart.

    By default the people who are recognised are not those who are learnt from: that is what figures for new recordings
    must be from. Beside the output comes a page to open (.html).
    """
    from ipcli.stages.kit.summary import of_result
    from ipcli.stages.mocap import mocap_evaluate

    with options.progress("mocap-evaluate", run) as tell:
        mocap_evaluate.run(clips, output, params, run, tell)
    options.conclude(of_result(mocap_evaluate.figures)(output), run, with_figures=True)
