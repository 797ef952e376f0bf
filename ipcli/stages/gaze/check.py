"""gaze-sfm check: figures and warnings on a recording, nothing written."""

from __future__ import annotations

from pathlib import Path

from ipcli.models.gaze import checks
from ipcli.stages.gaze.parameters import Check
from ipcli.stages.gaze.sources import open_source


def run(source: Path, params: Check) -> tuple[dict[str, object], list[str]]:
    """Figures by name, and warnings in words."""
    recording = open_source(source, params.source)
    return checks.verdict(recording, checks.pairs(recording, params.localisation, params.pairs))
