"""Where the commands of depth fusion take their views from."""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np

from ipcli import threads
from ipcli.errors import FormatError, ParameterError, nearest
from ipcli.io.views import layouts
from ipcli.measurements.views import View, Views
from ipcli.models.fusion.scenes import Scene
from ipcli.params import as_dict
from ipcli.stages.fusion.parameters import ViewSource

MOST_NAMED = 5  # views in a message
log = logging.getLogger(__name__)


def open_source(path: Path, source: ViewSource) -> Views:
    """The views at ``path``. Raises what io.views.layouts.open_views raises."""
    views = layouts.open_views(path, **as_dict(source))
    for note in views.notes:
        log.warning("%s: %s", path, note)
    return views


def source_files(views: Views, names: tuple[str, ...]) -> tuple[Path, ...]:
    """The files that the views of these names are made of, each once."""
    return tuple(dict.fromkeys(file for name in names for file in views.files(name)))


def middle(names: tuple[str, ...]) -> str:
    """The view to fuse into when none is named."""
    return names[(len(names) - 1) // 2]


def open_truth(path: Path, reference: str | None) -> tuple[Views, View, np.ndarray]:
    """The views at ``path``, the one to fuse into and its truth (h, w): ``reference``, or None for the middle one.
    Raises ParameterError for one that is not there, FormatError if its truth is not known.
    """
    source = layouts.open_views(path)
    name = reference or middle(source.names)
    if name not in source.names:
        raise ParameterError(f"{path}: no view '{name}'{nearest(name, source.names)}")
    view = source.load(name)
    if view.truth is None:
        known = [other for other in source.names if source.load(other).truth is not None]
        more = f" and {len(known) - MOST_NAMED} more" if len(known) > MOST_NAMED else ""
        fix = f"Give --reference {', '.join(known[:MOST_NAMED])}{more}" if known else "No view here has a truth"
        raise FormatError(path, f"the true depth of view '{name}' is not known", fix=fix)
    return source, view, view.truth


def open_scene(path: Path, reference: str | None, domain: str) -> Scene:
    """All views at ``path`` in memory, to be fused into one of them whose truth is known.

    ``domain`` auto is the quantity that was measured. Raises what open_truth raises.
    """
    source, chosen, truth = open_truth(path, reference)
    views = threads.each(lambda name: chosen if name == chosen.name else source.load(name), source.names)
    inverse = (source.measured if domain == "auto" else domain) == "disparity"
    return Scene(views, chosen, truth, inverse, source.baseline_focal, source.unit)
