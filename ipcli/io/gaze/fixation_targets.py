"""Places in camera 0's pictures that the wearer is known to have looked at, to calibrate the gaze by."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ipcli.errors import FormatError
from ipcli.io.gaze.gaze_files import columns_of
from ipcli.measurements.recording import FixationTargets

AROUND = 0.15  # seconds before and after a time without an end
NEEDED = ("time [s]", "x [px]", "y [px]")


def read_fixation_targets(path: Path) -> FixationTargets:
    """A table `time [s],x [px],y [px]`, optionally `until [s]`, a line a fixation. FormatError for any other."""
    columns = columns_of(path)
    names = [*NEEDED, *(["until [s]"] if "until [s]" in columns else [])]
    if not all(name in columns and columns[name].dtype.kind == "f" for name in names):
        raise FormatError(path, "no table of fixation targets", expected=", ".join(NEEDED), got=", ".join(columns))
    if not all(np.isfinite(columns[name]).all() for name in names):
        raise FormatError(path, "a fixation target has no time or place", expected="finite numbers")
    start = columns["time [s]"]
    spans = [start, columns["until [s]"]] if "until [s]" in columns else [start - AROUND, start + AROUND]
    return FixationTargets(np.stack(spans, axis=1), np.stack([columns["x [px]"], columns["y [px]"]], axis=1))
