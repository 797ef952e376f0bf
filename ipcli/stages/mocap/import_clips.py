"""import-clips: motion files of any known format -> one `clips` artefact, at one rate if wanted."""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np

from ipcli.errors import FormatError, ParameterError
from ipcli.geometry.motion import span
from ipcli.io.motion import artefact
from ipcli.measurements.motions import Clip, Clips, resample_clip
from ipcli.measurements.names import position
from ipcli.params import Run
from ipcli.progress import Progress, silent
from ipcli.stages.kit.artefact import Job, Outcome, make
from ipcli.stages.mocap.parameters import ImportClips
from ipcli.stages.mocap.reading import open_source

log = logging.getLogger(__name__)
USUAL = (0.5, 3.5)  # metres a whole body spans; outside a wrong unit is more likely than such a body


def run(
    source: Path,
    output: Path,
    params: ImportClips,
    run: Run,
    progress: Progress = silent,
) -> Outcome:
    """Write the artefact. Raises what open_clips raises, and ParameterError for an action that is not there."""
    if output.resolve().is_relative_to(source.resolve()) and source.is_dir():
        raise ParameterError(
            f"{output}: lies in the source. Write it elsewhere, or the source is another one the next time"
        )

    def build() -> dict[str, np.ndarray]:
        clips = open_source(source, params.source)
        names = _chosen(clips, params.labels)
        read = []
        for count, name in enumerate(names, start=1):
            clip = clips.load(name)
            read.append(resample_clip(clip, params.rate) if params.rate else clip)
            progress(count / len(names), name)
        _mind_the_size(source, read)
        places = [clips.names.index(name) for name in names]
        return artefact.clips_arrays(read, {split: row[places] for split, row in clips.splits.items()})

    inputs = (source,) if params.source.manifest is None else (source, Path(params.source.manifest))
    return make(Job(output, "clips", "import-clips", params, inputs), build, run)


def _chosen(clips: Clips, labels: str | None) -> tuple[str, ...]:
    if labels is None:
        return clips.names
    known = tuple(dict.fromkeys(clips.labels))
    wanted = {known[position(known, label.strip(), "action")] for label in labels.split(",")}
    return tuple(name for name, label in zip(clips.names, clips.labels, strict=True) if label in wanted)


def _mind_the_size(source: Path, clips: list[Clip]) -> None:
    """Warn when the bodies are of an odd size: a whole set in a wrong unit does not fail by itself."""
    if not clips:
        raise FormatError(source, "no clips", fix="Check the folder")
    size = float(np.nanmedian([span(clip.motion.positions) for clip in clips]))
    if not USUAL[0] <= size <= USUAL[1]:
        log.warning(
            "%s: the bodies span %.2g m. If that is not their size, give the unit of the files with --unit",
            source,
            size,
        )
