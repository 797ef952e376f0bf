"""What is odd about clips of motion, and the option that mends it: size of the bodies, and the axis they stand on."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from ipcli.geometry.motion import span
from ipcli.geometry.skeleton import NO_PARENT, Groups
from ipcli.measurements.motions import Clip, Motion

USUAL = (0.75, 3.0)  # metres a whole body spans; outside a wrong unit is more likely than such a body
UPRIGHT = 0.8  # mean cosine between the body, from feet to head, and the axis that it stands along
AXES = ("x", "y", "z", "-x", "-y", "-z")
HEADS, FEET = ("head",), ("foot", "ankle", "toe", "tibia", "feet")
MOST_SHOWN = 3


def doubts(clips: Sequence[Clip], groups: Groups | None = None) -> list[str]:
    """What is odd about the clips as a whole, one line each; none about sound ones."""
    return [*_size(clips, groups), *_axes(clips, groups)]


def notes(clips: Sequence[Clip]) -> list[str]:
    """What the readers noted about the clips, one line for each kind of note with the clips it is about."""
    names: dict[str, list[str]] = {}
    for clip in clips:
        for note in clip.motion.notes:
            names.setdefault(note, []).append(clip.name)
    return [f"{_some(found)}: {note}" for note, found in names.items()]


def _some(names: Sequence[str]) -> str:
    more = len(names) - MOST_SHOWN
    return ", ".join(names[:MOST_SHOWN]) + (f" and {more} more" if more > 0 else "")


def _body(motion: Motion, groups: Groups | None) -> np.ndarray:
    """Positions of the joints of the groups; if there are none, of all but one that only marks where the body is."""
    if groups is not None:
        return motion.positions[:, motion.skeleton.indices(groups.needed(motion.skeleton))]
    parents = np.array(motion.skeleton.parents)
    lone = [j for j in np.flatnonzero(parents == NO_PARENT) if (parents == j).sum() == 1]
    return np.delete(motion.positions, lone, axis=1) if len(parents) > len(lone) + 2 else motion.positions


def _size(clips: Sequence[Clip], groups: Groups | None) -> list[str]:
    sizes = [size for clip in clips if np.isfinite(size := span(_body(clip.motion, groups)))]
    size = float(np.median(sizes)) if sizes else 1.0
    if USUAL[0] <= size <= USUAL[1]:
        return []
    return [f"the bodies span {size:.2g} m. If that is not their size, give the unit of the files with --unit"]


def _axes(clips: Sequence[Clip], groups: Groups | None) -> list[str]:
    """Doubts about up axes: bodies mostly stand, so that their heads are above their feet."""
    standing = {clip.name: axis for clip in clips if (axis := standing_axis(clip.motion, groups))}
    count = Counter(standing.values())
    odd = {name: axis for name, axis in standing.items() if axis != "y"}
    if not odd:
        return []
    if len(count) == 1:
        axis = next(iter(count))
        return [f"the bodies stand along {axis}, from feet to head, not along y. If {axis} is up, give --up {axis}"]
    told: Mapping[str, int] = Counter(odd.values())
    axes = ", ".join(f"{many} along {axis}" for axis, many in told.items())
    what = f"{count['y']} bodies stand along y and {axes} ({_some(list(odd))}), from feet to head"
    return [f"{what}. If nobody lies there, the files have different up axes: read each kind with its own --up"]


def standing_axis(motion: Motion, groups: Groups | None = None) -> str | None:
    """The axis of the world along which a body stands, from its feet to its head ("y", "-z", ...).

    Heads and feet are those of the groups, or else told by the names of the joints. None where there are none, or where
    the body does not stretch along any axis.
    """
    joints = motion.skeleton.joints
    if groups is not None:
        heads, feet = {groups.top}, {*groups.bottom}
    else:
        heads, feet = (
            {name for name in joints if any(part in name.lower() for part in parts)} for parts in (HEADS, FEET)
        )
    above, below = (motion.positions[:, [name in chosen for name in joints]] for chosen in (heads, feet))
    if not above.shape[1] or not below.shape[1]:
        return None
    up = _mean(above) - _mean(below)
    with np.errstate(invalid="ignore", divide="ignore"):
        up = up / np.linalg.norm(up, axis=-1, keepdims=True)
    seen = up[np.isfinite(up).all(axis=-1)]
    if not len(seen):
        return None
    along = np.concatenate([seen.mean(axis=0), -seen.mean(axis=0)])
    return AXES[int(along.argmax())] if along.max() >= UPRIGHT else None


def _mean(positions: np.ndarray) -> np.ndarray:
    """Mean (f, 3) of the joints that are seen; NaN where none is."""
    seen = np.isfinite(positions).all(axis=-1)
    total = np.where(seen[..., None], positions, 0.0).sum(axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(total / seen.sum(axis=1)[:, None])
