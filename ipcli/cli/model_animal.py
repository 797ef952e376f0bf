"""`model-animal`: a closed model of an animal from images with part masks."""

from __future__ import annotations

from pathlib import Path

import click

from ipcli.cli import options
from ipcli.params import Run
from ipcli.stages.animal.parameters import ModelAnimal


@click.command("check")
@click.argument("meshes", type=options.PATH, nargs=-1, required=True)
@options.reading
def check(meshes: tuple[Path, ...], run: Run) -> None:
    """Tell whether MESHES are closed, and their volume, pieces and least thickness; exit code 1 if one is not."""
    from ipcli.stages.animal import check_mesh

    sound = [check_mesh.check(path) for path in meshes]
    for facts in sound:
        options.conclude(check_mesh.told(facts), run)
    if not all(facts["watertight"] for facts in sound):
        raise click.exceptions.Exit(1)


@click.command("model-animal", cls=options.first_word(check=lambda: check))
@click.argument("project", type=options.PATH, metavar="PROJECT.toml")
@options.output("Model to write: X.glb, X.ply, X.obj or X.stl.")
@options.parameters(ModelAnimal)
@options.common
def main(project: Path, output: Path, params: ModelAnimal, run: Run) -> None:
    """Model an animal (or anything articulated) from a few images in which its parts are marked.

    PROJECT.toml names the parts, their tree and the images with their masks. Written are the model with one node a
    part, X.h5 with everything about it, a report X.html and a page X.turn.html in which it can be turned.
    `model-animal check MESH...` tells whether meshes are closed, and how thick they are.
    """
    from ipcli.stages.animal import model_animal

    model_animal.check_suffix(output)
    with options.progress("model-animal", run) as tell:
        made, _ = model_animal.run(project, output, params, run, tell)
    model = params.stop_after == "assembly" and not run.dry_run
    result = output if model else made
    options.conclude({"output": result} | (model_animal.facts(made) if model else {}), run, with_figures=True)
