"""What can be computed of a motion alone: another rate, bone lengths, height, heading, rotations from positions."""

from __future__ import annotations

import numpy as np

from ipcli.geometry.lie import minimal_rotation
from ipcli.geometry.skeleton import Groups, Skeleton


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


def bone_lengths(skeleton: Skeleton, positions: np.ndarray) -> np.ndarray:
    """Median length (j,) of the bone from the parent to each joint over the frames of positions (f, j, 3) that show
    both, in their unit; 0 of a root.
    """
    lengths = np.zeros(len(skeleton.joints))
    parents, joints = skeleton.bones().T
    found = np.linalg.norm(positions[:, joints] - positions[:, parents], axis=-1)
    found.sort(axis=0)  # what is not known comes last
    known = np.isfinite(found).sum(axis=0)
    bone = np.arange(len(joints))
    middle = (found[(known - 1) // 2, bone] + found[known // 2 % len(found), bone]) / 2
    lengths[joints] = np.where(known > 0, middle, np.nan)
    return lengths


def body_height(skeleton: Skeleton, positions: np.ndarray, groups: Groups) -> float:
    """Length of the chain of bones from the top joint to the bottom (head to foot), the mean over the
    bottoms.

    The same for all poses. NaN when a bone of the chains is never seen, 0 when top and bottom hang from different
    roots' ends.
    """
    lengths = bone_lengths(skeleton, positions)
    top = set(skeleton.path(int(skeleton.indices([groups.top], groups.source)[0])))
    chains = [set(skeleton.path(int(joint))) ^ top for joint in skeleton.indices(groups.bottom, groups.source)]
    return float(np.mean([lengths[sorted(chain)].sum() for chain in chains]))


def heading(skeleton: Skeleton, positions: np.ndarray, groups: Groups) -> np.ndarray:
    """world_from_body (f, 3, 3): z forward, y up, x to the left, from the joints on the left and the right (hips,
    shoulders).

    Forward is up x (right - left), made horizontal; pairs of which one side is not seen are left out. NaN where no pair
    is seen or the body lies on its side, so that left and right are one above the other.
    """
    left = positions[:, skeleton.indices(groups.left, groups.source)]
    right = positions[:, skeleton.indices(groups.right, groups.source)]
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
