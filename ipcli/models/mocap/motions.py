"""Clips of one skeleton at one rate, whose frames count on from clip to clip: what models learn from and recognise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ipcli.errors import ParameterError
from ipcli.geometry.skeleton import Groups, Skeleton
from ipcli.measurements.motions import Clip, mirrored
from ipcli.measurements.names import position
from ipcli.models.mocap import features
from ipcli.models.mocap.parameters import Features

NONE = "none"  # the answer for what is none of the actions


@dataclass(frozen=True, eq=False)
class Motions:
    """Clips of one skeleton with its groups of joints; c clips of n frames in all."""

    clips: tuple[Clip, ...]
    groups: Groups
    splits: Mapping[str, np.ndarray] = field(default_factory=dict)  # published: (c,) of 1 train, 2 test, 0 neither

    @property
    def skeleton(self) -> Skeleton:
        """The skeleton of all clips."""
        return self.clips[0].motion.skeleton

    @property
    def lengths(self) -> np.ndarray:
        """Frames (c,) of each clip."""
        return np.array([len(clip.motion.positions) for clip in self.clips])

    @property
    def rates(self) -> np.ndarray:
        """Frames a second (c,) of each clip."""
        return np.array([clip.motion.rate for clip in self.clips])

    @property
    def clip(self) -> np.ndarray:
        """Index (n,) of the clip of each frame."""
        return np.repeat(np.arange(len(self.clips)), self.lengths)

    @property
    def labels(self) -> np.ndarray:
        """Action (n,) of each frame: its own where it has one, or that of its clip; empty where unknown."""
        each = [
            np.full(len(c.motion.positions), c.label) if c.frame_labels is None else c.frame_labels for c in self.clips
        ]
        return np.concatenate(each).astype(np.str_)

    @property
    def actors(self) -> np.ndarray:
        """Who moves (c,) in each clip."""
        return np.array([clip.actor for clip in self.clips], np.str_)

    def features(self, lengths: np.ndarray, settings: Features) -> dict[str, np.ndarray]:
        """Features (n, D) of each group in each frame, on a common skeleton of these bone lengths (j,)."""
        each = [features.of_motion(clip.motion, self.groups, lengths, settings) for clip in self.clips]
        return {group: np.concatenate([one[group] for one in each]) for group in each[0]}

    def poses(self, lengths: np.ndarray) -> np.ndarray:
        """Positions (n, j, 3) on the common skeleton of height 1, from the root, turned to face +z, y up."""
        return np.concatenate([features.repose(clip.motion, self.groups, lengths) for clip in self.clips])

    def reference_lengths(self, chosen: Sequence[int] | np.ndarray | None = None) -> np.ndarray:
        """Bone lengths (j,) of the common skeleton of the clips, or of the chosen ones."""
        clips = self.clips if chosen is None else [self.clips[index] for index in chosen]
        return features.reference_lengths([clip.motion for clip in clips], self.groups)


def number_actions(labels: np.ndarray) -> tuple[tuple[str, ...], np.ndarray]:
    """The actions in order of their names, and the number (n,) of each label; -1 for none."""
    names = tuple(sorted({*map(str, labels)} - {""}))
    return names, np.where(labels == "", -1, np.searchsorted(names, labels)) if names else np.full(len(labels), -1)


def of_people(motions: Motions, names: Sequence[str]) -> Motions:
    """The clips of these people, of all if none is named. Raises ParameterError for one of whom there is no clip."""
    people = tuple(dict.fromkeys(map(str, motions.actors)))
    wanted = {people[position(people, name, "actor")] for name in names} or {*people}
    kept = [number for number, clip in enumerate(motions.clips) if clip.actor in wanted]
    splits = {name: entries[kept] for name, entries in motions.splits.items()}
    return replace(motions, clips=tuple(motions.clips[number] for number in kept), splits=splits)


def select(motions: Motions, actors: Sequence[str], actions: Sequence[str]) -> Motions:
    """The clips of these people, with the labels of these actions alone; none named: all.

    Raises ParameterError for a name that is not there, or if no label is left to learn.
    """
    motions = of_people(motions, actors)
    labels = tuple(sorted({*map(str, motions.labels)} - {""}))
    wanted = {labels[position(labels, name, "action")] for name in actions} or {*labels}
    if NONE in wanted:
        raise ParameterError(
            f"an action is named '{NONE}', which is the answer for whatever was never learnt. Rename it, or leave it "
            "out (name the others with --actions)"
        )
    if not wanted:
        raise ParameterError(
            "none of the clips has a label to learn. Name them by a manifest (ipcli import-clips --manifest) or by "
            "folders"
        )
    return replace(motions, clips=tuple(_with_labels(clip, wanted) for clip in motions.clips))


def _with_labels(clip: Clip, actions: set[str]) -> Clip:
    """The clip with the labels of these actions alone."""
    frame_labels = clip.frame_labels
    if frame_labels is not None:
        frame_labels = np.where(np.isin(frame_labels, list(actions)), frame_labels, "")
    return replace(clip, label=clip.label if clip.label in actions else "", frame_labels=frame_labels)


def with_mirror_images(motions: Motions) -> Motions:
    """The clips, followed by the mirror image of each, which has its labels and actor. Splits are left behind."""
    images = [replace(clip, motion=mirrored(clip.motion, motions.groups)) for clip in motions.clips]
    return replace(motions, clips=(*motions.clips, *images), splits={})
