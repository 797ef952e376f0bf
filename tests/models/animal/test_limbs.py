"""The animal of our own: closed, whole, in two poses."""

import numpy as np
import pytest
import trimesh

from ipcli.models.animal.limbs import POSES, four_legged, round_cone


@pytest.mark.parametrize("pose", POSES)
def test_closed_and_with_all_parts(pose):
    vertices, faces, labels, tree = four_legged(pose, 0.05)
    body = trimesh.Trimesh(vertices, faces, process=False)
    assert body.is_watertight
    assert body.body_count == 1
    assert set(labels.tolist()) == set(range(1, len(tree) + 1))


def test_the_poses_differ_in_the_legs_alone():
    (standing, walking) = (four_legged(pose, 0.05) for pose in POSES)
    widths = [np.ptp(v[f[np.isin(lab, (5, 6))]].reshape(-1, 3)[:, 0]) for v, f, lab, _ in (standing, walking)]
    assert widths[1] > widths[0] + 0.3


def test_a_round_cone_is_a_capsule_when_its_ends_are_alike():
    points = np.array([[0.5, 2.0, 0], [3.0, 0, 0], [0.5, 0, 0]])
    assert round_cone(points, ((0, 0, 0), (1, 0, 0), 0.5, 0.5)) == pytest.approx([1.5, 1.5, -0.5])
