"""Skeletons are drawn where their joints are."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import numpy as np
import pytest

from ipcli.report.kit.skeleton import bounds, pose_figure

PARENTS = np.array([-1, 0, 1, 0])
POSE = np.array([[0.0, 1.0, 0.0], [0.3, 1.4, 0.1], [0.5, 1.8, 0.6], [0.0, 0.0, 0.2]])  # root, shoulder, hand, foot
ARM = np.array([False, True, True, False])


def drawn(poses, picked=ARM, **options):
    return ElementTree.fromstring(pose_figure(poses, PARENTS, picked, "a < b", **options))


def bones(figure, name):
    """Ends (n, 2, 2) of all bones of a class, in pixels."""
    paths = "".join(node.get("d") for node in figure.iter("path") if node.get("class") == name)
    return np.array(re.findall(r"M([-\d.]+) ([-\d.]+)L([-\d.]+) ([-\d.]+)", paths), float).reshape(-1, 2, 2)


def test_both_views_show_lengths_to_one_scale_with_the_left_of_the_body_on_the_right_from_the_front():
    arm = bones(drawn([POSE]), "group")
    assert len(arm) == 4  # two bones in two views
    pixels = 150 / (1.8 * 1.12)
    front, side = arm[:2], arm[2:]
    np.testing.assert_allclose(front[1, 1] - front[1, 0], pixels * np.array([0.2, -0.4]), atol=0.11)
    np.testing.assert_allclose(side[1, 1] - side[1, 0], pixels * np.array([0.5, -0.4]), atol=0.11)
    assert side[:, :, 0].min() > front[:, :, 0].max()


def test_the_group_is_picked_out_and_further_poses_are_faint_and_of_the_group_alone():
    figure = drawn([POSE, POSE + 0.1, POSE - 0.1])
    assert len(bones(figure, "rest")) == 2
    assert len(bones(figure, "group")) == 4
    assert len(bones(figure, "group faint")) == 8
    assert not bones(figure, "rest faint").size
    assert len([node for node in figure.iter("circle")]) == 4


def test_all_is_inside_the_drawing():
    figure = drawn([POSE, POSE + 0.5])
    width, height = map(float, figure.find("svg").get("viewBox").split()[2:])
    ends = np.concatenate([bones(figure, name).reshape(-1, 2) for name in ("rest", "group", "group faint")])
    assert (ends >= 0).all()
    assert (ends <= [width, height]).all()


def test_unknown_joints_are_left_out_with_their_bones():
    torn = POSE.copy()
    torn[1] = np.nan
    figure = drawn([torn])
    assert not bones(figure, "group").size
    assert len(bones(figure, "rest")) == 2
    assert "nan" not in ElementTree.tostring(figure, "unicode")


@pytest.mark.parametrize("poses", [[], [np.full((4, 3), np.nan)], [np.zeros((4, 3))]])
def test_nothing_to_see_is_still_a_drawing(poses):
    text = ElementTree.tostring(drawn(poses), "unicode")
    assert "nan" not in text
    assert "inf" not in text


def test_a_box_gives_figures_side_by_side_one_scale():
    low, high = box = bounds([POSE, 2 * POSE])
    np.testing.assert_array_equal(low, [0, 0, 0])
    np.testing.assert_array_equal(high, [1, 3.6, 1.2])
    alone, both = bones(drawn([POSE], box=box), "group"), bones(drawn([2 * POSE], box=box), "group")
    np.testing.assert_allclose(2 * (alone[0, 1] - alone[0, 0]), both[0, 1] - both[0, 0], atol=0.3)
