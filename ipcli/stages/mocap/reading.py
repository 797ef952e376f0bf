"""What the mocap commands share: clips at paths, of one skeleton, brought to one rate."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ipcli.errors import FormatError, ParameterError, nearest
from ipcli.geometry.skeleton import Groups, Skeleton
from ipcli.io.motion import groups as joint_groups
from ipcli.io.motion.layouts import open_clips
from ipcli.measurements.motions import Clip, Clips, onto, resample_clip
from ipcli.measurements.names import position
from ipcli.models.mocap import checks
from ipcli.models.mocap.features import height
from ipcli.models.mocap.motions import Motions
from ipcli.params import as_dict
from ipcli.stages.mocap.parameters import ClipReading, ClipSource

log = logging.getLogger(__name__)


def open_source(path: Path, source: ClipSource) -> Clips:
    """Open the clips at `path`. Raises what open_clips raises."""
    hints = as_dict(source)
    return open_clips(path, **hints | {"manifest": Path(source.manifest) if source.manifest else None})


def look(paths: Sequence[Path], source: ClipSource, groups: str | None, actors: Sequence[str]) -> None:
    """Open the clips at `paths`, find the groups, if any are wanted, and the people, without reading a motion. Raises
    what reading them raises there.
    """
    found = [open_source(path, source) for path in paths]
    if groups is not None:
        joint_groups.find(groups, found[0].skeleton)
    people = list(dict.fromkeys(actor for clips in found for actor in clips.actors))
    for name in actors:
        position(people, name, "actor")


def inputs(paths: Sequence[Path], groups: str) -> tuple[Path, ...]:
    """All files that a run reads: the clips, and the groups if they are a file."""
    return (*paths, *((Path(groups),) if Path(groups).is_file() else ()))


def read(
    paths: Sequence[Path], reading: ClipReading, groups: str | Groups, skeleton: Skeleton | None = None
) -> Motions:
    """Read the clips at `paths`; raises what `gather` and open_clips raise."""
    return gather([(path, open_source(path, reading.source)) for path in paths], reading.rate, groups, skeleton)


def gather(
    sources: Sequence[tuple[Path, Clips]], rate: float, groups: str | Groups, skeleton: Skeleton | None = None
) -> Motions:
    """Load all clips, one source after the other, at one rate; `groups` as io.motion.groups.find takes them, or found
    already.

    Joints are those of `skeleton` if given, else of the first clip, found by their names. Raises FormatError for
    clips that lack one of those that the groups need, and for two clips of one name; ParameterError for a body without
    height.
    """
    clips: list[Clip] = []
    splits: Mapping[str, np.ndarray] = {}
    skeleton = skeleton or sources[0][1].skeleton
    groups = joint_groups.find(groups, skeleton) if isinstance(groups, str) else groups
    needed = groups.needed(skeleton)
    for path, found in sources:
        clips += [_read_clip(path, found, name, rate, skeleton, needed) for name in found.names]
        splits = dict(found.splits) if len(sources) == 1 else {}
        tell(path, found.notes)
    if not clips:
        raise FormatError(sources[0][0], "no clips", fix="Check the folder")
    _check_names(sources[-1][0], clips)
    for clip in clips:
        _check_height(clip, groups)
    tell(sources[0][0], [*checks.notes(clips), *checks.doubts(clips, groups)])
    return Motions(tuple(clips), groups, splits)


def tell(path: Path, notes: Iterable[str]) -> None:
    """Say on the console what is odd about the clips at a path."""
    for note in notes:
        log.warning("%s: %s", path, note)


def _read_clip(path: Path, clips: Clips, name: str, rate: float, skeleton: Skeleton, needed: Sequence[str]) -> Clip:
    """One clip at a rate with the joints of a skeleton by their names; FormatError if it lacks one that is needed."""
    clip = clips.load(name)
    there = clip.motion.skeleton.joints
    if missing := [joint for joint in needed if joint not in there]:
        where = path if len(clips.names) == 1 else f"{path}: clip '{name}'"
        what = f"is of another skeleton: it has no joint '{missing[0]}'{nearest(missing[0], there)}"
        fix = "Rename its joints, or give --groups for joints that all clips have"
        raise FormatError(where, what, expected=f"{len(needed)} joints by name", got=f"{len(there)} joints", fix=fix)
    return resample_clip(replace(clip, motion=onto(clip.motion, skeleton)), rate)


def _check_names(path: Path, clips: Sequence[Clip]) -> None:
    known: dict[str, Clip] = {}
    for clip in clips:
        if known.setdefault(clip.name, clip) is not clip:
            raise FormatError(
                path, f"clip '{clip.name}' is there twice", fix="Give each source once, clips names of their own"
            )


def _check_height(clip: Clip, groups: Groups) -> None:
    try:
        height(clip.motion, groups)
    except ParameterError as error:
        raise ParameterError(f"clip '{clip.name}': {error}") from None
