"""gaze-sfm: a head-mounted recording with gaze -> head path, map, subsequences, points of regard (thesis 3.2)."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from ipcli.params import Run
from ipcli.progress import Progress, silent
from ipcli.stages.gaze.parameters import GazeSfm as Params
from ipcli.stages.gaze.sources import open_source

if TYPE_CHECKING:
    import numpy as np

    from ipcli.stages.kit.artefact import Outcome


def run(source: Path, output: Path, params: Params, run: Run, progress: Progress = silent) -> Outcome:
    """Write the experiment and beside it por.csv, a TUM trajectory, a PLY, a COLMAP model (text) and a page.

    NoSolution when no frame could be localised.
    """
    from ipcli.models.gaze.experiment import experiment
    from ipcli.stages.gaze import exports
    from ipcli.stages.kit.artefact import Job, make
    from ipcli.stages.kit.pages import page

    recording = open_source(source, params.source)
    if params.poses_only:
        recording = replace(recording, gaze=None)

    def build() -> dict[str, np.ndarray]:
        return experiment(recording, params.localisation, run.seed, progress)

    beside = exports.beside(output, has_gaze=recording.gaze is not None) | page(output, "gaze-experiment")
    return make(Job(output, "gaze-experiment", "gaze-sfm", params, recording.files, beside), build, run)


def summary(output: Path) -> dict[str, object]:
    """The figures that a person wants to see at once."""
    from ipcli.io.files import h5
    from ipcli.models.gaze.evaluation import summary as figures

    wanted = ("world_from_rig", "lost", "keyframe", "offset", "truth", "por/outcome", "por/covariance", "in_map")
    return {"output": str(output)} | figures(
        h5.read(output, "gaze-experiment", only=lambda name: name in wanted).arrays
    )
