"""The groups that come with ipcli fit the skeletons they are for; mistakes in one's own are named."""

from __future__ import annotations

import numpy as np
import pytest

from ipcli.errors import FormatError, ParameterError
from ipcli.geometry.skeleton import Skeleton
from ipcli.io.motion import groups, kinect

GOOD = """
root = "hips"
left = ["left_hip"]
right = ["right_hip"]
top = "head"
bottom = ["left_foot"]
[groups]
trunk = ["hips", "head"]
"""
SKELETON = Skeleton(("hips", "head", "left_hip", "right_hip", "left_foot"), (-1, 0, 0, 0, 2))


@pytest.fixture
def written(tmp_path):
    def write(text: str):
        (tmp_path / "own.toml").write_text(text)
        return tmp_path / "own.toml"

    return write


@pytest.mark.parametrize("name", groups.SHIPPED)
def test_shipped_groups_are_the_six_of_the_thesis(name):
    found = groups.read(groups.SHIPPED[name])
    assert list(found.parts) == ["head", "left_arm", "right_arm", "torso", "left_leg", "right_leg"]
    assert all(len(joints) >= 2 for joints in found.parts.values())
    for part, joints in found.parts.items():
        mirrored = found.parts[part.replace("left", "right")]
        assert len(joints) == len(mirrored)
        assert (joints == mirrored) == ("left" not in part and part == part.replace("left", "right"))


@pytest.mark.parametrize("skeleton", [kinect.KINECT, kinect.FLORENCE])
def test_in_a_mirror_the_left_of_a_shipped_skeleton_is_its_right(skeleton):
    found = groups.find("auto", skeleton)
    images, parts = found.images(skeleton), found.indices(skeleton)
    reached = {joint for joints in parts.values() for end in joints for joint in skeleton.path(int(end))}
    swap = {"left": "right", "right": "left"}
    expected = ["_".join(swap.get(word, word) for word in joint.split("_")) for joint in skeleton.joints]
    assert len(reached) > 14
    assert all(skeleton.joints[images[joint]] == expected[joint] for joint in reached)


@pytest.mark.parametrize(("skeleton", "name"), [(kinect.KINECT, "kinect"), (kinect.FLORENCE, "florence3d")])
def test_groups_are_found_by_the_joints(skeleton, name):
    assert groups.find("auto", skeleton) == groups.find(name, skeleton) == groups.read(groups.SHIPPED[name])


def test_a_file_of_ones_own_is_read(written):
    found = groups.find(str(written(GOOD)), SKELETON)
    np.testing.assert_array_equal(found.indices(SKELETON)["trunk"], [0, 1])
    assert found.up == (0.0, 1.0, 0.0)
    assert found.source == "own.toml"


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ('"head"]', '"heda"]', "group 'trunk': no joint 'heda' in the skeleton; did you mean 'head'"),
        ('root = "hips"', 'root = "hip"', "no joint 'hip' in the skeleton; did you mean 'hips'"),
    ],
)
def test_unknown_joints_name_the_nearest(written, before, after, message):
    with pytest.raises(ParameterError, match=f"own.toml.*{message}"):
        groups.find(str(written(GOOD.replace(before, after))), SKELETON)


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ('top = "head"', "", "'top' is missing"),
        ('top = "head"', 'tip = "head"', "'tip' is not a key of groups; did you mean 'top'"),
        ('left = ["left_hip"]', 'left = "left_hip"', "left is not a list of joints"),
        ('left = ["left_hip"]', 'left = ["left_hip", "head"]', "left and right are not pairs"),
        ('"hips", "head"', '"hips", "hips"', "groups.trunk names 'hips' twice"),
        ("[groups]", "[groups", "not valid TOML"),
        ("root", "up = [1, 1, 0]\nroot", "up is not an axis"),
        ('trunk = ["hips", "head"]', "", "no table .groups."),
        ('trunk = ["hips", "head"]', "trunk = []", "groups.trunk is not a list"),
        ('root = "hips"', "root = 3", "root is not a list of joints"),
    ],
)
def test_mistakes_are_named(written, before, after, message):
    with pytest.raises(FormatError, match=f"own.toml: {message}"):
        groups.read(written(GOOD.replace(before, after)))


def test_names_that_are_no_groups_and_skeletons_without(tmp_path):
    with pytest.raises(ParameterError, match="no groups 'kinnect'; did you mean 'kinect'"):
        groups.find("kinnect", kinect.KINECT)
    with pytest.raises(ParameterError, match="no groups of joints fit this skeleton .hips, head"):
        groups.find("auto", SKELETON)
