"""`ipcli merge-depth`: one cloud of a whole sequence."""

from __future__ import annotations

from pathlib import Path

import click

from ipcli.cli import options
from ipcli.params import Run
from ipcli.stages.fusion.parameters import MergeDepth


@click.command("merge-depth")
@click.argument("files", type=options.PATH, nargs=-1, required=True)
@options.output("Cloud to write, such as X.ply.")
@options.parameters(MergeDepth)
@options.common
def main(files: tuple[Path, ...], output: Path, params: MergeDepth, run: Run) -> None:
    """Join fused depth maps (FILES, of `fuse-depth --all`) into one coloured cloud of what enough of them agree on.

    Written are the cloud (.ply), the artefact that vouches for it (.h5) and a page to open (.html).
    """
    from ipcli.stages.fusion import merge_depth

    merge_depth.run(files, output, params, run)
    options.conclude(merge_depth.summary(output), run, with_figures=True)
