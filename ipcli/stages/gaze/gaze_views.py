"""gaze-views: dense depth of the frames of a map -> a `views` artefact, so that chapter 3 feeds chapter 4."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np

from ipcli.io.files import h5
from ipcli.io.views.artefact import views_arrays
from ipcli.models.gaze import dense
from ipcli.params import Run
from ipcli.progress import Progress, silent
from ipcli.stages.gaze.parameters import GazeViews
from ipcli.stages.gaze.sources import open_source
from ipcli.stages.kit.artefact import Job, Outcome, make


def run(
    source: Path, experiment: Path, output: Path, params: GazeViews, run: Run, progress: Progress = silent
) -> Outcome:
    """Write the views of the recording `source` at the poses of the `experiment` made from it."""
    recording = open_source(source, params.source)
    wanted = ("names", "world_from_rig", "in_map", "offset", "map/points")

    def build() -> dict[str, np.ndarray]:
        found = h5.read(experiment, "gaze-experiment", only=lambda name: name in wanted).arrays
        views = dense.views(recording, found, params.every, params.disparity_sigma, progress)
        return views_arrays(views, unit="m", measured="disparity", baseline_focal=dense.baseline_focal(recording))

    look = partial(h5.read, experiment, "gaze-experiment", lambda name: False)
    job = Job(output, "views", "gaze-views", params, (*recording.files, experiment), look=look)
    return make(job, build, run)
