"""`gaze-sfm`: where was the wearer, and what were they looking at. `gaze-sfm check` looks before the long work."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ipcli.cli import options
from ipcli.params import Run
from ipcli.stages.gaze.parameters import Check, GazeSfm


class WithCheck(click.Command):
    """A command whose first argument may be `check`, which is a command of its own."""

    def make_context(
        self, info_name: str | None, args: list[str], parent: click.Context | None = None, **extra: Any
    ) -> click.Context:
        """The context of `check` where that is asked for."""
        if args and args[0] == "check":
            return check.make_context(f"{info_name} check", args[1:], parent, **extra)
        return super().make_context(info_name, args, parent, **extra)

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command that the context is of."""
        return super().invoke(ctx) if ctx.command is self else ctx.command.invoke(ctx)


@click.command("gaze-sfm", cls=WithCheck)
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
    facts = gaze_sfm.summary(output)
    if not run.json:
        click.echo("\n".join([str(output), *(f"{key}: {value}" for key, value in facts.items() if key != "output")]))
    else:
        options.conclude(facts, run)


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
