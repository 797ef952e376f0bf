"""`model-animal`: a closed model of an animal from images with part masks."""

from __future__ import annotations

from pathlib import Path

import click

from ipcli.cli import options
from ipcli.params import Run
from ipcli.stages.animal.parameters import ModelAnimal


@click.command("model-animal")
@click.argument("words", nargs=-1, required=True, metavar="PROJECT.toml | check MESH...")
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Model to write: X.glb, X.ply, X.obj or X.stl.")
@options.parameters(ModelAnimal)
@options.common
def main(words: tuple[str, ...], output: Path | None, params: ModelAnimal, run: Run) -> None:
    """Model an animal (or anything articulated) from a few images in which its parts are marked.

    PROJECT.toml names the parts, their tree and the images with their masks. Written are the model with one node a
    part, X.h5 with everything about it, a report X.html and a page X.turn.html in which it can be turned.

    `model-animal check MESH...` tells of meshes whether they are closed, and their volume, pieces and least thickness;
    exit code 1 when one is not closed.
    """
    if words[0] == "check":
        _check(words[1:], run)
        return
    if len(words) > 1 or output is None:
        raise click.UsageError("give one PROJECT.toml and -o OUTPUT, or check MESH...")
    from ipcli.stages.animal import model_animal

    model_animal.check_suffix(output)
    with options.progress("model-animal", run) as tell:
        made, _ = model_animal.run(Path(words[0]), output, params, run, tell)
    model = params.stop_after == "assembly" and not run.dry_run
    result = output if model else made
    options.conclude({"output": result} | (model_animal.facts(made) if model else {}), run, with_figures=True)


def _check(meshes: tuple[str, ...], run: Run) -> None:
    from ipcli.stages.animal import check_mesh

    if not meshes:
        raise click.UsageError("check: give the meshes to check")
    sound = [check_mesh.check(Path(path)) for path in meshes]
    for facts in sound:
        options.conclude(facts, run)
    if not all(facts["watertight"] for facts in sound):
        raise click.exceptions.Exit(1)
