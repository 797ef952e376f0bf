"""The command `brdf-train`."""

from __future__ import annotations

from pathlib import Path

import click

from ipcli.cli.options import common, conclude, parameters, progress
from ipcli.params import Run
from ipcli.stages.brdf.parameters import BrdfTrain


@click.command("brdf-train")
@click.argument("materials", type=click.Path(path_type=Path))
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), required=True, help="Library to write, with a page beside it."
)
@parameters(BrdfTrain)
@common
def main(materials: Path, output: Path, params: BrdfTrain, run: Run) -> None:
    """Learn how MATERIALS look under all lights.

    MATERIALS is a TOML file that lists materials and light probes; sample_data/brdf/materials.toml needs no other file.

    The console tells how many materials, lights and reflectance maps the library holds (a probe at each of its headings
    is a map of each material), from how many generated scenes the judge of rims learnt, and the shares that are told
    right on scenes that were held out.
    """
    from ipcli.stages.brdf import brdf_train

    with progress("brdf-train", run) as tell:
        brdf_train.run(materials, output, params, run, tell)
    conclude(brdf_train.summary(output), run, with_figures=True)
