"""The layouts of fixation sets that are read: pictures or surfaces, and where people looked."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ipcli.io.fixations import folder, osie, surfaces
from ipcli.io.sources import Layout, open_source
from ipcli.measurements.fixations import FixationSet

LAYOUTS: dict[str, Layout[FixationSet]] = {
    "osie": Layout(osie.is_osie, osie.open_osie, "fixations.mat and stimuli/"),
    "surfaces": Layout(
        surfaces.is_surface_set, surfaces.open_surface_set, "a folder of NAME.npz: xyz, normal, fix_time"
    ),
    "folder": Layout(folder.is_folder, folder.open_folder, "pictures and fixations.csv: picture, x, y[, observer]"),
}


def open_fixations(path: Path, format: str = "auto", **hints: Any) -> FixationSet:
    """The fixation set at `path`, pictures read only when asked for. Raises what `io.sources.open_source` raises."""
    fix = "Write fixations.csv with the columns picture, x, y beside the pictures"
    return open_source(path, LAYOUTS, "fixation sets", fix, format, **hints)
