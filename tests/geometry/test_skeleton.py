"""Skeletons by brute force and by another library's graphs, kinematics by the product of the chain."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh.transformations
from hypothesis import given
from hypothesis import strategies as st

from ipcli.errors import FormatError, ParameterError
from ipcli.geometry import lie
from ipcli.geometry.skeleton import NO_PARENT, Skeleton, forward_kinematics
from tests.fixtures.five_joints import GROUPS, SKELETON


@st.composite
def skeletons(draw):
    """Joints that hang from roots, one or several, in any order."""
    count = draw(st.integers(1, 8))
    parents = [draw(st.integers(-1, joint - 1)) for joint in range(count)]
    order = draw(st.permutations(range(count)))  # the new place of each
    mixed = [NO_PARENT] * count
    for joint, parent in enumerate(parents):
        mixed[order[joint]] = NO_PARENT if parent < 0 else order[parent]
    return Skeleton(tuple(f"j{n}" for n in range(count)), tuple(mixed))


@given(skeletons())
def test_every_parent_comes_before_its_children_and_every_joint_once(skeleton):
    order = skeleton.from_root()
    assert sorted(order) == list(range(len(skeleton.joints)))
    assert all(parent < 0 or order.index(parent) < order.index(joint) for joint, parent in enumerate(skeleton.parents))


@given(skeletons())
def test_paths_and_bones_are_the_parents_one_by_one(skeleton):
    for joint, parent in enumerate(skeleton.parents):
        assert skeleton.path(joint) == (joint, *(() if parent < 0 else skeleton.path(parent)))
    pairs = [(parent, joint) for joint, parent in enumerate(skeleton.parents) if parent >= 0]
    assert skeleton.bones().tolist() == [list(pair) for pair in pairs]
    assert skeleton.bones().shape == (len(pairs), 2)


@given(skeletons(), st.integers(0, 2**32 - 1))
def test_kinematics_are_the_products_of_homogeneous_matrices_along_the_path(skeleton, seed):
    rng, count = np.random.default_rng(seed), len(skeleton.joints)
    turns, moves = lie.exp(rng.normal(size=(3, count, 3))), rng.normal(size=(3, count, 3))
    rotations, positions = forward_kinematics(skeleton, turns, moves)
    for frame in range(3):
        for joint in range(count):
            whole = trimesh.transformations.concatenate_matrices(
                np.eye(4),
                *(
                    np.vstack([np.c_[turns[frame, j], moves[frame, j]], [0, 0, 0, 1]])
                    for j in reversed(skeleton.path(joint))
                ),
            )
            np.testing.assert_allclose(rotations[frame, joint], whole[:3, :3], atol=1e-12)
            np.testing.assert_allclose(positions[frame, joint], whole[:3, 3], atol=1e-12)


@given(skeletons(), st.data())
def test_a_chain_that_bites_its_tail_hangs_from_no_root(skeleton, data):
    joint = data.draw(st.integers(0, len(skeleton.joints) - 1))
    below = [other for other in range(len(skeleton.joints)) if joint in skeleton.path(other)]
    parents = list(skeleton.parents)
    parents[joint] = data.draw(st.sampled_from(below))
    with pytest.raises(FormatError, match="hangs from no root") as raised:
        replace(skeleton, parents=tuple(parents)).from_root()
    assert f"joint '{skeleton.joints[min(below)]}'" in str(raised.value)


def test_joints_are_found_by_name_and_a_slip_is_answered_by_the_nearest():
    np.testing.assert_array_equal(SKELETON.indices(["foot", "head", "foot"]), [4, 0, 4])
    assert SKELETON.indices([]).dtype == np.int64
    with pytest.raises(ParameterError, match=r"^own\.toml: no joint 'haed' in the skeleton; did you mean 'head'\?"):
        SKELETON.indices(["foot", "haed"], "own.toml")


def test_joints_of_groups_are_found_and_what_is_missing_says_in_which():
    found = replace(GROUPS, parts={"legs": ("foot", "left")}).indices(SKELETON)
    np.testing.assert_array_equal(found["legs"], [4, 2])
    with pytest.raises(ParameterError, match="own: group 'legs': no joint 'fot' in the skeleton; did you mean 'foot'"):
        replace(GROUPS, parts={"legs": ("fot",)}, source="own").indices(SKELETON)
    for field in ("left", "right", "bottom"):
        with pytest.raises(ParameterError, match="no joint 'tail'"):
            replace(GROUPS, **{field: ("tail",)}).indices(SKELETON)


def test_forward_kinematics_of_joints_in_any_order_is_the_product_of_the_chain():
    rng = np.random.default_rng(4)
    turns, moves = lie.exp(rng.normal(size=(6, 5, 3))), rng.normal(size=(1, 5, 3))
    rotations, positions = forward_kinematics(SKELETON, turns, moves)
    foot = moves[0, 1] + turns[:, 1] @ moves[0, 2] + turns[:, 1] @ turns[:, 2] @ moves[0, 4]
    np.testing.assert_allclose(positions[:, 4], foot, atol=1e-13)
    np.testing.assert_allclose(rotations[:, 4], turns[:, 1] @ turns[:, 2] @ turns[:, 4], atol=1e-13)


def test_a_body_that_is_not_alike_on_both_sides_has_no_mirror_image():
    lame = Skeleton(("head", "root", "left", "right", "foot", "knee"), (1, -1, 5, 1, 2, 1))
    with pytest.raises(ParameterError, match="'left' and 'right' are no mirror images"):
        replace(GROUPS, parts={"all": ("root",)}).images(lame)
    with pytest.raises(ParameterError, match="'left' and 'head' are no mirror images"):
        replace(GROUPS, parts={"left_side": ("left",), "right_side": ("head",)}).images(SKELETON)
