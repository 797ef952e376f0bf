"""Any source of motion as one Clips: a `clips` artefact, a folder or archive of motion files, a Kinect data set."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ipcli.errors import FormatError, ParameterError, nearest
from ipcli.geometry.skeleton import Clip, Clips, Motion, Skeleton, check
from ipcli.io import kinect, recordings
from ipcli.io.quaternions import matrices, quaternions


@dataclass(frozen=True)
class Layout:
    """A known source: how to tell it, how to open it, and what it looks like in words."""

    recognise: Callable[[Path], bool]
    open: Callable[..., Clips]
    looks_like: str


def open_clips(path: Path, format: str = "auto", **hints: Any) -> Clips:
    """The clips at `path`. `format` is a key of LAYOUTS or "auto"; hints that are None count as not given.

    Raises FormatError when no layout fits (listing what was looked for), ParameterError for an unknown format or a hint
    that the layout has no use for.
    """
    path = Path(path)
    if not path.exists():
        raise FormatError(path, "no such file or folder", fix="Check the path")
    layout = _layout(path, format)
    given = {key: value for key, value in hints.items() if value is not None}
    known = [name for name, item in inspect.signature(layout.open).parameters.items() if item.kind is item.KEYWORD_ONLY]
    if unknown := [key for key in given if key not in known]:
        takes = ", ".join(known) or "no hints"
        raise ParameterError(f"{path}: '{unknown[0]}' means nothing to {layout.looks_like}; that takes {takes}")
    return layout.open(path, **given)


def open_artefact(path: Path) -> Clips:
    """The clips of a `clips` artefact."""
    from ipcli.io import h5

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
        motion = check(Motion(skeleton, positions, float(arrays["rates"][index]), rotations), f"{where}: clip '{name}'")
        frame_labels = arrays["frame_labels"][frames] if "frame_labels" in arrays else None
        return Clip(name, motion, labels[index], actors[index], frame_labels)

    splits = dict(zip(map(str, arrays.get("split_names", ())), arrays.get("splits", ()), strict=False))
    return Clips(names, labels, actors, skeleton, load, lambda name: (Path(where),), splits)


def artefact(clips: Iterable[Clip], splits: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The fields of a `clips` artefact that holds these clips. Rotations are kept if all of them have some."""
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
    if all(motion.rotations is not None for motion in motions):
        arrays["rotations"] = np.concatenate([quaternions(motion.rotations) for motion in motions])
    if any(clip.frame_labels is not None for clip in clips):
        whole = (
            np.full(len(clip.motion.positions), clip.label) if clip.frame_labels is None else clip.frame_labels
            for clip in clips
        )
        arrays["frame_labels"] = np.concatenate(list(whole)).astype(np.str_)
    if splits:
        arrays |= {"split_names": np.array(list(splits), np.str_), "splits": np.array(list(splits.values()), np.int8)}
    return arrays


def _layout(path: Path, format: str) -> Layout:
    if format == "auto":
        for layout in LAYOUTS.values():
            if layout.recognise(path):
                return layout
        looked_for = "; ".join(f"{name}: {layout.looks_like}" for name, layout in LAYOUTS.items())
        raise FormatError(path, f"no known layout of clips. Looked for {looked_for}", fix="See docs/motions.md")
    if format not in LAYOUTS:
        raise ParameterError(f"unknown format '{format}'{nearest(format, LAYOUTS)} Known: auto, {', '.join(LAYOUTS)}")
    return LAYOUTS[format]


LAYOUTS = {  # in the order in which they are tried: the more particular first
    "clips": Layout(lambda path: path.suffix in (".h5", ".hdf5"), open_artefact, "an HDF5 clips artefact"),
    "florence3d": Layout(
        kinect.is_florence, kinect.open_florence, "a folder with skeletal_data.mat and action_names.mat"
    ),
    "utkinect": Layout(
        kinect.is_utkinect, kinect.open_utkinect, "a folder or archive with joints_s01_e01.txt and actionLabel.txt"
    ),
    "files": Layout(
        recordings.is_recordings,
        recordings.open_recordings,
        f"{', '.join(recordings.READERS)} files, alone or in a folder",
    ),
}
