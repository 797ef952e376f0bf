"""Clips of motion as an HDF5 artefact."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from ipcli.errors import FormatError
from ipcli.geometry.skeleton import Skeleton
from ipcli.io.files import h5
from ipcli.io.motion.quaternions import matrices, quaternions
from ipcli.measurements.motions import Clip, Clips, Motion, check_motion


def read_clips(path: Path) -> Clips:
    """The clips of a `clips` artefact."""
    return of_arrays(h5.read(path, "clips").arrays, path)


def of_arrays(arrays: Mapping[str, np.ndarray], where: Path | str = "clips") -> Clips:
    """The clips that the fields of a `clips` artefact hold. Raises FormatError when they contradict each other."""
    ends = np.cumsum(arrays["frames"])
    if len(ends) and ends[-1] != len(arrays["positions"]):
        fix = "Make the artefact again"
        raise FormatError(
            where, "the frames of the clips do not add up", expected=len(arrays["positions"]), got=ends[-1], fix=fix
        )
    skeleton = Skeleton(tuple(map(str, arrays["joints"])), tuple(map(int, arrays["parents"])))
    names, labels, actors = (tuple(map(str, arrays[field])) for field in ("clips", "labels", "actors"))

    def load(name: str) -> Clip:
        index = names.index(name)
        frames = slice(ends[index] - arrays["frames"][index], ends[index])
        rotations = matrices(arrays["rotations"][frames]) if "rotations" in arrays else None
        positions = arrays["positions"][frames].astype(np.float64)
        motion = check_motion(
            Motion(skeleton, positions, float(arrays["rates"][index]), rotations), f"{where}: clip '{name}'"
        )
        frame_labels = arrays["frame_labels"][frames] if "frame_labels" in arrays else None
        return Clip(name, motion, labels[index], actors[index], frame_labels)

    splits = dict(zip(map(str, arrays.get("split_names", ())), arrays.get("splits", ()), strict=False))
    return Clips(names, labels, actors, skeleton, load, lambda name: (Path(where),), splits)


def clips_arrays(
    clips: Iterable[Clip], splits: Mapping[str, np.ndarray], notes: Sequence[str] = ()
) -> dict[str, np.ndarray]:
    """The fields of a `clips` artefact that holds these clips. Rotations are kept if all of them have some; `notes` are
    what is odd about them.
    """
    clips = list(clips)
    motions = [clip.motion for clip in clips]
    skeleton = motions[0].skeleton
    arrays = {
        "clips": np.array([clip.name for clip in clips], np.str_),
        "labels": np.array([clip.label for clip in clips], np.str_),
        "actors": np.array([clip.actor for clip in clips], np.str_),
        "frames": np.array([len(motion.positions) for motion in motions], np.int64),
        "rates": np.array([motion.rate for motion in motions], np.float64),
        "joints": np.array(skeleton.joints, np.str_),
        "parents": np.array(skeleton.parents, np.int64),
        "positions": np.concatenate([motion.positions.astype(np.float32) for motion in motions]),
    }
    turned = [motion.rotations for motion in motions if motion.rotations is not None]
    if len(turned) == len(motions):
        arrays["rotations"] = np.concatenate([quaternions(rotations) for rotations in turned])
    if any(clip.frame_labels is not None for clip in clips):
        whole = (
            np.full(len(clip.motion.positions), clip.label) if clip.frame_labels is None else clip.frame_labels
            for clip in clips
        )
        arrays["frame_labels"] = np.concatenate(list(whole)).astype(np.str_)
    if notes:
        arrays["notes"] = np.array([note.replace("\0", " ") for note in notes], np.str_)
    if splits:
        arrays |= {"split_names": np.array(list(splits), np.str_), "splits": np.array(list(splits.values()), np.int8)}
    return arrays
