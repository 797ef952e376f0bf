"""`mocap-train`: the behaviours of actions."""

from __future__ import annotations

from pathlib import Path

import click

from ipcli.cli import options
from ipcli.params import Run
from ipcli.stages.mocap.parameters import MocapTrain


@click.command("mocap-train")
@click.argument("clips", type=options.PATH, nargs=-1, required=True)
@options.output("Model to write, such as X.model.h5.")
@options.parameters(MocapTrain)
@options.common
def main(clips: tuple[Path, ...], output: Path, params: MocapTrain, run: Run) -> None:
    """Learn from labelled CLIPS how each part of the body behaves in each action.

    CLIPS are clips artefacts (ipcli import-clips) or motion files, folders and archives as that command reads them, all
    of one skeleton. Beside the output comes a report to open (.html). A run that was killed goes on where it was;
    --executor processes:2 uses two cores.
    """
    from ipcli.stages.kit.summary import of_result
    from ipcli.stages.mocap import mocap_train

    with options.progress("mocap-train", run) as tell:
        mocap_train.run(clips, output, params, run, tell)
    options.conclude(of_result(mocap_train.figures)(output), run, with_figures=True)
