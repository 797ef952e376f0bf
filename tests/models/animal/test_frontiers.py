"""Ends of parts along the axis that two views share."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ipcli.geometry.orthographic import Orthographic, angle_between, looking
from ipcli.measurements.part_images import PartImage
from ipcli.models.animal.frontiers import HIDDEN, Frontiers, PartOutlines, adjusted
from tests.fixtures import limbs


@pytest.fixture(scope="module")
def scene():
    return tuple(zip(*limbs.shots(("left", "front", "askew"), rotations={"askew": looking(40.0, 15.0)}), strict=True))


def error(frontiers, image, camera):
    own = PartOutlines.of(image)
    return frontiers.error(own, camera.rotation[None], np.array([camera.scale]), camera.shift[None])[0]


def test_ends_are_those_of_each_part():
    labels = np.zeros((20, 30), np.int16)
    labels[2:12, 3:9], labels[12:18, 3:25] = 1, 2
    outlines = PartOutlines.of(PartImage("one", labels))
    low, high = outlines.ends(np.array([[1.0, 0.0], [0.0, 1.0]]))
    assert outlines.parts.tolist() == [0, 1, 2]  # 0: all of them
    assert low.tolist() == [[3, 3, 3], [2, 2, 12]]
    assert high.tolist() == [[24, 8, 24], [17, 11, 17]]


def test_true_cameras_agree_and_turned_ones_do_not(scene):
    images, cameras = scene
    frontiers = Frontiers.of(images[:2], cameras[:2])
    true = error(frontiers, images[2], cameras[2])
    turned = [error(frontiers, images[2], cameras[2].turned(np.radians([0, 0, angle]))) for angle in (3.0, 8.0)]
    assert true < turned[0] < turned[1] < HIDDEN


def test_a_camera_that_is_off_comes_back(scene):
    images, cameras = scene
    true = cameras[2]
    turn = Rotation.from_rotvec(np.radians([3.0, -4.0, 3.0])).as_matrix()
    off = Orthographic(turn @ true.rotation, 1.03 * true.scale, true.shift + 5.0)
    found = adjusted(images, [*cameras[:2], off], [False, False, True])
    assert found[0] is cameras[0]
    assert angle_between(found[2].rotation, true.rotation) < 1.0
    assert found[2].scale == pytest.approx(true.scale, rel=0.01)
    body = limbs.mesh(0.05)[0]
    assert np.abs(found[2].project(body) - true.project(body)).max() < 2.5  # pixels
