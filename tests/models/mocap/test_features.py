"""Principal directions against closed forms, a Karcher mean and another library's words; what may not change a feature
does not.
"""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from ipcli.errors import ParameterError
from ipcli.geometry import lie
from ipcli.geometry.motion import heading
from ipcli.geometry.skeleton import NO_PARENT
from ipcli.models.mocap import features
from ipcli.models.mocap.parameters import MOTION, Features
from tests.fixtures.mocap_bodies import GROUPS, NAMES, OFFSETS, SKELETON, motion, poses

ALIGNED, TURNS, THESIS = Features(motion=0.0), Features(rotation_weight=0.1, motion=0.0), Features(kind="thesis")
MOVING = Features(motion=0.1)
ALL = pytest.mark.parametrize("settings", [ALIGNED, TURNS, THESIS], ids=["aligned", "turns", "thesis"])
EVERY = pytest.mark.parametrize(
    "settings", [ALIGNED, TURNS, THESIS, MOVING], ids=["aligned", "turns", "thesis", "moving"]
)
CARRIES_OVER = pytest.mark.parametrize("settings", [ALIGNED, TURNS, MOVING], ids=["aligned", "turns", "moving"])
LENGTHS = features.reference_lengths([motion(np.tile(np.eye(3), (1, len(NAMES), 1, 1)))], GROUPS)


def measure(moved, settings):
    return np.concatenate(list(features.of_motion(moved, GROUPS, LENGTHS, settings).values()), axis=1)


def turned(moved, rotation, shift=(0.0, 0.0, 0.0)):
    return replace(moved, positions=moved.positions @ rotation.T + shift, rotations=rotation @ moved.rotations)


@pytest.mark.filterwarnings("error")
def test_the_common_skeleton_has_a_bone_from_those_who_showed_it_and_none_that_nobody_did():
    """Bodies of height h, 2 h and 4 h have the bones of the first one; a joint that two of them hide counts once."""
    bodies = [replace(poses(4, 1), positions=size * poses(4, 1).positions) for size in (1.0, 2.0, 4.0)]
    expected = features.reference_lengths(bodies[:1], GROUPS)
    joint = NAMES.index("right_hand")
    for hidden, is_seen in ((1, True), (2, True), (3, False)):
        for body in bodies[:hidden]:
            body.positions[:, joint] = np.nan
        found = features.reference_lengths(bodies, GROUPS)
        assert np.isfinite(found[joint]) == is_seen
        others = np.arange(len(NAMES)) != joint
        np.testing.assert_allclose(found[others], expected[others], rtol=1e-6)
        np.testing.assert_allclose(found[joint], expected[joint] if is_seen else np.nan, rtol=1e-6)


@ALL
def test_seven_numbers_a_group_and_a_frame(settings):
    found = features.of_motion(poses(9, 1), GROUPS, LENGTHS, settings)
    assert list(found) == list(GROUPS.parts)
    assert {part.shape for part in found.values()} == {(9, 10 if settings is TURNS else 7)}
    assert all(np.isfinite(part).all() for part in found.values())


@EVERY
@given(turn=st.floats(-3, 3), x=st.floats(-9, 9), z=st.floats(-9, 9))
def test_where_one_stands_and_faces_makes_no_difference(settings, turn, x, z):
    moved = poses(6, 2)
    elsewhere = turned(moved, Rotation.from_euler("y", turn).as_matrix(), (x, 0.3, z))
    np.testing.assert_allclose(measure(elsewhere, settings), measure(moved, settings), atol=1e-8)


@CARRIES_OVER
@given(size=st.floats(0.3, 3))
def test_size_makes_no_difference(settings, size):
    moved = poses(6, 3)
    np.testing.assert_allclose(
        measure(replace(moved, positions=size * moved.positions), settings), measure(moved, settings), atol=1e-9
    )


def test_bone_lengths_make_no_difference_to_aligned_features_but_to_those_of_the_thesis():
    rng = np.random.default_rng(4)
    turns = (
        Rotation.from_rotvec(0.4 * rng.standard_normal((5 * len(NAMES), 3))).as_matrix().reshape(5, len(NAMES), 3, 3)
    )
    one, other = motion(turns), motion(turns, OFFSETS * rng.uniform(0.8, 1.2, (len(NAMES), 1)))
    assert np.abs(measure(one, ALIGNED) - measure(other, ALIGNED)).max() < 1e-9
    assert np.abs(measure(one, THESIS) - measure(other, THESIS)).max() > 1e-3


def test_a_straight_arm_raised_is_seen_by_aligned_features_and_not_by_those_of_the_thesis():
    turns = np.tile(np.eye(3), (2, len(NAMES), 1, 1))
    turns[1, NAMES.index("left_shoulder")] = Rotation.from_euler("z", 2.0).as_matrix()
    moved = motion(turns)
    arm = {
        settings.kind: features.of_motion(moved, GROUPS, LENGTHS, settings)["left_arm"]
        for settings in (ALIGNED, THESIS)
    }
    assert np.abs(arm["aligned"][0] - arm["aligned"][1]).max() > 0.1
    np.testing.assert_allclose(arm["thesis"][0], arm["thesis"][1], atol=1e-9)


@ALL
@given(order=st.permutations(range(7)))
def test_frames_do_not_know_of_each_other(settings, order):
    moved = poses(7, 5)
    shuffled = replace(moved, positions=moved.positions[order], rotations=moved.rotations[order])
    np.testing.assert_allclose(measure(shuffled, settings), measure(moved, settings)[list(order)], atol=1e-12)


@ALL
def test_a_joint_that_was_not_seen_takes_its_own_groups_alone(settings):
    moved = poses(4, 6)
    hidden, hand = moved.positions.copy(), NAMES.index("left_hand")
    hidden[2, hand] = np.nan
    found = features.of_motion(replace(moved, positions=hidden), GROUPS, LENGTHS, settings)
    whole = features.of_motion(moved, GROUPS, LENGTHS, settings)
    assert np.isnan(found["left_arm"][2]).all()
    found["left_arm"][2] = whole["left_arm"][2]
    for part in whole:
        np.testing.assert_allclose(found[part], whole[part], atol=1e-12)


def test_without_a_side_that_is_seen_nothing_is_known_of_a_frame():
    moved = poses(3, 7)
    hidden = moved.positions.copy()
    hidden[1, [NAMES.index("left_hip"), NAMES.index("right_shoulder")]] = np.nan
    found = features.of_motion(replace(moved, positions=hidden), GROUPS, LENGTHS, ALIGNED)
    assert all(np.isnan(part[1]).any() and np.isfinite(part[[0, 2]]).all() for part in found.values())


def test_positions_alone_are_enough():
    moved = poses(5, 8)
    bare = replace(moved, rotations=None)
    np.testing.assert_array_equal(measure(bare, ALIGNED), measure(moved, ALIGNED))
    assert np.isfinite(measure(bare, THESIS)[:, 7:]).all()


@given(st.integers(0, 2**31), st.integers(2, 5))
def test_no_more_variances_than_joints_less_one(seed, joints):
    rng = np.random.default_rng(seed)
    rotations = Rotation.from_rotvec(0.5 * rng.standard_normal((joints, 3))).as_matrix()
    places = rng.standard_normal((joints, 3))
    mean = lie.product_mean(rotations, places)
    variances, directions = features.principal_directions(lie.product_log(*mean, rotations, places))
    assert (np.diff(variances) <= 0).all()
    assert variances[joints - 1 :].max(initial=0.0) < 1e-13 * max(1.0, variances[0])
    np.testing.assert_allclose(directions @ directions.T, np.eye(6), atol=1e-12)


def test_the_most_distal_joint_is_on_the_positive_side():
    twists = np.random.default_rng(9).standard_normal((200, 4, 6))
    first = features.principal_directions(twists)[1][:, 0]
    assert (np.einsum("fk,fk->f", first, twists[:, -1]) >= 0).all()


def test_joints_on_one_geodesic_have_its_direction_and_variance():
    """Of a mean and joints at +-s along a unit twist the first direction is that twist, the variance the
    mean of s^2.
    """
    rotation, place = Rotation.from_rotvec([0.3, -0.5, 0.2]).as_matrix(), np.array([0.4, 1.0, -0.2])
    twist, steps = np.array([0.1, 0.5, -0.3, 0.6, 0.2, 0.4]), np.array([-0.7, 0.1, 0.6])
    twist /= np.linalg.norm(twist)
    rotations, places = lie.product_exp(rotation, place, steps[:, None] * twist)
    mean = lie.product_mean(rotations, places)
    np.testing.assert_allclose(mean[0], rotation, atol=1e-9)
    variances, directions = features.principal_directions(lie.product_log(*mean, rotations, places))
    assert variances[0] == pytest.approx(np.mean(steps**2), rel=1e-9)
    np.testing.assert_allclose(directions[0], twist, atol=1e-9)


def test_the_thesis_features_are_the_screw_of_the_first_direction_of_the_group():
    moved = poses(3, 10)
    found = features.of_motion(moved, GROUPS, LENGTHS, THESIS)["right_leg"]
    rows = SKELETON.indices(GROUPS.parts["right_leg"])
    for frame in range(3):
        rotations, places = moved.rotations[frame, rows], moved.positions[frame, rows] / features.height(moved, GROUPS)
        centre = lie.karcher_mean(rotations)
        twists = [
            np.r_[Rotation.from_matrix(centre.T @ r).as_rotvec(), centre.T @ (d - places.mean(axis=0))]
            for r, d in zip(rotations, places, strict=True)
        ]
        values, vectors = np.linalg.eigh(np.mean([np.outer(t, t) for t in twists], axis=0))
        first = vectors[:, -1] * np.sign(vectors[:, -1] @ twists[-1])
        assert found[frame, 6] == pytest.approx(np.linalg.norm(first[3:]), abs=1e-9)
        np.testing.assert_allclose(found[frame, :3], first[:3], atol=1e-9)  # exp and log cancel: |omega| <= 1 < pi
        again = Rotation.from_rotvec(first[:3])
        series = sum(np.linalg.matrix_power(_cross(first[:3]), k) / _factorial(k + 1) for k in range(25))
        np.testing.assert_allclose(found[frame, 3:6], series @ first[3:], atol=1e-9)
        assert np.isclose(np.linalg.det(again.as_matrix()), 1)


def test_the_mean_and_spread_of_aligned_features_are_those_of_the_posed_joints():
    moved = poses(4, 11)
    posed = features.repose(moved, GROUPS, LENGTHS)[:, SKELETON.indices(GROUPS.parts["trunk"])]
    found = features.of_motion(moved, GROUPS, LENGTHS, ALIGNED)["trunk"]
    np.testing.assert_allclose(found[:, :3], posed.mean(axis=1), atol=1e-12)
    for frame, joints in enumerate(posed):
        values = np.linalg.svd(joints - joints.mean(axis=0), compute_uv=False) / np.sqrt(len(joints))
        assert np.linalg.norm(found[frame, 3:6]) == pytest.approx(values[0], rel=1e-9)
        assert found[frame, 6] == pytest.approx(values[1], rel=1e-9)


def test_a_common_skeleton_has_its_bones_and_every_pose_its_directions():
    moved = poses(4, 12)
    posed = features.repose(moved, GROUPS, LENGTHS)
    for parent, joint in SKELETON.bones():
        bone, own = posed[:, joint] - posed[:, parent], moved.positions[:, joint] - moved.positions[:, parent]
        np.testing.assert_allclose(np.linalg.norm(bone, axis=1), LENGTHS[joint], rtol=1e-9)
        np.testing.assert_allclose(
            bone[:, 1] / LENGTHS[joint], own[:, 1] / np.linalg.norm(own, axis=1), atol=1e-9
        )  # up stays up


def change(moved, reach=0.1):
    return features.of_motion(moved, GROUPS, LENGTHS, Features(motion=reach))[MOTION]


def test_what_is_known_of_poses_does_not_depend_on_whether_motion_is_asked_for():
    moved = poses(6, 14)
    whole = features.of_motion(moved, GROUPS, LENGTHS, MOVING)
    for group, part in features.of_motion(moved, GROUPS, LENGTHS, ALIGNED).items():
        np.testing.assert_array_equal(whole.pop(group), part)
    assert list(whole) == [MOTION]


def test_a_body_that_glides_and_turns_evenly_changes_by_that_alone():
    """Half a height a second forward as it faces, and a turn of a radian a second; the pose stays."""
    still = poses(1, 15)
    time, tall = np.arange(41) / 100, features.height(still, GROUPS)
    turns = Rotation.from_euler("y", time[:, None]).as_matrix()
    forward = heading(still.skeleton, still.positions, GROUPS)[0, :, 2]
    glides = replace(
        still,
        positions=still.positions.repeat(41, axis=0) + 0.5 * tall * time[:, None, None] * forward,
        rotations=None,
        rate=100.0,
    )
    found = change(glides)
    np.testing.assert_allclose(
        found, np.broadcast_to([*np.zeros(len(GROUPS.parts) * 7), 0, 0, 0.5, 0], found.shape), atol=1e-9
    )
    spins = replace(glides, positions=np.einsum("fab,jb->fja", turns, still.positions[0] - still.positions[0, 0]))
    np.testing.assert_allclose(change(spins)[:, -4:], spun(41), atol=1e-9)


def spun(frames):
    """A turn of a radian a second, as seen 0.1 s before and after, or at an end from the frame itself."""
    before, after = np.minimum(np.arange(frames), 10) / 100, np.minimum(np.arange(frames)[::-1], 10) / 100
    return np.stack([*np.zeros((3, frames)), (np.sin(after) + np.sin(before)) / (after + before)], axis=1)


def test_backwards_all_changes_the_other_way():
    moved = poses(12, 16)
    back = replace(moved, positions=moved.positions[::-1], rotations=moved.rotations[::-1])
    np.testing.assert_allclose(change(back), -change(moved)[::-1], atol=1e-9)


def test_the_rate_of_the_recording_makes_no_difference_to_a_change_a_second():
    moved = replace(poses(21, 17), rate=60.0)
    every_other = replace(moved, positions=moved.positions[::2], rotations=moved.rotations[::2], rate=30.0)
    np.testing.assert_allclose(change(every_other), change(moved)[::2], atol=1e-9)


def test_of_a_single_frame_or_beside_an_unknown_one_no_change_is_known():
    moved = replace(poses(9, 18), rate=10.0)
    assert np.isnan(change(replace(moved, positions=moved.positions[:1], rotations=moved.rotations[:1]))).all()
    hidden = moved.positions.copy()
    hidden[4, NAMES.index("left_hand")] = np.nan
    known = np.isfinite(change(replace(moved, positions=hidden))).all(axis=1)
    np.testing.assert_array_equal(known, [True, True, True, False, True, False, True, True, True])


def test_joints_without_parents_are_said_to_be_the_cause():
    moved = poses(2, 13)
    alone = replace(moved.skeleton, parents=(NO_PARENT,) * len(moved.skeleton.joints))
    with pytest.raises(ParameterError, match="the joints have no parents.*add `parents`.*docs/motions.md"):
        features.height(replace(moved, skeleton=alone), GROUPS)


def test_a_body_without_height_is_refused():
    moved = poses(2, 13)
    with pytest.raises(ParameterError, match="no height"):
        features.of_motion(replace(moved, positions=np.zeros_like(moved.positions)), GROUPS, LENGTHS, ALIGNED)


def _cross(w):
    return np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])


def _factorial(k):
    return float(np.prod(np.arange(1, k + 1)))
