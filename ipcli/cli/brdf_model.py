"""The command `brdf-model`."""

from __future__ import annotations

from pathlib import Path

import click

from ipcli.cli.options import common, conclude, parameters, progress
from ipcli.params import Run
from ipcli.stages.brdf.parameters import BrdfModel

FILE = click.Path(path_type=Path)


@click.command("brdf-model")
@click.argument("library", type=FILE)
@click.argument("photo", type=FILE, required=False, metavar="PHOTO")
@click.option("--mask", type=FILE, required=True, help="Picture of the same size, white where the object is.")
@click.option(
    "-o",
    "--output",
    type=FILE,
    required=True,
    help="Object to write, with mesh, relief, normal map and page beside it.",
)
@click.option("--normals-from", type=FILE, help="Integrate these normals in place of modelling: PNG, NPY or NPZ.")
@click.option("--true-normals", type=FILE, help="True normals to measure errors by: PNG, NPY or NPZ.")
@click.option(
    "--true-height", type=FILE, help="True heights towards the viewer in pixels to measure errors by: NPY or NPZ."
)
@click.option(
    "--convention",
    type=click.Choice(("opengl", "opencv", "directx")),
    default="opengl",
    help="Convention of --true-normals and --normals-from.  [default: opengl]",
)
@parameters(BrdfModel)
@common
def main(
    library: Path,
    photo: Path | None,
    mask: Path,
    output: Path,
    normals_from: Path | None,
    true_normals: Path | None,
    true_height: Path | None,
    convention: str,
    params: BrdfModel,
    run: Run,
) -> None:
    """Model the surface of the object in PHOTO, with a LIBRARY of brdf-train.

    The console tells: `cut edge`, whether the outline is taken for the edge of a sheet and not the rim of a solid, with
    the probability; `residual`, the mean difference of the picture and what explains it, in its bright values (95th
    percentile), poor above .12; `settled by the picture`, whether it tells a bump from a dent; `material`, the
    likeliest of the library with its probability among those.
    """
    if photo is None:
        raise click.UsageError(f"two files are needed, LIBRARY (of brdf-train) and PHOTO; {library} is one")
    from ipcli.stages.brdf import brdf_model

    source = brdf_model.ObjectFiles(library, photo, mask, true_normals, true_height, convention, normals_from)
    with progress("brdf-model", run) as tell:
        brdf_model.run(source, output, params, run, tell)
    conclude(brdf_model.summary(output), run, with_figures=True)
