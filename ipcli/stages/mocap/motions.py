"""What the mocap commands share: clips of one skeleton brought to one rate, and what is measured of their frames."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from ipcli.errors import FormatError, ParameterError
from ipcli.params import option
from ipcli.stages.mocap.import_clips import Source, open_source

if TYPE_CHECKING:
    import numpy as np

    from ipcli.geometry.skeleton import Groups, Skeleton
    from ipcli.measurements.motions import Clip
    from ipcli.models.mocap.parameters import Features


@dataclass(frozen=True)
class Reading:
    """How clips are read."""

    rate: float = option(30.0, "rate to bring all clips to", flag="--rate", low=1.0, unit="Hz")
    source: Source = field(default_factory=Source)


@dataclass(frozen=True, eq=False)
class Motions:
    """Clips of one skeleton; their frames count on from clip to clip, n in all."""

    clips: tuple[Clip, ...]
    groups: Groups
    splits: dict[str, np.ndarray]  # published ones by name, (c,) of 1 train, 2 test, 0 neither

    @property
    def skeleton(self) -> Skeleton:
        """That of all clips."""
        return self.clips[0].motion.skeleton

    @property
    def lengths(self) -> np.ndarray:
        """Frames (c,) of each clip."""
        import numpy as np

        return np.array([len(clip.motion.positions) for clip in self.clips])

    @property
    def clip(self) -> np.ndarray:
        """Index (n,) of the clip of each frame."""
        import numpy as np

        return np.repeat(np.arange(len(self.clips)), self.lengths)

    @property
    def labels(self) -> np.ndarray:
        """Action (n,) of each frame: its own where it has one, or that of its clip; empty where unknown."""
        import numpy as np

        each = [
            np.full(len(c.motion.positions), c.label) if c.frame_labels is None else c.frame_labels for c in self.clips
        ]
        return np.concatenate(each).astype(np.str_)

    @property
    def actors(self) -> np.ndarray:
        """Who moves (c,) in each clip."""
        import numpy as np

        return np.array([clip.actor for clip in self.clips], np.str_)


def read(paths: Sequence[Path], reading: Reading, groups: str | Groups, skeleton: Skeleton | None = None) -> Motions:
    """The clips at `paths`, one source after the other; `groups` as io.groups.find takes them, or found already.

    Raises FormatError for clips of another skeleton than the first's, or than `skeleton` if given, for two clips of one
    name, and what io.clips.open_clips raises; ParameterError for a body without height.
    """
    from ipcli.io.motion.groups import find
    from ipcli.measurements.motions import resample_clip

    clips, splits = [], {}
    for path in paths:
        found = open_source(path, reading.source)
        skeleton = skeleton or found.skeleton
        _check_skeleton(path, found.skeleton, skeleton)
        clips += [resample_clip(found.load(name), reading.rate) for name in found.names]
        splits = dict(found.splits) if len(paths) == 1 else {}
    if not clips:
        raise FormatError(paths[0], "no clips", fix="Check the folder")
    known = {}
    for clip in clips:
        if known.setdefault(clip.name, clip) is not clip:
            raise FormatError(
                paths[-1], f"clip '{clip.name}' is there twice", fix="Give each source once, clips names of their own"
            )
    groups = find(groups, skeleton) if isinstance(groups, str) else groups
    for clip in clips:
        _check_height(clip, groups)
    return Motions(tuple(clips), groups, splits)


def of_people(motions: Motions, names: Sequence[str]) -> Motions:
    """The clips of these people, of all if none is named. Raises ParameterError for one of whom there is no clip."""
    from ipcli.measurements.names import position

    people = tuple(dict.fromkeys(map(str, motions.actors)))
    wanted = {people[position(people, name, "actor")] for name in names} or {*people}
    kept = [number for number, clip in enumerate(motions.clips) if clip.actor in wanted]
    splits = {name: entries[kept] for name, entries in motions.splits.items()}
    return replace(motions, clips=tuple(motions.clips[number] for number in kept), splits=splits)


def to_learn(motions: Motions, mirror: bool) -> Motions:
    """The clips, with `mirror` followed by the mirror image of each, which has its labels and actor. Splits are left
    behind.
    """
    from ipcli.measurements.motions import mirrored

    images = [replace(clip, motion=mirrored(clip.motion, motions.groups)) for clip in motions.clips] if mirror else []
    return replace(motions, clips=(*motions.clips, *images), splits={})


def _check_height(clip: Clip, groups: Groups) -> None:
    from ipcli.models.mocap.features import height

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


def features(motions: Motions, lengths: np.ndarray, settings: Features) -> dict[str, np.ndarray]:
    """Features (n, D) of each group in each frame, on a common skeleton of these bone lengths (j,)."""
    import numpy as np

    from ipcli.models.mocap.features import of_motion

    each = [of_motion(clip.motion, motions.groups, lengths, settings) for clip in motions.clips]
    return {group: np.concatenate([one[group] for one in each]) for group in each[0]}


def poses(motions: Motions, lengths: np.ndarray) -> np.ndarray:
    """Positions (n, j, 3) on the common skeleton of height 1, from the root, turned to face +z, y up."""
    import numpy as np

    from ipcli.models.mocap.features import repose

    return np.concatenate([repose(clip.motion, motions.groups, lengths) for clip in motions.clips])
