"""What the mocap commands share: clips at paths, of one skeleton, brought to one rate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from ipcli.errors import FormatError, ParameterError
from ipcli.geometry.skeleton import Groups, Skeleton
from ipcli.io.motion import groups as joint_groups
from ipcli.io.motion.layouts import open_clips
from ipcli.measurements.motions import Clip, Clips, resample_clip
from ipcli.models.mocap.features import height
from ipcli.models.mocap.motions import Motions
from ipcli.params import as_dict
from ipcli.stages.mocap.parameters import ClipReading, ClipSource


def open_source(path: Path, source: ClipSource) -> Clips:
    """Open the clips at `path`. Raises what open_clips raises."""
    hints = as_dict(source)
    return open_clips(path, **hints | {"manifest": Path(source.manifest) if source.manifest else None})


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

    Raises FormatError for clips of another skeleton than the first's, or than `skeleton` if given, and for two clips of
    one name; ParameterError for a body without height.
    """
    clips: list[Clip] = []
    splits: Mapping[str, np.ndarray] = {}
    for path, found in sources:
        skeleton = skeleton or found.skeleton
        _check_skeleton(path, found.skeleton, skeleton)
        clips += [resample_clip(found.load(name), rate) for name in found.names]
        splits = dict(found.splits) if len(sources) == 1 else {}
    if not clips:
        raise FormatError(sources[0][0], "no clips", fix="Check the folder")
    _check_names(sources[-1][0], clips)
    groups = joint_groups.find(groups, clips[0].motion.skeleton) if isinstance(groups, str) else groups
    for clip in clips:
        _check_height(clip, groups)
    return Motions(tuple(clips), groups, splits)


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


def _check_skeleton(path: Path, found: Skeleton, expected: Skeleton) -> None:
    if (found.joints, found.parents) == (expected.joints, expected.parents):
        return
    other = next((name for name in expected.joints if name not in found.joints), None)
    what = f"has no joint '{other}'" if other else "has its joints in another order, or bones between others"
    expects, got = (f"{len(skeleton.joints)} joints" for skeleton in (expected, found))
    fix = "Learn and recognise with clips of one skeleton"
    raise FormatError(path, f"is of another skeleton: it {what}", expected=expects, got=got, fix=fix)
