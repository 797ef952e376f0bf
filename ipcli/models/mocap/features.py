"""What is measured of a group of joints in a frame: principal geodesic analysis over the joints of the group
(Algorithms 5.1, 5.2).

`thesis`: seven numbers from the first principal direction, in the group's own mean frame, on the actor's own skeleton.
`aligned` (the default): the group's mean position and its first principal direction, scaled by its standard deviation,
in a frame that has its origin at the root and faces where the body faces, on a common skeleton of height 1. Each frame
by itself: order plays no part. One further group, which can be left out, has how all of this changes about a frame;
with it a frame still stands for itself.

The printed features do not carry over to other people. The twist in the group's own mean frame does not see any motion
of the whole group (a straight arm raised is a straight arm lowered); the bones' lengths tell who it is; and seven
numbers that a unit vector of R^6 determines have a singular covariance. What each step repairs is measured in
docs/mocap-train.md.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ipcli.errors import ParameterError
from ipcli.geometry import lie
from ipcli.geometry.motion import body_height, bone_lengths, heading, rotations_from_positions
from ipcli.geometry.skeleton import NO_PARENT, Groups
from ipcli.measurements.motions import Motion
from ipcli.models.mocap.parameters import MOTION, Features


def of_motion(motion: Motion, groups: Groups, lengths: np.ndarray, settings: Features) -> dict[str, np.ndarray]:
    """Features (f, d) float64 of each group by name, in each frame; NaN where a joint that they need was not seen.

    `lengths` (j,) are the bones of the common skeleton, as `reference_lengths` gives them. Aligned ones come with the
    group MOTION unless `settings.motion` is 0. Raises ParameterError for a joint that the skeleton lacks, or a body
    without height.
    """
    parts = groups.indices(motion.skeleton)
    if settings.kind == "thesis":
        return _thesis(motion, groups, parts)
    found = _aligned(motion, groups, parts, lengths, settings.rotation_weight)
    if settings.motion > 0:
        found[MOTION] = _changes(motion, groups, np.concatenate(list(found.values()), axis=1), settings.motion)
    return found


def reference_lengths(motions: Sequence[Motion], groups: Groups) -> np.ndarray:
    """Bone lengths (j,) of a common skeleton of height 1: the median over the motions in which a bone is seen, each
    divided by the height of its body; NaN for a bone that is seen in none.
    """
    each = np.array(
        [bone_lengths(motion.skeleton, motion.positions) / height(motion, groups) for motion in motions]
    )  # (motions, j)
    lengths = np.full(each.shape[1], np.nan)
    is_seen = ~np.isnan(each).all(axis=0)
    lengths[is_seen] = np.nanmedian(each[:, is_seen], axis=0)
    return lengths


def height(motion: Motion, groups: Groups) -> float:
    """Height of the body in the unit of the positions. Raises ParameterError if it has none."""
    found = body_height(motion.skeleton, motion.positions, groups)
    if not found > 0:
        if len(motion.skeleton.parents) > 1 and all(parent == NO_PARENT for parent in motion.skeleton.parents):
            raise ParameterError(
                "the joints have no parents, so there are no bones and no height: add `parents` (the index of each "
                "joint's parent, -1 for the root) to the NPZ, or give the CSV its skeleton; see docs/motions.md"
            )
        raise ParameterError(
            f"the body has no height between '{groups.top}' and {', '.join(groups.bottom)}: their bones are never seen "
            "or of length 0. "
            f"Name other joints in {groups.source}"
        )
    return found


def repose(motion: Motion, groups: Groups, lengths: np.ndarray) -> np.ndarray:
    """Positions (f, j, 3) of the same pose on the common skeleton of height 1, from the root, x left, y up, z where the
    body faces.

    Each bone keeps its direction and takes the length of the reference. NaN from the first bone outwards whose
    direction is not known.
    """
    skeleton, positions = motion.skeleton, motion.positions
    away = 1 / height(motion, groups)
    posed = np.empty(positions.shape)
    for joint in skeleton.from_root():
        parent = skeleton.parents[joint]
        if parent == NO_PARENT:
            posed[:, joint] = positions[:, joint] * away
        else:
            posed[:, joint] = posed[:, parent] + lengths[joint] * _direction(
                positions[:, joint] - positions[:, parent], lengths[joint]
            )
    root = skeleton.indices([groups.root], groups.source)
    return (posed - posed[:, root]) @ heading(motion.skeleton, posed, groups)


def _direction(bone: np.ndarray, length: float) -> np.ndarray:
    """Unit vectors (f, 3); 0 where the reference bone has no length, for its direction does not matter then."""
    if length == 0:
        return np.zeros(bone.shape)
    size = np.linalg.norm(bone, axis=-1, keepdims=True)
    return np.divide(bone, size, out=np.full(bone.shape, np.nan), where=size > 0)


def principal_directions(twists: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Variances (..., k), largest first, and unit directions (..., k, k) as rows, of the twists (..., h, k) of h joints
    (Algorithm 5.1).

    Twists at the mean sum to zero, so at most h - 1 variances differ from 0. A direction's sign is open in the thesis;
    here the most distal joint, the last one, is on its positive side. Zero or equal variances leave directions open
    still. NaN where a twist has NaN.
    """
    known = np.isfinite(twists).all(axis=(-2, -1))
    filled = np.where(known[..., None, None], twists, 0.0)
    variances, vectors = np.linalg.eigh(np.swapaxes(filled, -1, -2) @ filled / twists.shape[-2])
    directions = np.swapaxes(vectors, -1, -2)[..., ::-1, :]
    side = np.sum(directions * filled[..., -1:, :], axis=-1, keepdims=True)
    directions = np.where(side < 0, -directions, directions)
    variances = np.where(known[..., None], np.maximum(variances[..., ::-1], 0.0), np.nan)
    return variances, np.where(known[..., None, None], directions, np.nan)


def _thesis(motion: Motion, groups: Groups, parts: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """(f, 7) of each group (Algorithm 5.2): rotation vector and translation of the screw exp e, norm of e's linear
    part.

    Of the rotation the thesis takes Euler angles; the rotation vector is the same three numbers without their jumps.
    Translations are in body heights: of radians and lengths the unit decides which of them e follows.
    """
    rotations = (
        motion.rotations
        if motion.rotations is not None
        else rotations_from_positions(motion.skeleton, motion.positions)
    )
    positions = motion.positions / height(motion, groups)
    return {part: _screw(rotations[:, joints], positions[:, joints]) for part, joints in parts.items()}


def _screw(rotations: np.ndarray, translations: np.ndarray) -> np.ndarray:
    mean = lie.product_mean(rotations, translations)
    twists = lie.product_log(mean[0][:, None], mean[1][:, None], rotations, translations)
    first = principal_directions(twists)[1][:, 0]
    turned, moved = lie.screw_exp(first)
    return np.concatenate([lie.log(turned), moved, np.linalg.norm(first[:, 3:], axis=-1, keepdims=True)], axis=-1)


def _aligned(
    motion: Motion, groups: Groups, parts: Mapping[str, np.ndarray], lengths: np.ndarray, weight: float
) -> dict[str, np.ndarray]:
    """(f, 7) of each group, or (f, 10) if rotations weigh: mean position, sqrt(lambda_1) e_1, sqrt(lambda_2)."""
    posed = repose(motion, groups, lengths)
    turned = None
    if weight > 0:
        rotations = (
            motion.rotations
            if motion.rotations is not None
            else rotations_from_positions(motion.skeleton, motion.positions)
        )
        turned = np.swapaxes(heading(motion.skeleton, motion.positions, groups), -1, -2)[:, None] @ rotations
    found = {}
    for part, joints in parts.items():
        mean = posed[:, joints].mean(axis=1)
        twists = posed[:, joints] - mean[:, None]
        if turned is not None:
            twists = np.concatenate([weight * _turns(turned[:, joints]), twists], axis=-1)
        variances, directions = principal_directions(twists)
        spreads = np.sqrt(variances)
        found[part] = np.concatenate([mean, spreads[:, :1] * directions[:, 0], spreads[:, 1:2]], axis=-1)
    return found


def _changes(motion: Motion, groups: Groups, features: np.ndarray, reach: float) -> np.ndarray:
    """Change (f, D + 4) a second, from `reach` seconds before a frame to as long after, or to an end of the motion.

    Of the features (f, D), of the root's place in heights and of where the body faces, both seen from the frame. NaN
    where one of the two is not known, or the motion is one frame.
    """
    frames = np.arange(len(features))
    step = max(round(reach * motion.rate), 1)
    before, after = np.maximum(frames - step, 0), np.minimum(frames + step, len(frames) - 1)
    frame = heading(motion.skeleton, motion.positions, groups)
    root = motion.positions[:, motion.skeleton.indices([groups.root], groups.source)[0]] / height(motion, groups)
    moved, ahead = (np.einsum("fji,fj->fi", frame, x[after] - x[before]) for x in (root, frame[:, :, 2]))
    change = np.concatenate([features[after] - features[before], moved, ahead[:, :1]], axis=1)
    return change * motion.rate / np.where(after > before, after - before, np.nan)[:, None]


def _turns(rotations: np.ndarray) -> np.ndarray:
    """Rotation vectors (f, h, 3) from the Karcher mean to each rotation, in the frame that the rotations are
    given in.
    """
    mean = lie.karcher_mean(rotations)[:, None]
    return (mean @ lie.log(np.swapaxes(mean, -1, -2) @ rotations)[..., None])[..., 0]
