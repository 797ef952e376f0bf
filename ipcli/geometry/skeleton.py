"""Skeletons, their motions, labelled clips of motion, and groups of joints (thesis 5.1, 5.3).

Conventions, the same everywhere in ipcli: metres, seconds, y up, right-handed. `world_from_bone` (f, j, 3, 3) is the
frame that moves with a joint, as its format defines it: of an ASF bone it sits at the far end of the bone of that name,
of a BVH joint at the joint itself. What was not seen is NaN, and nothing is ever filled in.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ipcli.errors import FormatError, ParameterError, nearest

NO_PARENT = -1
RIGID_TOLERANCE = 1e-3  # largest |R^T R - I| entry of a rotation given by a file
TRAIN, TEST = 1, 2  # entries of a published split; 0 is neither


@dataclass(frozen=True)
class Skeleton:
    """Joints by name, and the index of the parent of each (-1: none). Any order; several roots are allowed (loose
    markers).
    """

    joints: tuple[str, ...]
    parents: tuple[int, ...]

    def indices(self, names: Sequence[str], where: str | Path | None = None) -> np.ndarray:
        """Where these joints are, (n,) int; ParameterError naming the nearest joint to one that is not there."""
        place = "" if where is None else f"{where}: "
        for name in names:
            if name not in self.joints:
                raise ParameterError(f"{place}no joint '{name}' in the skeleton{nearest(name, self.joints)}")
        return np.array([self.joints.index(name) for name in names], np.int64)

    def from_root(self) -> tuple[int, ...]:
        """All joints, every parent before its children. Raises FormatError if a chain of parents bites its tail."""
        order: list[int] = []
        placed: set[int] = {NO_PARENT}
        while len(order) < len(self.joints):
            ready = [j for j, parent in enumerate(self.parents) if parent in placed and j not in placed]
            if not ready:
                lost = next(joint for j, joint in enumerate(self.joints) if j not in placed)
                fix = "Give each joint a parent among the others, or none"
                raise FormatError("skeleton", f"joint '{lost}' hangs from no root", fix=fix)
            order += ready
            placed.update(ready)
        return tuple(order)

    def bones(self) -> np.ndarray:
        """(b, 2) int: parent and child of each bone, in order of the children."""
        pairs = [(parent, child) for child, parent in enumerate(self.parents) if parent != NO_PARENT]
        return np.array(pairs, np.int64).reshape(-1, 2)

    def path(self, joint: int) -> tuple[int, ...]:
        """The joint, its parent, and so on to its root."""
        chain = [joint]
        while self.parents[chain[-1]] != NO_PARENT:
            chain.append(self.parents[chain[-1]])
        return tuple(chain)


@dataclass(frozen=True, eq=False)
class Motion:
    """Joint positions over time at a constant rate, with the joints' frames where the format has them."""

    skeleton: Skeleton
    positions: np.ndarray  # (f, j, 3) float64, metres, NaN = not seen
    rate: float  # frames a second
    rotations: np.ndarray | None = None  # (f, j, 3, 3) float64, world_from_bone


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
    splits: Mapping[str, np.ndarray] = field(
        default_factory=dict
    )  # published ones: name -> (clips,) of TRAIN, TEST or 0


@dataclass(frozen=True)
class Groups:
    """Parts of the body as lists of joints, from the trunk outwards, and the joints that say where the body is and how
    tall.
    """

    parts: Mapping[str, tuple[str, ...]]
    root: str
    left: tuple[str, ...]  # such as left hip and left shoulder; heading is up x (right - left)
    right: tuple[str, ...]
    top: str  # the height is the length of the chains from here to the root and from there to the bottom
    bottom: tuple[str, ...]
    up: tuple[float, float, float] = (0.0, 1.0, 0.0)
    source: str = "groups"

    def indices(self, skeleton: Skeleton) -> dict[str, np.ndarray]:
        """Joint indices of each part. ParameterError for a joint that the skeleton has not, naming the nearest one."""
        for names in ((self.root, self.top), self.left, self.right, self.bottom):
            skeleton.indices(names, self.source)
        return {part: skeleton.indices(names, f"{self.source}: group '{part}'") for part, names in self.parts.items()}

    def images(self, skeleton: Skeleton) -> np.ndarray:
        """Index (j,) of the joint that stands for each one in a mirror.

        Left and right are told by the lists of those names and by parts named left_X and right_X, joint by joint, and
        by what these hang from. All others, those that no part reaches included, stand for themselves. ParameterError
        where the skeleton is not alike on both sides.
        """
        parts = self.indices(skeleton)
        pairs = [*zip(skeleton.indices(self.left, self.source), skeleton.indices(self.right, self.source), strict=True)]
        for name in parts:
            if name.startswith("left_"):
                pairs += zip(parts[name], parts.get(name.replace("left_", "right_", 1), ()), strict=False)
        found = {}
        for left, right in pairs:
            chains = skeleton.path(int(left)), skeleton.path(int(right))
            both = list(zip(*chains, strict=False))
            if len({*map(len, chains)}) > 1 or any(
                found.setdefault(a, b) != b or found.setdefault(b, a) != a for a, b in both
            ):
                one, other = (skeleton.joints[joint] for joint in (left, right))
                raise ParameterError(
                    f"{self.source}: '{one}' and '{other}' are no mirror images. List the joints of left_X and right_X "
                    "alike"
                )
        return np.array([found.get(joint, joint) for joint in range(len(skeleton.joints))], np.int64)


def forward_kinematics(
    skeleton: Skeleton, rotations: np.ndarray, translations: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """World rotations (f, j, 3, 3) and positions (f, j, 3) from those of each joint in the frame of its parent.

    `rotations` (f, j, 3, 3) parent_from_joint; `translations` (f, j, 3), or (1, j, 3) if they do not change.
    """
    turned = np.empty(rotations.shape)
    moved = np.empty((*rotations.shape[:2], 3))
    for joint in skeleton.from_root():
        parent = skeleton.parents[joint]
        if parent == NO_PARENT:
            turned[:, joint], moved[:, joint] = rotations[:, joint], translations[:, joint]
        else:
            turned[:, joint] = turned[:, parent] @ rotations[:, joint]
            moved[:, joint] = moved[:, parent] + (turned[:, parent] @ translations[:, joint, :, None])[..., 0]
    return turned, moved


def check(motion: Motion, where: str | Path) -> Motion:
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
    if not (np.isfinite(motion.rate) and motion.rate > 0):
        raise FormatError(
            where, "no frame rate", expected="> 0 Hz", got=motion.rate, fix="Give the rate with --source-rate"
        )
    if motion.rotations is not None:
        _check_rotations(motion, where)
    return motion


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


def _check_rotations(motion: Motion, where: str | Path) -> None:
    rotations, expected = motion.rotations, (*motion.positions.shape, 3)
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
