"""`ipcli render-views`: depth maps of a mesh, whose truth is known."""

from __future__ import annotations

from pathlib import Path

import click

from ipcli.cli import options
from ipcli.params import Run
from ipcli.stages.fusion.parameters import RenderViews


@click.command("render-views")
@click.argument("mesh", type=options.PATH)
@options.output("The views artefact to write, such as X.views.h5.")
@options.parameters(RenderViews)
@options.common
def main(mesh: Path, output: Path, params: RenderViews, run: Run) -> None:
    """Render depth maps of MESH (.ply .obj .off) along a camera path, with noise if wanted; the true depth stays
    with them.
    """
    from ipcli.stages.fusion import render_views
    from ipcli.stages.kit import summary

    with options.progress("render-views", run) as tell:
        render_views.run(mesh, output, params, run, tell)
    options.conclude(summary.of_views(output), run, with_figures=True)
