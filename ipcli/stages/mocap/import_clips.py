"""import-clips: motion files of any known format -> one `clips` artefact, at one rate if wanted."""

from __future__ import annotations

import logging
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from ipcli.errors import FormatError, ParameterError
from ipcli.params import Run, as_dict, option
from ipcli.progress import Progress, silent

if TYPE_CHECKING:
    import numpy as np

    from ipcli.measurements.motions import Clips
    from ipcli.stages.kit.artefact import Outcome

log = logging.getLogger(__name__)
USUAL = (0.5, 3.5)  # metres a whole body spans; outside a wrong unit is more likely than such a body


@dataclass(frozen=True)
class Source:
    """What the files do not say; each is refused where the format has no use for it, and None leaves the format's own
    default.
    """

    format: str = option("auto", "Layout: auto, clips, florence3d, utkinect or files.", flag="--format")
    unit: str | None = option(
        None, "Unit of length of the files: m, cm, mm, inch, or metres as a number.", flag="--unit"
    )
    up: str | None = option(None, "Axis of the files that points up.", flag="--up", choices=("x", "y", "z"))
    source_rate: float | None = option(
        None, "Rate of files that do not say it.", flag="--source-rate", low=0.0, unit="Hz"
    )
    manifest: str | None = option(None, "CSV file: path,label,actor[,start,stop,name,split].", flag="--manifest")


@dataclass(frozen=True)
class Params:
    """Which clips, and at what rate."""

    rate: float | None = option(None, "Rate to bring all clips to.", flag="--rate", low=0.0, unit="Hz")
    labels: str | None = option(None, "Actions to take, with commas.", flag="--labels")
    source: Source = field(default_factory=Source)


def run(
    source: Path,
    output: Path,
    params: Params,
    run: Run,
    progress: Progress = silent,
) -> Outcome:
    """Write the artefact. Raises what io.clips.open_clips raises, and ParameterError for an action that is
    not there.
    """
    from ipcli.io.motion import artefact
    from ipcli.measurements.motions import resample_clip
    from ipcli.stages.kit.artefact import Job, make

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


def open_source(path: Path, source: Source) -> Clips:
    """The clips at `path`. Raises what io.clips.open_clips raises."""
    from ipcli.io.motion.layouts import open_clips

    hints = as_dict(source)
    return open_clips(path, **hints | {"manifest": Path(source.manifest) if source.manifest else None})


def _chosen(clips: Clips, labels: str | None) -> tuple[str, ...]:
    from ipcli.measurements.names import position

    if labels is None:
        return clips.names
    known = tuple(dict.fromkeys(clips.labels))
    wanted = {known[position(known, label.strip(), "action")] for label in labels.split(",")}
    return tuple(name for name, label in zip(clips.names, clips.labels, strict=True) if label in wanted)


def _mind_the_size(source: Path, clips: list) -> None:
    """Warn when the bodies are of an odd size: a whole set in a wrong unit does not fail by itself."""
    import numpy as np

    from ipcli.geometry.motion import span

    if not clips:
        raise FormatError(source, "no clips", fix="Check the folder")
    size = float(np.nanmedian([span(clip.motion.positions) for clip in clips]))
    if not USUAL[0] <= size <= USUAL[1]:
        log.warning(
            "%s: the bodies span %.2g m. If that is not their size, give the unit of the files with --unit",
            source,
            size,
        )
