"""A small skeleton, and motions of it made from joint angles, for the tests of action recognition."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from ipcli.geometry.skeleton import Groups, Motion, Skeleton, forward_kinematics

JOINTS = {  # name: (parent, offset from it in metres when the body stands; x left, y up, z forward)
    "hips": (None, (0, 0, 0)),
    "chest": ("hips", (0, 0.3, 0.02)),
    "neck": ("chest", (0, 0.2, 0)),
    "head": ("neck", (0, 0.2, 0.03)),
    **{
        f"{side}_{name}": (parent.format(side), (sign * x, y, z))
        for side, sign in (("left", 1), ("right", -1))
        for name, parent, (x, y, z) in (
            ("shoulder", "neck", (0.18, -0.05, 0)),
            ("elbow", "{}_shoulder", (0.05, -0.28, 0)),
            ("hand", "{}_elbow", (0, -0.26, 0.03)),
            ("hip", "hips", (0.1, -0.05, 0)),
            ("knee", "{}_hip", (0, -0.42, 0.02)),
            ("foot", "{}_knee", (0, -0.42, -0.02)),
        )
    },
}
NAMES = tuple(JOINTS)
SKELETON = Skeleton(NAMES, tuple(-1 if parent is None else NAMES.index(parent) for parent, _ in JOINTS.values()))
OFFSETS = np.array([offset for _, offset in JOINTS.values()], float)
GROUPS = Groups(
    parts={
        "trunk": ("hips", "chest", "neck", "head"),
        "left_arm": ("left_shoulder", "left_elbow", "left_hand"),
        "right_arm": ("right_shoulder", "right_elbow", "right_hand"),
        "left_leg": ("left_hip", "left_knee", "left_foot"),
        "right_leg": ("right_hip", "right_knee", "right_foot"),
    },
    root="hips",
    left=("left_hip", "left_shoulder"),
    right=("right_hip", "right_shoulder"),
    top="head",
    bottom=("left_foot", "right_foot"),
)
ACTIONS = {  # joint that swings, about x or z, and the angles in radians between which it does
    "wave": ("right_shoulder", 2, -2.6, -1.8),
    "kick": ("left_hip", 0, -1.2, 0.2),
    "bow": ("chest", 0, 0.2, 1.1),
}


def motion(rotations: np.ndarray, offsets: np.ndarray = OFFSETS, place: np.ndarray | None = None) -> Motion:
    """Of parent_from_joint (f, j, 3, 3), with bones `offsets` (j, 3), the hips at `place` (f, 3)."""
    translations = np.repeat(offsets[None], len(rotations), axis=0)
    translations[:, 0] += np.array([0, 0.9, 0]) if place is None else place
    turned, moved = forward_kinematics(SKELETON, rotations, translations)
    return Motion(SKELETON, moved, 30.0, turned)


def poses(frames: int, seed: int, spread: float = 0.4) -> Motion:
    """Poses at random: every joint turned by a rotation vector of N(0, spread^2)."""
    rng = np.random.default_rng(seed)
    turns = Rotation.from_rotvec(spread * rng.standard_normal((frames * len(NAMES), 3))).as_matrix()
    return motion(turns.reshape(frames, len(NAMES), 3, 3), place=rng.standard_normal((frames, 3)))


def acted(action: str, frames: int, seed: int) -> Motion:
    """One of ACTIONS by a person with bones and a bearing of their own, who stands anywhere and faces anywhere."""
    rng = np.random.default_rng(seed)
    joint, axis, low, high = ACTIONS[action]
    vectors = np.repeat(0.06 * rng.standard_normal((1, len(NAMES), 3)), frames, axis=0)
    vectors += 0.04 * rng.standard_normal(vectors.shape)
    vectors[:, NAMES.index(joint), axis] += rng.uniform(low, high, frames)
    turns = Rotation.from_rotvec(vectors.reshape(-1, 3)).as_matrix().reshape(frames, len(NAMES), 3, 3)
    turns[:, 0] = Rotation.from_euler("y", rng.uniform(-np.pi, np.pi)).as_matrix() @ turns[:, 0]
    bones = OFFSETS * rng.uniform(0.8, 1.2) * rng.uniform(0.93, 1.07, (len(NAMES), 1))
    return motion(turns, bones, rng.standard_normal(3))
