"""`gaze-sfm`: where was the wearer, and what were they looking at. `gaze-sfm check` looks before the long work."""

from __future__ import annotations

from pathlib import Path

import click

from ipcli.cli import options
from ipcli.params import Run
from ipcli.stages.gaze.parameters import Check, GazeSfm


@click.command("check")
@click.argument("recording", type=options.PATH)
@options.parameters(Check)
@options.reading
def check(recording: Path, params: Check, run: Run) -> None:
    """Test whether calibration, pictures and gaze of RECORDING go together, before any long work."""
    from ipcli.stages.gaze import check as stage

    facts, warnings = stage.run(recording, params)
    options.conclude(facts | ({"warnings": warnings} if run.json else {}), run)
    if not run.json:
        click.echo("\n".join(f"Warning: {warning}" for warning in warnings) or "no warning")


@click.command("gaze-sfm", cls=options.first_word(check=lambda: check))
@click.argument("recording", type=options.PATH)
@options.output("Experiment to write, such as run.h5.")
@options.parameters(GazeSfm)
@options.common
def main(recording: Path, output: Path, params: GazeSfm, run: Run) -> None:
    """Localise the head of RECORDING and the points in the scene that its wearer looked at.

    RECORDING is a recording artefact or the folder of EuRoC/ASL, KITTI odometry, Project Aria (export), BoofCV, TUM
    RGB-D or 7-Scenes; gaze is its own or that of --gaze. Beside the output come a page (.html), points of regard
    (.por.csv), the path (.tum), a cloud (.ply) and a COLMAP model (.cameras.txt, .images.txt, .points3D.txt).
    `gaze-sfm check RECORDING` tests calibration and clocks first.
    """
    from ipcli.stages.gaze import gaze_sfm

    with options.progress("gaze-sfm", run) as tell:
        gaze_sfm.run(recording, output, params, run, tell)
    if run.dry_run:
        options.conclude(output, run)
        return
    options.conclude(gaze_sfm.summary(output), run, with_figures=True)
