"""The command `saliency-predict`."""

from __future__ import annotations

from pathlib import Path

import click

from ipcli.cli import options
from ipcli.params import Run
from ipcli.stages.saliency.parameters import SaliencyPredict


@click.command("saliency-predict")
@click.argument("source", type=options.PATH)
@options.output("Maps to write, with each as a picture (.NAME.png) or cloud (.NAME.ply) and a page beside it.")
@click.option("--model", type=options.PATH, help="What saliency-train learnt; without it nothing learnt is used.")
@options.parameters(SaliencyPredict)
@options.common
def main(source: Path, output: Path, model: Path | None, params: SaliencyPredict, run: Run) -> None:
    """Predict where people look in SOURCE: a picture or a folder of them, a mesh (.ply .obj .off .stl .glb) or a cloud
    (.ply).

    Pictures of a folder that cannot be read are named at the end, when the others are done; the exit code is then 1.
    """
    from ipcli.stages.saliency import saliency_predict

    with options.progress("saliency-predict", run) as tell:
        saliency_predict.run(source, output, model, params, run, tell)
    options.conclude(saliency_predict.summary(output), run, with_figures=True)
