"""`ipcli kitti-views`: depth maps of KITTI stereo scenes."""

from __future__ import annotations

from pathlib import Path

import click

from ipcli.cli import options
from ipcli.params import Run
from ipcli.stages.fusion.parameters import KittiViews


@click.command("kitti-views")
@click.argument("folder", type=options.PATH)
@click.option(
    "--poses",
    type=options.PATH,
    required=True,
    help="NPZ of all scenes, or text of 12 numbers a frame, or a folder of these.",
)
@options.output("Folder for SCENE.views.h5.")
@options.parameters(KittiViews)
@options.common
def main(folder: Path, poses: Path, output: Path, params: KittiViews, run: Run) -> None:
    """Match the stereo pairs of scenes in FOLDER (KITTI stereo 2012).

    Writes the depth maps of both cameras with their poses, one views artefact a scene. Scenes that are there already
    are left alone.
    """
    from ipcli.stages.fusion import kitti_views
    from ipcli.stages.kit import summary

    with options.progress("kitti-views", run) as tell:
        outcomes = kitti_views.run(folder, poses, output, params, run, tell)
    options.conclude(summary.of_items(output, outcomes), run, with_figures=True)
