"""import-clips: motion files of any known format -> one `clips` artefact, at one rate if wanted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ipcli.errors import FormatError, ParameterError
from ipcli.io.motion import artefact
from ipcli.measurements.motions import Clip, Clips, onto, resample_clip
from ipcli.measurements.names import position
from ipcli.models.mocap import checks
from ipcli.params import Run
from ipcli.progress import Progress, silent
from ipcli.stages.kit.artefact import Job, Outcome, make
from ipcli.stages.mocap.parameters import ImportClips
from ipcli.stages.mocap.reading import open_source, tell


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
        clips, names, renamed = chosen(source, params)
        read = []
        for count, name in enumerate(names, start=1):
            clip = clips.load(name)
            clip = _renamed(_on_one_skeleton(clip, clips), renamed)
            read.append(resample_clip(clip, params.rate) if params.rate else clip)
            progress(count / len(names), name)
        if not read:
            raise FormatError(source, "no clips", fix="Check the folder")
        odd = [*clips.notes, *checks.notes(read), *checks.doubts(read)]
        tell(source, odd)
        places = [clips.names.index(name) for name in names]
        return artefact.clips_arrays(read, {split: row[places] for split, row in clips.splits.items()}, odd)

    inputs = (source,) if params.source.manifest is None else (source, Path(params.source.manifest))
    job = Job(output, "clips", "import-clips", params, inputs, look=lambda: chosen(source, params))
    return make(job, build, run)


def chosen(source: Path, params: ImportClips) -> tuple[Clips, tuple[str, ...], dict[str, str]]:
    """The clips of the source, the names of those that are wanted, and the new names of actions. Raises what open_clips
    raises, and ParameterError for an action that is not there.
    """
    clips = open_source(source, params.source)
    return clips, _labelled(clips, params.labels), new_names(clips.labels, params.rename)


def _labelled(clips: Clips, labels: str | None) -> tuple[str, ...]:
    if labels is None:
        return clips.names
    known = tuple(dict.fromkeys(clips.labels))
    wanted = {known[position(known, label.strip(), "action")] for label in labels.split(",")}
    return tuple(name for name, label in zip(clips.names, clips.labels, strict=True) if label in wanted)


def new_names(labels: Sequence[str], rename: str | None) -> dict[str, str]:
    """The new name of each action that gets one. Raises ParameterError for a pair that is none, and an action that is
    not there.
    """
    known = tuple(dict.fromkeys(labels))
    found = {}
    for pair in rename.split(",") if rename else ():
        old, sign, new = (part.strip() for part in pair.partition("="))
        if not (old and sign and new):
            raise ParameterError(f"--rename {pair.strip()}: expected OLD=NEW, such as 'answer phone=drink'")
        found[known[position(known, old, "action")]] = new
    return found


def _renamed(clip: Clip, names: Mapping[str, str]) -> Clip:
    """The clip with the new name of its action, of its frames too."""
    own = clip.frame_labels
    frames = None if own is None else np.array([names.get(str(label), str(label)) for label in own], np.str_)
    return replace(clip, label=names.get(clip.label, clip.label), frame_labels=frames)


def _on_one_skeleton(clip: Clip, clips: Clips) -> Clip:
    """The clip with the joints of the first, by their names, and a note of those that only one of them has."""
    own, first = clip.motion.skeleton.joints, clips.skeleton.joints
    motion = onto(clip.motion, clips.skeleton)
    lost, gone = ([name for name in one if name not in other] for one, other in ((first, own), (own, first)))
    if len(lost) == len(first):
        fix = "Import the files of each skeleton on their own"
        raise FormatError(
            clip.name, f"another skeleton than that of '{clips.names[0]}'", got=", ".join(own[:4]), fix=fix
        )
    notes = [f"no joint '{name}', which the first clip has: not seen" for name in lost]
    notes += [f"joint '{name}' is left out: the first clip has none" for name in gone]
    motion = replace(motion, skeleton=clips.skeleton, notes=(*motion.notes, *notes))
    return replace(clip, motion=motion)
