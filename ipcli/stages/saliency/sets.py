"""Sets of fixations as the models take them: read, and their channels computed."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from functools import partial
from pathlib import Path

from ipcli.errors import ParameterError
from ipcli.executor import map_items
from ipcli.io.fixations.layouts import open_fixations
from ipcli.measurements.fixations import FixatedPicture, FixatedSurface, FixationSet
from ipcli.models.saliency.channels import channels
from ipcli.models.saliency.validation import Case, case
from ipcli.models.saliency.vertex_features import features
from ipcli.models.saliency.vertex_model import SurfaceCase
from ipcli.progress import Progress, silent

log = logging.getLogger(__name__)


def read(paths: tuple[Path, ...]) -> FixationSet:
    """All sets as one; ParameterError for pictures and surfaces together, or two items of one name."""
    sets = [open_fixations(path) for path in paths]
    for path, one in zip(paths, sets, strict=True):
        for note in one.notes:
            log.warning("%s: %s", path, note)
    whole = FixationSet(
        tuple(item for one in sets for item in one.pictures), tuple(item for one in sets for item in one.surfaces)
    )
    if whole.pictures and whole.surfaces:
        raise ParameterError("pictures and surfaces have features of their own. Give sets of one of the two")
    names = whole.names
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise ParameterError(f"'{twice[0]}' is in the sets twice. Rename one, or give each set once")
    return whole


def inputs(paths: tuple[Path, ...]) -> tuple[Path, ...]:
    """All files of the sets."""
    return tuple(
        file for path in paths for file in (sorted(filter(Path.is_file, path.rglob("*"))) if path.is_dir() else [path])
    )


def cases(pictures: tuple[FixatedPicture, ...], executor: str, progress: Progress = silent) -> list[Case]:
    """The pictures with their channels, on any executor."""
    known = {picture.name: picture for picture in pictures}
    return list(map_items(partial(_case, known), list(known), executor, progress).values())


def _case(known: Mapping[str, FixatedPicture], name: str) -> Case:
    picture = known[name]
    rgb = picture.read()
    return case(name, channels(rgb), picture.fixations, picture.observers, (rgb.shape[0], rgb.shape[1]))


def surface_cases(
    surfaces: tuple[FixatedSurface, ...], executor: str, progress: Progress = silent
) -> list[SurfaceCase]:
    """The surfaces with their features, on any executor."""
    known = {surface.name: surface for surface in surfaces}
    return list(map_items(partial(_surface_case, known), list(known), executor, progress).values())


def _surface_case(known: Mapping[str, FixatedSurface], name: str) -> SurfaceCase:
    surface = known[name]
    return SurfaceCase(name, features(surface.vertices, surface.normals), surface.looked_at, surface.attention)
