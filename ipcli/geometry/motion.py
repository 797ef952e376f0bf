"""What can be computed of a motion alone: another rate, bone lengths, height, heading, rotations from positions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ipcli.errors import ParameterError
from ipcli.geometry.lie import minimal_rotation
from ipcli.geometry.skeleton import Clip, Groups, Motion, Skeleton


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


def rotations_from_positions(skeleton: Skeleton, positions: np.ndarray) -> np.ndarray:
    """world_from_bone (f, j, 3, 3) of positions (f, j, 3): the smallest rotations from the world's x axis onto the
    bones (thesis 5.1).

    The bone of a joint comes from its parent. A root has none: it is only translated. NaN where an end of the bone is
    not known, or where it has no length.
    """
    rotations = np.broadcast_to(np.eye(3), (*positions.shape, 3)).copy()
    bones = skeleton.bones()
    if len(bones):
        rotations[:, bones[:, 1]] = minimal_rotation(positions[:, bones[:, 1]] - positions[:, bones[:, 0]])
    return rotations


def bone_lengths(motion: Motion) -> np.ndarray:
    """Median length (j,) in metres of the bone from the parent to each joint over the frames that show both; 0 of a
    root.
    """
    lengths = np.zeros(len(motion.skeleton.joints))
    parents, joints = motion.skeleton.bones().T
    found = np.linalg.norm(motion.positions[:, joints] - motion.positions[:, parents], axis=-1)
    found.sort(axis=0)  # what is not known comes last
    known = np.isfinite(found).sum(axis=0)
    bone = np.arange(len(joints))
    middle = (found[(known - 1) // 2, bone] + found[known // 2 % len(found), bone]) / 2
    lengths[joints] = np.where(known > 0, middle, np.nan)
    return lengths


def body_height(motion: Motion, groups: Groups) -> float:
    """Length in metres of the chain of bones from the top joint to the bottom (head to foot), the mean over the
    bottoms.

    The same for all poses. NaN when a bone of the chains is never seen, 0 when top and bottom hang from different
    roots' ends.
    """
    lengths, skeleton = bone_lengths(motion), motion.skeleton
    top = set(skeleton.path(int(skeleton.indices([groups.top], groups.source)[0])))
    chains = [set(skeleton.path(int(joint))) ^ top for joint in skeleton.indices(groups.bottom, groups.source)]
    return float(np.mean([lengths[sorted(chain)].sum() for chain in chains]))


def heading(motion: Motion, groups: Groups) -> np.ndarray:
    """world_from_body (f, 3, 3): z forward, y up, x to the left, from the joints on the left and the right (hips,
    shoulders).

    Forward is up x (right - left), made horizontal; pairs of which one side is not seen are left out. NaN where no pair
    is seen or the body lies on its side, so that left and right are one above the other.
    """
    left = motion.positions[:, motion.skeleton.indices(groups.left, groups.source)]
    right = motion.positions[:, motion.skeleton.indices(groups.right, groups.source)]
    across = np.nan_to_num(left - right)
    across = np.where(np.isfinite(left - right).all(axis=-1, keepdims=True), across, 0.0).sum(axis=1)
    up = np.asarray(groups.up, np.float64)
    to_left = across - (across @ up)[:, None] * up
    length = np.linalg.norm(to_left, axis=-1, keepdims=True)
    with np.errstate(invalid="ignore", divide="ignore"):
        x = np.where(length > 0, to_left / length, np.nan)
    y = np.broadcast_to(up, x.shape)
    return np.stack([x, y, np.cross(x, y)], axis=-1)


def span(positions: np.ndarray) -> float:
    """Median over the frames of the largest extent of the body along a world axis, in the unit of the positions (f, j,
    3).
    """
    with np.errstate(invalid="ignore"):
        seen = positions[np.isfinite(positions).all(axis=-1).sum(axis=-1) > 1]
    return (
        float(np.median((np.nanmax(seen, axis=1) - np.nanmin(seen, axis=1)).max(axis=-1)))
        if len(seen)
        else float("nan")
    )
