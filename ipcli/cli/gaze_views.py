"""`gaze-views`: depth maps of a localised recording, for `fuse-depth`."""

from __future__ import annotations

from pathlib import Path

import click

from ipcli.cli import options
from ipcli.params import Run
from ipcli.stages.gaze.parameters import GazeViews


@click.command("gaze-views")
@click.argument("recording", type=options.PATH)
@click.argument("experiment", type=options.PATH)
@options.output("Views artefact to write.")
@options.parameters(GazeViews)
@options.common
def main(recording: Path, experiment: Path, output: Path, params: GazeViews, run: Run) -> None:
    """Match the frames of RECORDING densely at the poses that gaze-sfm found (EXPERIMENT), as views for fuse-depth."""
    from ipcli.stages.gaze import gaze_views
    from ipcli.stages.kit import summary

    with options.progress("gaze-views", run) as tell:
        gaze_views.run(recording, experiment, output, params, run, tell)
    options.conclude(summary.of_views(output), run, with_figures=True)
