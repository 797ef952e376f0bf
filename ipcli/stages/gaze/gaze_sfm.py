"""gaze-sfm: a head-mounted recording with gaze -> head path, map, subsequences, points of regard (thesis 3.2)."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from ipcli.errors import ParameterError
from ipcli.io.files import h5
from ipcli.io.gaze.areas_file import read_areas
from ipcli.io.gaze.landmarks_file import read_landmarks
from ipcli.io.gaze.picture_model import read_picture_model
from ipcli.models.gaze import known_map, world
from ipcli.models.gaze.areas import attention
from ipcli.models.gaze.evaluation import summary as figures
from ipcli.models.gaze.experiment import NO_GAZE, experiment
from ipcli.models.gaze.known_map import KnownMap
from ipcli.params import Run
from ipcli.progress import Progress, silent
from ipcli.stages.gaze import exports
from ipcli.stages.gaze.parameters import GazeSfm as Params
from ipcli.stages.gaze.sources import open_source
from ipcli.stages.kit.artefact import Job, Outcome, make
from ipcli.stages.kit.pages import page
from ipcli.stages.kit.summary import of_result

log = logging.getLogger(__name__)


def run(source: Path, output: Path, params: Params, run: Run, progress: Progress = silent) -> Outcome:
    """Write the experiment and beside it por.csv, a TUM trajectory, a PLY, a COLMAP model (text) and a page.

    NoSolution when no frame could be localised.
    """
    recording = open_source(source, params.source)
    if params.poses_only:
        recording = replace(recording, gaze=None)

    if params.aoi is not None and recording.gaze is None:
        raise ParameterError("--aoi: there is no gaze to be on areas of interest")
    extra = tuple(Path(name) for name in (params.aoi, params.world) if name is not None)
    areas = read_areas(Path(params.aoi)) if params.aoi is not None else None
    marks = read_landmarks(Path(params.world)) if params.world is not None else None

    load_map, of_map = _earlier(params)

    if recording.gaze is None and not params.poses_only:
        log.warning("%s: no gaze, so no points of regard: give --gaze FILE, or --poses-only to do without", source)

    def build() -> dict[str, np.ndarray]:
        found = experiment(recording, params.localisation, run.seed, progress, load_map() if load_map else None)
        said = {*recording.dropped, *(recording.gaze.dropped if recording.gaze else ()), NO_GAZE}
        for note in found["notes"].tolist():
            if note not in said:
                log.warning("%s: %s", source, note)
        if marks is not None:
            found = world.laid_on(found, marks, with_scale=params.world_scale)
        if areas is not None:
            seen = (found["gaze/times"], found["por/points"], found["por/fixation"])
            found |= attention(*seen, areas, params.aoi_margin)
        return found

    beside = exports.beside(output, has_gaze=recording.gaze is not None, has_areas=areas is not None)
    beside |= page(output, "gaze-experiment")
    job = Job(output, "gaze-experiment", "gaze-sfm", params, (*recording.files, *extra, *of_map), beside)
    return make(job, build, run)


def _earlier(params: Params) -> tuple[Callable[[], KnownMap] | None, tuple[Path, ...]]:
    """How the map to localise in is made, and its files. ParameterError for a model and its pictures without the other.

    A run is read at once, so that one that is no map is told before any work.
    """
    is_model = params.map is not None and Path(params.map).is_dir()
    if is_model != (params.map_images is not None):
        raise ParameterError("--map of a COLMAP model, a folder, and --map-images, its pictures, need each other")
    if params.map is None:
        return None, ()
    path = Path(params.map)
    if params.map_images is None:
        found = known_map.known_map(h5.read(path, "gaze-experiment", only=lambda name: name in known_map.WANTED).arrays)
        return lambda: found, (path,)
    model = read_picture_model(path, Path(params.map_images))
    return lambda: known_map.map_of_model(model, params.localisation.detection), model.files


@of_result
def summary(output: Path) -> dict[str, object]:
    """The figures that a person wants to see at once."""
    wanted = ("world_from_rig", "lost", "keyframe", "offset", "truth", "por/outcome", "por/covariance", "in_map")
    return figures(h5.read(output, "gaze-experiment", only=lambda name: name in wanted).arrays)
