"""`ipcli import-clips`: motion capture files as one file of labelled clips."""

from __future__ import annotations

from pathlib import Path

import click

from ipcli.cli import options
from ipcli.params import Run
from ipcli.stages.mocap.parameters import ImportClips


@click.command("import-clips")
@click.argument("source", type=options.PATH)
@options.output("The clips artefact to write, such as X.clips.h5.")
@options.parameters(ImportClips)
@options.common
def main(source: Path, output: Path, params: ImportClips, run: Run) -> None:
    """Turn SOURCE into one clips artefact.

    SOURCE is a motion file, a folder or a tar archive of them (labelled by manifest.csv, by HDM05 names, or by folders
    LABEL/ACTOR/), one of the Kinect sets Florence 3D Actions and UTKinect-Action, or another clips artefact.
    --rename "drink=swallow,answer phone=swallow" gives actions other names, for sets that take no manifest too.
    """
    from ipcli.stages.kit import summary
    from ipcli.stages.mocap import import_clips

    with options.progress("import-clips", run) as tell:
        import_clips.run(source, output, params, run, tell)
    options.conclude(summary.of_clips(output), run, with_figures=True)
