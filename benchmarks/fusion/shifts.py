"""How far apart sound sequences and those whose poses are shifted by one view are, for the warning of fuse-depth.

    python -m benchmarks.fusion.shifts VIEWS

Each frame of the sequence in its window of seven, and again of every third frame: so many times better do its
neighbours agree with it if each takes the pose of the next view or of the last. The warning asks for SHIFT_BETTER, and
that the views next to it say so as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.kit.arguments import parser_of
from benchmarks.kit.publish import publish
from ipcli.measurements.names import window
from ipcli.measurements.views import View
from ipcli.models.fusion.checks import SHIFT_BETTER, shift_warnings, shifted, thinned
from ipcli.stages.fusion.parameters import FuseDepth
from ipcli.stages.fusion.sources import open_source

NAME, TITLE = "fusion_shifts", "Fusion: poses that are shifted by one view"
STEPS = (1, 3)
AROUND = 7  # views of a window


def moved(views: Sequence[View]) -> list[View]:
    """Each view with the pose of the next one; the last is left out."""
    return [replace(a, cam_from_world=b.cam_from_world) for a, b in zip(views[:-1], views[1:], strict=True)]


def judged(views: Sequence[View]) -> tuple[np.ndarray, np.ndarray]:
    """Of each view in its window: how many times better its neighbours agree with it by other poses, at the best, and
    whether fuse-depth warns. Infinite and undefined ones are left out.
    """
    by_name, names, found = {view.name: view for view in views}, [view.name for view in views], []
    for view in views:
        near = [by_name[name] for name in window(names, view.name, AROUND)]
        tried = [now / then for then, now, _ in shifted(near, view) if np.isfinite([now, then]).all()]
        if tried:
            found.append((max(tried), max(tried) > SHIFT_BETTER and bool(shift_warnings(near, view))))
    gains, warned = zip(*found, strict=True)
    return np.array(gains), np.array(warned)


def row(views: Sequence[View], step: int) -> dict[str, Any]:
    """Of every `step`-th view: the range of the gains and the share warned of, as they are and with shifted poses."""
    own = views[::step]
    (sound, alarms), (wrong, warned) = judged(own), judged(moved(own))
    told = {"every": step, "windows": len(sound), "sound, greatest": sound.max(), "sound, warned of": alarms.mean()}
    told |= {"shifted, least": wrong.min(), "shifted, greatest": wrong.max(), "shifted, warned of": warned.mean()}
    return told


def main(arguments: list[str] | None = None) -> None:
    """Measure, write, print."""
    parser = parser_of(__doc__, "every third frame alone")
    parser.add_argument("views", type=Path, metavar="VIEWS", help="a sequence, as fuse-depth takes it")
    options = parser.parse_args(arguments)
    source = open_source(options.views, FuseDepth().source)
    views = [thinned(source.load(name, pictures=False)) for name in source.names]
    rows = [row(views, step) for step in (STEPS[1:] if options.quick else STEPS)]
    publish(NAME, TITLE, {f"{len(views)} views": rows}, {"asked for": SHIFT_BETTER}, options.output)


if __name__ == "__main__":
    main()
