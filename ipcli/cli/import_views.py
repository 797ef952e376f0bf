"""`ipcli import-views`: a folder of depth maps and poses as one file."""

from __future__ import annotations

from pathlib import Path

import click

from ipcli.cli import options
from ipcli.params import Run
from ipcli.stages.fusion.parameters import ImportViews


@click.command("import-views")
@click.argument("source", type=options.PATH)
@options.output("The views artefact to write, such as X.views.h5.")
@options.parameters(ImportViews)
@options.common
def main(source: Path, output: Path, params: ImportViews, run: Run) -> None:
    """Turn SOURCE into one views artefact.

    SOURCE is a dense COLMAP workspace, a TUM, Open3D/ICL-NUIM or 7-Scenes recording, a plain folder (depth/, poses.txt,
    intrinsics.txt), or another views artefact.
    """
    from ipcli.stages.fusion import import_views
    from ipcli.stages.kit import summary

    with options.progress("import-views", run) as tell:
        import_views.run(source, output, params, run, tell)
    options.conclude(summary.of_views(output), run, with_figures=True)
