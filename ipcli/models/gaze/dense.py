"""Dense depth of the frames of a map, as views for the fusion of chapter 4."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from ipcli.errors import ParameterError
from ipcli.measurements.recording import HeadRecording
from ipcli.measurements.views import View
from ipcli.models.gaze import localise
from ipcli.models.gaze.surface import Matcher
from ipcli.progress import Progress, silent

NEAREST = 2.0  # percentile of the map points' depth, half of which is still searched


def baseline_focal(recording: HeadRecording) -> float:
    """Pixels * metres: disparity = baseline_focal / depth."""
    rig = localise.rig_of(recording)
    return rig.focal * (rig.baseline or 1.0)


def views(
    recording: HeadRecording, found: Mapping[str, np.ndarray], every: int, sigma: float, tell: Progress = silent
) -> Iterator[View]:
    """The frames of the map, rectified, with their depth. ParameterError for the experiment of another recording."""
    import cv2

    if tuple(found["names"]) != recording.names:
        raise ParameterError("the experiment is of another recording: its frames have other names")
    rig = replace(localise.rig_of(recording), offset=float(found["offset"]))
    matcher = Matcher(rig, sigma)
    chosen = np.flatnonzero(found["in_map"])[::every]
    for done, k in enumerate(chosen):
        rig_from_world = np.linalg.inv(found["world_from_rig"][k])
        z = (found["map/points"] @ rig_from_world[:3, :3].T + rig_from_world[:3, 3])[:, 2]
        frame = recording.load(int(k))
        surface = matcher.surface(frame, 0.5 * float(np.percentile(z[z > 0], NEAREST)))
        pose = np.eye(4)
        pose[:3, :3] = surface.rectified_from_rig
        image = frame.colour if frame.colour is not None else np.repeat(frame.left[..., None], 3, axis=2)
        if rig.is_stereo:
            image = cv2.remap(image, *matcher.maps[0], cv2.INTER_LINEAR)
        depth = (1 / surface.inverse).astype(np.float32)
        tell((done + 1) / len(chosen), recording.names[k])
        yield View(recording.names[k], depth, surface.intrinsics, pose @ rig_from_world, image=image)
