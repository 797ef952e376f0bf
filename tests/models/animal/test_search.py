"""The search for a camera by all labels: the overlap it maximises, and that it is greatest at the truth."""

import numpy as np
import pytest

from ipcli.geometry.orthographic import angle_between
from ipcli.models.animal import search
from ipcli.models.animal.cameras import outline_of
from tests.fixtures import limbs


@pytest.fixture(scope="module")
def scene():
    vertices, faces, labels = limbs.mesh(0.025)
    images, cameras = zip(*limbs.shots(("left", "front")), strict=True)
    return search.cloud_of(vertices, faces, labels - 1), images, cameras


def test_the_true_camera_overlaps_almost_fully(scene):
    cloud, images, cameras = scene
    for image, camera in zip(images, cameras, strict=True):
        assert search.LabelCells.of(image, 40).overlap(camera, cloud) > 0.75  # cells on a border may fall either way


def test_the_overlap_falls_with_every_turn(scene):
    cloud, images, cameras = scene
    cells = search.LabelCells.of(images[1], 40)
    turned = [cells.overlap(cameras[1].turned(np.radians([0, degrees, 0])), cloud) for degrees in (0, 15, 40)]
    assert turned[0] > turned[1] > turned[2]


def test_the_mirrored_view_is_told_apart_by_its_labels(scene):
    cloud, images, cameras = scene
    known = search.known_outlines(images[:1], cameras[:1])
    outline = outline_of(images[1].silhouette)
    mirrored = np.diag([-1.0, 1.0, -1.0]) @ cameras[1].rotation  # from behind: the same outline, mirrored
    cells = search.LabelCells.of(images[1], 40)
    scores = [search._score(rotation, outline, cloud, known, cells) for rotation in (cameras[1].rotation, mirrored)]
    assert scores[0] > scores[1] + 0.1


def test_the_camera_of_a_true_model_is_found(scene):
    cloud, images, cameras = scene
    found, overlap = search.find_camera(images[1], cloud, search.known_outlines(images[:1], cameras[:1]))
    assert angle_between(found.rotation, cameras[1].rotation) < 3
    assert found.scale == pytest.approx(cameras[1].scale, rel=0.02)
    assert overlap > 0.75
