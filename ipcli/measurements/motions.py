"""Motions of a skeleton, labelled clips of them, and sequences of clips that are read one by one (thesis 5.1, 5.3).

The conventions of positions and frames are those of `ipcli.geometry.skeleton`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from ipcli.errors import FormatError, ParameterError
from ipcli.geometry.skeleton import NO_PARENT, Groups, Skeleton

RIGID_TOLERANCE = 1e-3  # largest |R^T R - I| entry of a rotation given by a file
RATES = (1.0, 1000.0)  # Hz, of any motion
USUAL_RATES = (5.0, 500.0)  # Hz, of a motion that was misread
TRAIN, TEST = 1, 2  # entries of a published split; 0 is neither


@dataclass(frozen=True, eq=False)
class Motion:
    """Joint positions over time at a constant rate, with the joints' frames where the format has them."""

    skeleton: Skeleton
    positions: np.ndarray  # (f, j, 3) float64, metres, NaN = not seen
    rate: float  # frames a second
    rotations: np.ndarray | None = None  # (f, j, 3, 3) float64, world_from_bone
    notes: tuple[str, ...] = ()  # what a reader took for granted or left out


@dataclass(frozen=True, eq=False)
class Clip:
    """A motion with what is known of it; "" where nothing is."""

    name: str
    motion: Motion
    label: str = ""
    actor: str = ""
    frame_labels: np.ndarray | None = None  # (f,) str


@dataclass(frozen=True)
class Clips:
    """Clips of one skeleton in order, each read only when asked for. Labels and actors are known before."""

    names: tuple[str, ...]
    labels: tuple[str, ...]
    actors: tuple[str, ...]
    skeleton: Skeleton
    load: Callable[[str], Clip]
    files: Callable[[str], tuple[Path, ...]]  # what a clip is made of, for the provenance
    # published ones: name -> (clips,) of TRAIN, TEST or 0
    splits: Mapping[str, np.ndarray] = field(default_factory=dict)
    notes: tuple[str, ...] = ()  # what the reader took for granted or left out

    def __repr__(self) -> str:
        actions, people = sorted({*self.labels} - {""}), len({*self.actors} - {""})
        shown = ", ".join(actions[:6]) + (", ..." if len(actions) > 6 else "")
        return f"Clips({len(self.names)} of {people} people, {len(self.skeleton.joints)} joints; actions: {shown})"


def check_motion(motion: Motion, where: str | Path) -> Motion:
    """The motion if it is sound, else FormatError naming the place: shapes, finite or NaN, rotations that rotate, a
    rate.
    """
    skeleton, positions = motion.skeleton, motion.positions
    _check_skeleton(skeleton, where)
    if positions.ndim != 3 or positions.shape[1:] != (len(skeleton.joints), 3):
        expected, fix = (
            f"(frames, {len(skeleton.joints)}, 3)",
            "Give x, y, z of every joint in every frame, NaN where unknown",
        )
        raise FormatError(where, "positions have the wrong shape", expected=expected, got=positions.shape, fix=fix)
    if not len(positions):
        raise FormatError(where, "no frames", expected="at least one", fix="Leave out empty recordings")
    if np.isinf(positions).any():
        frame, joint, _ = np.argwhere(np.isinf(positions))[0]
        at = f"frame {frame}, joint '{skeleton.joints[joint]}'"
        raise FormatError(where, f"an infinite position at {at}", fix="Mark what is not known as NaN")
    if np.isnan(positions).all():
        raise FormatError(where, "no joint is known in any frame", fix="Check the columns, or leave the recording out")
    _check_rate(motion.rate, where)
    if motion.rotations is not None:
        _check_rotations(motion.rotations, motion, where)
    return motion


def _check_rate(rate: float, where: str | Path) -> None:
    if not (np.isfinite(rate) and rate > 0):
        raise FormatError(where, "no frame rate", expected="> 0 Hz", got=rate, fix="Give the rate with --source-rate")
    low, high = RATES
    if low <= rate <= high:
        return
    causes = [
        f"{cause}, give --source-rate {guess:.6g}"
        for guess, cause in (
            (1000 * rate, "If its times are in milliseconds"),
            (1 / rate, "If frames a second stand where the time of a frame has to"),
            (1e6 * rate, "If its times are in microseconds"),
        )
        if USUAL_RATES[0] <= guess <= USUAL_RATES[1]
    ]
    fix = ". ".join(causes) or "Give the rate with --source-rate"
    expected = f"{low:g} to {high:g} Hz"
    raise FormatError(where, f"{rate:.3g} frames a second", expected=expected, got=f"{1 / rate:.3g} s a frame", fix=fix)


def onto(motion: Motion, skeleton: Skeleton) -> Motion:
    """The motion with the joints of another skeleton, found by name: NaN where it has none of a name.

    A joint whose parent it has not hangs from nothing.
    """
    if motion.skeleton == skeleton:
        return motion
    there = {name: index for index, name in enumerate(motion.skeleton.joints)}
    found = np.array([there.get(name, -1) for name in skeleton.joints])
    positions = np.where((found >= 0)[:, None], motion.positions[:, found], np.nan)
    rotations = motion.rotations
    if rotations is not None:
        rotations = np.where((found >= 0)[:, None, None], rotations[:, found], np.nan)
    parents = tuple(p if p >= 0 and found[p] >= 0 else NO_PARENT for p in skeleton.parents)
    own = skeleton if parents == skeleton.parents else Skeleton(skeleton.joints, parents)
    return replace(motion, skeleton=own, positions=positions, rotations=rotations)


def _check_skeleton(skeleton: Skeleton, where: str | Path) -> None:
    if len(set(skeleton.joints)) < len(skeleton.joints):
        twice = next(name for name in skeleton.joints if skeleton.joints.count(name) > 1)
        raise FormatError(where, f"two joints are named '{twice}'", fix="Give each joint its own name")
    if len(skeleton.parents) != len(skeleton.joints) or not all(
        -1 <= p < len(skeleton.joints) for p in skeleton.parents
    ):
        expected = f"{len(skeleton.joints)} indices of joints, -1 for none"
        raise FormatError(
            where, "parents do not fit the joints", expected=expected, got=skeleton.parents, fix="Check the parents"
        )
    skeleton.from_root()


def _check_rotations(rotations: np.ndarray, motion: Motion, where: str | Path) -> None:
    expected = (*motion.positions.shape, 3)
    if rotations.shape != expected:
        raise FormatError(
            where, "rotations have the wrong shape", expected=expected, got=rotations.shape, fix="Give 3 x 3 matrices"
        )
    product = np.swapaxes(rotations, -1, -2) @ rotations
    with np.errstate(invalid="ignore"):
        bad = (np.abs(product - np.eye(3)).max(axis=(-2, -1)) > RIGID_TOLERANCE) | (np.linalg.det(rotations) < 0)
    if bad.any():
        frame, joint = np.argwhere(bad)[0]
        at = f"frame {frame}, joint '{motion.skeleton.joints[joint]}'"
        fix = "Check the order of the numbers, and that no scale or mirror image is in them"
        raise FormatError(where, f"a matrix that is no rotation at {at}", expected="R^T R = I, det R = 1", fix=fix)


def resample(motion: Motion, rate: float) -> Motion:
    """The motion at another rate, from its first frame on: times k / rate up to the last frame.

    Positions are interpolated linearly, rotations along the geodesic between neighbours. At a whole fraction of the
    rate frames are picked as they are, unfiltered. Between two frames of which one is not known nothing is known.
    Raises ParameterError.
    """
    before, share = _between(motion, rate)
    after = np.minimum(before + 1, len(motion.positions) - 1)
    positions = _blend(motion.positions, before, after, share)
    rotations = None if motion.rotations is None else _turn(motion.rotations, before, after, share)
    return replace(motion, positions=positions, rotations=rotations, rate=float(rate))


def resample_clip(clip: Clip, rate: float) -> Clip:
    """The clip at another rate; a frame takes the label of the nearest frame, of two equally near ones the earlier."""
    if rate == clip.motion.rate:
        return clip
    before, share = _between(clip.motion, rate)
    labels = clip.frame_labels
    return replace(
        clip,
        motion=resample(clip.motion, rate),
        frame_labels=None if labels is None else labels[before + (share > 0.5)],
    )


def _between(motion: Motion, rate: float) -> tuple[np.ndarray, np.ndarray]:
    """The frame at or before each new one, and how far on to the next it lies, in [0, 1)."""
    if not (np.isfinite(rate) and rate > 0):
        raise ParameterError(f"rate {rate} Hz: give a number above 0")
    step = motion.rate / rate
    count = int(np.floor((len(motion.positions) - 1) / step + 1e-9)) + 1
    times = np.arange(count) * step
    whole = np.round(times)
    times = np.where(np.abs(times - whole) < 1e-9 * np.maximum(whole, 1), whole, times)
    before = np.minimum(times.astype(np.int64), len(motion.positions) - 1)
    return before, np.clip(times - before, 0.0, 1.0)


def _blend(values: np.ndarray, before: np.ndarray, after: np.ndarray, share: np.ndarray) -> np.ndarray:
    share = share[:, None, None]
    mixed = (1 - share) * values[before] + share * values[after]
    return np.where(share == 0, values[before], mixed)


def _turn(rotations: np.ndarray, before: np.ndarray, after: np.ndarray, share: np.ndarray) -> np.ndarray:
    from ipcli.geometry.lie import exp, log

    turned = rotations[before].copy()
    moving = np.flatnonzero(share)
    first, second = rotations[before[moving]], rotations[after[moving]]
    turned[moving] = first @ exp(share[moving, None, None] * log(np.swapaxes(first, -1, -2) @ second))
    return turned


def mirrored(motion: Motion, groups: Groups) -> Motion:
    """What a mirror shows: left and right change places. Rotations stay rotations. Raises ParameterError as
    Groups.images does.
    """
    images = groups.images(motion.skeleton)
    flip = np.ones(3)
    flip[np.abs(groups.up).argmin()] = -1.0
    rotations = None if motion.rotations is None else motion.rotations[:, images] * np.multiply.outer(flip, flip)
    return replace(motion, positions=motion.positions[:, images] * flip, rotations=rotations)
