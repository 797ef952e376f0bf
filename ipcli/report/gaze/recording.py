"""The page of a `recording`: what it holds."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ipcli.report.kit import pictures
from ipcli.report.kit.numbers import number, percent
from ipcli.report.kit.page import page as document
from ipcli.report.kit.page import section, table
from ipcli.report.kit.provenance import origin


def needed(name: str) -> bool:
    """All but the pictures."""
    return not name.startswith("frames/")


def page(arrays: Mapping[str, np.ndarray], provenance: Mapping[str, object], *, widest: int = pictures.WIDEST) -> str:
    """The HTML of a recording: frames, cameras, gaze."""
    a = arrays
    seconds = float(a["times"][-1] - a["times"][0])
    verdict = f"{len(a['names'])} frames over {number(seconds)} s, {len(a['rig/models'])} cameras, from {a['source']}."
    rows = [
        [f"{n}", f"{size[0]} × {size[1]}", str(model), *(number(float(k[i])) for i in ((0, 0), (1, 1), (0, 2), (1, 2)))]
        for n, (size, model, k) in enumerate(zip(a["rig/sizes"], a["rig/models"], a["rig/intrinsics"], strict=True))
    ]
    parts = [section("Cameras", table(["camera", "size", "lens", "fx", "fy", "cx", "cy"], rows))]
    if "gaze/times" in a:
        valid = float(a["gaze/valid"].mean()) if len(a["gaze/valid"]) else float("nan")
        parts.append(section("Gaze", table(["samples", "valid"], [[f"{len(a['gaze/times'])}", percent(valid)]])))
    return document("Recording", "ipcli import-recording", verdict, *parts, origin(provenance))
