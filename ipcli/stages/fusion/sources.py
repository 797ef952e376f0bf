"""Where the commands of depth fusion take their views from."""

from __future__ import annotations

import logging
from pathlib import Path

from ipcli import threads
from ipcli.errors import FormatError, ParameterError, nearest
from ipcli.io.views import layouts
from ipcli.measurements.views import Views
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


def open_scene(path: Path, reference: str | None, domain: str) -> Scene:
    """All views at ``path`` in memory, to be fused into one of them whose truth is known.

    ``reference`` None is the middle view, ``domain`` auto the quantity that was measured. Raises FormatError if the
    view to fuse into has no truth.
    """
    source = layouts.open_views(path)
    name = reference or middle(source.names)
    views = dict(zip(source.names, threads.each(source.load, source.names), strict=True))
    if name not in views:
        raise ParameterError(f"{path}: no view '{name}'{nearest(name, views)}")
    truth = views[name].truth
    if truth is None:
        known = [other for other, view in views.items() if view.truth is not None]
        more = f" and {len(known) - MOST_NAMED} more" if len(known) > MOST_NAMED else ""
        fix = f"Give --reference {', '.join(known[:MOST_NAMED])}{more}" if known else "No view here has a truth"
        raise FormatError(path, f"the true depth of view '{name}' is not known", fix=fix)
    inverse = (source.measured if domain == "auto" else domain) == "disparity"
    return Scene(list(views.values()), views[name], truth, inverse, source.baseline_focal, source.unit)
