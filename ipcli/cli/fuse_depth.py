"""`fuse-depth`: several depth maps as one."""

from __future__ import annotations

from pathlib import Path

import click

from ipcli.cli import options
from ipcli.params import Run
from ipcli.stages.fusion.parameters import FuseDepth


@click.command("fuse-depth")
@click.argument("views", type=options.PATH)
@options.output("Fused map to write, such as X.fused.h5; a folder with --all.")
@options.parameters(FuseDepth)
@options.common
def main(views: Path, output: Path, params: FuseDepth, run: Run) -> None:
    """Fuse the depth maps of VIEWS into one depth map of a reference view, with its confidence.

    VIEWS is a views artefact, a dense COLMAP workspace, a TUM, Open3D/ICL-NUIM or 7-Scenes recording, or a plain folder
    (depth/, poses.txt, intrinsics.txt). Beside the output come a coloured mesh (.ply) and a report to open (.html).
    With --all each view is the reference in turn and the output a folder of NAME.fused.h5, which `ipcli merge-depth`
    joins.
    """
    from ipcli.stages.fusion import fuse_depth

    with options.progress("fuse-depth", run) as tell:
        if params.every:
            facts = fuse_depth.summary_of_all(output, fuse_depth.run_all(views, output, params, run, tell))
        else:
            fuse_depth.run(views, output, params, run, tell)
            facts = fuse_depth.summary(output)
    options.conclude(facts, run, with_figures=True)
