"""The page of a `recording`: what it holds."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ipcli.report.kit import pictures
from ipcli.report.kit.numbers import number, percent
from ipcli.report.kit.page import Markup, section, table
from ipcli.report.kit.page import page as document
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
    if "imu" in a:
        parts.append(_imu(a["imu"]))
    return document("Recording", "ipcli import-recording", verdict, *parts, origin(provenance))


def _imu(samples: np.ndarray) -> Markup:
    """How many, how often, and which way is up where the head moves little: acceleration holds what carries it."""
    step = float(np.median(np.diff(samples[:, 0]))) if len(samples) > 1 else float("nan")
    mean = samples[:, 4:].mean(axis=0) if len(samples) else np.full(3, np.nan)
    up = ", ".join(number(float(value)) for value in mean / max(float(np.linalg.norm(mean)), 1e-9))
    row = [f"{len(samples)}", number(1 / step if step > 0 else np.nan), number(float(np.linalg.norm(mean))), up]
    head = ["samples", "a second", "mean acceleration, m/s²", "its direction (up) x, y, z"]
    return section("IMU", table(head, [row]), lead="Along the rig's axes: x right, y down, z forward. Kept, not used.")
