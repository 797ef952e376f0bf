"""import-recording: pictures, calibration, gaze and truth of any known layout -> one `recording` artefact."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ipcli.io.files.images import encode_png
from ipcli.io.gaze.artefact import recording_arrays
from ipcli.measurements.recording import HeadRecording
from ipcli.models.gaze.experiment import gaze_arrays, rig_arrays
from ipcli.params import Run
from ipcli.progress import Progress, silent
from ipcli.stages.gaze.parameters import ImportRecording
from ipcli.stages.gaze.sources import open_source
from ipcli.stages.kit.artefact import Job, Outcome, make


def run(source: Path, output: Path, params: ImportRecording, run: Run, progress: Progress = silent) -> Outcome:
    """Write the artefact. Pictures are kept without loss, as PNG."""
    recording = open_source(source, params.source)

    def build() -> dict[str, np.ndarray]:
        arrays = recording_arrays(recording, lambda k: _encoded(recording, k, progress)) | rig_arrays(recording.cameras)
        return arrays | (gaze_arrays(recording.gaze) if recording.gaze is not None else {})

    return make(Job(output, "recording", "import-recording", params, recording.files), build, run)


def _encoded(recording: HeadRecording, k: int, progress: Progress) -> dict[str, np.ndarray]:
    frame = recording.load(k)
    shown = frame.left if frame.colour is None else frame.colour
    arrays = {"left": np.frombuffer(encode_png(shown), np.uint8)}
    if frame.right is not None:
        arrays["right"] = np.frombuffer(encode_png(frame.right), np.uint8)
    if frame.depth is not None:
        arrays["depth"] = frame.depth
    progress((k + 1) / len(recording.names), recording.names[k])
    return arrays
