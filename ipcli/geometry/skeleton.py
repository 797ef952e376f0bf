"""Skeletons, their motions, labelled clips of motion, and groups of joints (thesis 5.1, 5.3).

Conventions, the same everywhere in ipcli: metres, seconds, y up, right-handed. `world_from_bone` (f, j, 3, 3) is the
frame that moves with a joint, as its format defines it: of an ASF bone it sits at the far end of the bone of that name,
of a BVH joint at the joint itself. What was not seen is NaN, and nothing is ever filled in.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ipcli.errors import FormatError, ParameterError, nearest

NO_PARENT = -1


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

    def needed(self, skeleton: Skeleton) -> tuple[str, ...]:
        """The joints that a motion has to have: those that are named, and what these hang from up to what all of them
        hang from. What hangs below, and what lies above, plays no part.
        """
        named = skeleton.indices([self.root, self.top, *self.left, *self.right, *self.bottom], self.source)
        paths = [skeleton.path(int(joint)) for joint in {*named, *np.concatenate([*self.indices(skeleton).values()])}]
        above = set.intersection(*map(set, paths)) if paths else set()
        common = {joint for joint in above if joint != next((j for j in paths[0] if j in above), None)}
        return tuple(skeleton.joints[joint] for joint in sorted({*sum(paths, ())} - common))

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
        found: dict[int, int] = {}
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
