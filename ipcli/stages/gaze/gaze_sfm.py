"""gaze-sfm: a head-mounted recording with gaze -> head path, map, subsequences, points of regard (thesis 3.2)."""

from __future__ import annotations

import logging
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from ipcli.errors import ParameterError
from ipcli.params import Run
from ipcli.progress import Progress, silent
from ipcli.stages.gaze.parameters import GazeSfm as Params
from ipcli.stages.gaze.sources import open_source
from ipcli.stages.kit.summary import of_result

log = logging.getLogger(__name__)

if TYPE_CHECKING:
    import numpy as np

    from ipcli.stages.kit.artefact import Outcome


def run(source: Path, output: Path, params: Params, run: Run, progress: Progress = silent) -> Outcome:
    """Write the experiment and beside it por.csv, a TUM trajectory, a PLY, a COLMAP model (text) and a page.

    NoSolution when no frame could be localised.
    """
    from ipcli.io.files import h5
    from ipcli.io.gaze.areas_file import read_areas
    from ipcli.io.gaze.landmarks_file import read_landmarks
    from ipcli.models.gaze import world
    from ipcli.models.gaze.areas import attention
    from ipcli.models.gaze.experiment import experiment
    from ipcli.models.gaze.known_map import WANTED, known_map
    from ipcli.stages.gaze import exports
    from ipcli.stages.kit.artefact import Job, make
    from ipcli.stages.kit.pages import page

    recording = open_source(source, params.source)
    if params.poses_only:
        recording = replace(recording, gaze=None)

    if params.aoi is not None and recording.gaze is None:
        raise ParameterError("--aoi: there is no gaze to be on areas of interest")
    extra = tuple(Path(name) for name in (params.aoi, params.world, params.map) if name is not None)
    areas = read_areas(Path(params.aoi)) if params.aoi is not None else None
    marks = read_landmarks(Path(params.world)) if params.world is not None else None

    earlier = None
    if params.map is not None:
        earlier = known_map(h5.read(Path(params.map), "gaze-experiment", only=lambda name: name in WANTED).arrays)

    if recording.gaze is None and not params.poses_only:
        log.warning("%s: no gaze, so no points of regard: give --gaze FILE, or --poses-only to do without", source)

    def build() -> dict[str, np.ndarray]:
        found = experiment(recording, params.localisation, run.seed, progress, earlier)
        if marks is not None:
            found = world.laid_on(found, marks, with_scale=params.world_scale)
        if areas is not None:
            seen = (found["gaze/times"], found["por/points"], found["por/fixation"])
            found |= attention(*seen, areas, params.aoi_margin)
        return found

    beside = exports.beside(output, has_gaze=recording.gaze is not None, has_areas=areas is not None)
    beside |= page(output, "gaze-experiment")
    job = Job(output, "gaze-experiment", "gaze-sfm", params, (*recording.files, *extra), beside)
    return make(job, build, run)


@of_result
def summary(output: Path) -> dict[str, object]:
    """The figures that a person wants to see at once."""
    from ipcli.io.files import h5
    from ipcli.models.gaze.evaluation import summary as figures

    wanted = ("world_from_rig", "lost", "keyframe", "offset", "truth", "por/outcome", "por/covariance", "in_map")
    return figures(h5.read(output, "gaze-experiment", only=lambda name: name in wanted).arrays)
