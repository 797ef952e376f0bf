"""Labelled clips as every method gets them: what each frame is described by, on the skeleton of the people
learnt from.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from benchmarks.mocap.lie_group import relative_bones
from ipcli.geometry.skeleton import NO_PARENT, Skeleton
from ipcli.measurements.motions import mirrored
from ipcli.models.mocap import features
from ipcli.models.mocap.motions import Motions
from ipcli.models.mocap.parameters import MOTION, Features
from ipcli.stages.mocap.parameters import ClipReading
from ipcli.stages.mocap.reading import read

RATE = 30.0  # Hz
CHANGE = 0.2  # s


@dataclass(frozen=True, eq=False)
class LabelledClips:
    """Clips of one skeleton, their labels and actors."""

    motions: Motions
    labels: np.ndarray  # (c,) str
    actors: np.ndarray  # (c,) str
    _known: dict[tuple[str, bytes], dict[bool, list[np.ndarray]]] = field(default_factory=dict)

    @property
    def lengths(self) -> np.ndarray:
        """Frames (c,) of each clip."""
        return self.motions.lengths

    @property
    def classes(self) -> np.ndarray:
        """The actions, in order."""
        return np.unique(self.labels)

    def those_of(self, rows: np.ndarray) -> np.ndarray:
        """The clips, ascending, of frames (n,) bool."""
        return np.unique(self.motions.clip[rows])

    def described(self, by: str, train: np.ndarray, mirror: bool = False) -> list[np.ndarray]:
        """Each clip, or with `mirror` its mirror image, (n, j, 3) by `positions` on the actor's own skeleton of height
        1, or by `reposed` ones on the common skeleton of the clips train (k,) int, from the root and facing one way;
        (n, 2 j, 3) by `positions+change` or `reposed+change`, their change over CHANGE behind them; (n, ...) by
        `lie-group`, where each bone lies as seen from each other, and the positions on the common skeleton; or by ours
        (n, w): the features of all groups of joints side by side, of `poses` alone or with their `motion`.
        """
        key = (by, b"" if by.startswith("positions") else train.tobytes())
        if key not in self._known:
            self._known.clear()
            self._known[key] = {}
        found = self._known[key]
        if mirror not in found:
            found[mirror] = self._describe(by, train, mirror)
        return found[mirror]

    def _describe(self, by: str, train: np.ndarray, mirror: bool) -> list[np.ndarray]:
        groups, clips = self.motions.groups, [clip.motion for clip in self.motions.clips]
        common = features.reference_lengths([clips[index] for index in train], groups)
        clips = [mirrored(clip, groups) for clip in clips] if mirror else clips
        if by in ("poses", "motion"):
            settings = Features() if by == "motion" else Features(motion=0.0)
            return [
                np.concatenate(list(features.of_motion(clip, groups, common, settings).values()), axis=1)
                for clip in clips
            ]
        joints = np.unique(np.concatenate(list(groups.indices(self.motions.skeleton).values())))
        own = [features.reference_lengths([clip], groups) if by.startswith("positions") else common for clip in clips]
        placed = [
            filled(features.repose(clip, groups, lengths)[:, joints]) for clip, lengths in zip(clips, own, strict=True)
        ]
        if by.endswith("+change"):
            return [with_change(positions) for positions in placed]
        if by == "lie-group":
            starts, ends = bones(self.motions.skeleton, joints)
            return [
                np.concatenate(
                    [relative_bones(p[:, starts], p[:, ends]), p.reshape(len(p), -1)], axis=1, dtype=np.float32
                )
                for p in placed
            ]
        return placed


def with_change(positions: np.ndarray) -> np.ndarray:
    """Positions (n, j, 3) and behind them their change over CHANGE, at the ends of a clip over what there is of it."""
    reach = round(CHANGE * RATE / 2)
    at = np.arange(len(positions))
    after, before = np.minimum(at + reach, len(at) - 1), np.maximum(at - reach, 0)
    return np.concatenate([positions, positions[after] - positions[before]], axis=1)


def bones(skeleton: Skeleton, joints: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """From which to which of some joints (j,) bones lead, as places in `joints`: to each from the nearest above it."""
    place, found = {int(joint): index for index, joint in enumerate(joints)}, []
    for joint, index in place.items():
        above = skeleton.parents[joint]
        while above != NO_PARENT and above not in place:
            above = skeleton.parents[above]
        if above != NO_PARENT:
            found.append((place[above], index))
    starts, ends = zip(*found, strict=True)
    return np.array(starts), np.array(ends)


def by_group(frames: np.ndarray) -> dict[str, np.ndarray]:
    """What `described` set side by side (n, w): (n, 7) of each group of joints, and (n, 7 g + 4) of their motion if
    that is there.
    """
    groups = frames.shape[1] // 14 if frames.shape[1] % 7 else frames.shape[1] // 7
    found = {f"group {index}": frames[:, 7 * index : 7 * index + 7] for index in range(groups)}
    return found | ({MOTION: frames[:, 7 * groups :]} if frames.shape[1] > 7 * groups else {})


def loose(frames: np.ndarray, by: str) -> np.ndarray:
    """The same frames when nothing is known of what came before them and after: what tells of it is NaN."""
    found = frames.copy()
    if by.endswith("+change"):
        found[:, frames.shape[1] // 2 :] = np.nan
    if by == "motion":
        found[:, 7 * (frames.shape[1] // 14) :] = np.nan
    return found


def filled(positions: np.ndarray) -> np.ndarray:
    """Positions (n, j, 3) in which joints that were not seen are where they were last, or next, in the clip; at the
    root if never.

    Ours leaves out what was not seen; the peers cannot.
    """
    found, at = positions.copy(), np.arange(len(positions))
    for joint in range(positions.shape[1]):
        seen = np.flatnonzero(np.isfinite(positions[:, joint]).all(axis=1))
        nearest = seen[np.clip(np.searchsorted(seen, at, side="right") - 1, 0, len(seen) - 1)] if len(seen) else at
        found[:, joint] = positions[nearest, joint] if len(seen) else 0.0
    return found


def open_problem(path: Path) -> LabelledClips:
    """The clips of an artefact."""
    motions = read([path], ClipReading(rate=RATE), "auto")
    return LabelledClips(motions, np.array([clip.label for clip in motions.clips], np.str_), motions.actors)
