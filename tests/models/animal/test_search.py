"""The search for a camera by all labels: the overlap it maximises, and that it is greatest at the truth."""

import numpy as np
import pytest

from ipcli.geometry.orthographic import angle_between
from ipcli.models.animal import search
from ipcli.models.animal.cameras import Outlines
from ipcli.models.animal.frontiers import Frontiers
from tests.fixtures import limbs


@pytest.fixture(scope="module")
def scene():
    vertices, faces, labels = limbs.mesh(0.025)
    images, cameras = zip(*limbs.shots(("left", "front")), strict=True)
    return search.cloud_of(vertices, faces, labels - 1), images, cameras


def overlap(image, camera, cloud):
    cells = search.LabelCells.of(image, 40)
    return cells.overlaps(camera.rotation[None], np.array([camera.scale]), camera.shift[None], cloud)[0]


def test_the_true_camera_overlaps_almost_fully(scene):
    cloud, images, cameras = scene
    for image, camera in zip(images, cameras, strict=True):
        assert overlap(image, camera, cloud) > 0.75  # cells on a border may fall either way


def test_the_overlap_falls_with_every_turn(scene):
    cloud, images, cameras = scene
    turned = [overlap(images[1], cameras[1].turned(np.radians([0, degrees, 0])), cloud) for degrees in (0, 15, 40)]
    assert turned[0] > turned[1] > turned[2]


def test_the_mirrored_view_is_told_apart_by_its_labels(scene):
    cloud, images, cameras = scene
    known = Outlines.of([images[0].silhouette], cameras[:1]), Frontiers.of(images[:1], cameras[:1])
    match = search.Match.of(images[1], cloud, *known, 40)
    mirrored = np.diag([-1.0, 1.0, -1.0]) @ cameras[1].rotation  # from behind: the same outline, mirrored
    assert match.score(cameras[1].rotation) > match.score(mirrored) + 0.1


def test_many_rotations_of_one_direction_are_scored_as_each_alone(scene):
    cloud, images, cameras = scene
    known = Outlines.of([images[0].silhouette], cameras[:1]), Frontiers.of(images[:1], cameras[:1])
    match = search.Match.of(images[1], cloud.thinned(500), *known, 26)
    rolls = search._rotations()[150]
    np.testing.assert_allclose(match.scores(rolls), [match.score(rotation) for rotation in rolls], atol=1e-12)


def test_the_camera_of_a_true_model_is_found(scene):
    cloud, images, cameras = scene
    found, score = search.find_camera(images[1], cloud, images[:1], cameras[:1])
    assert angle_between(found.rotation, cameras[1].rotation) < 3
    assert found.scale == pytest.approx(cameras[1].scale, rel=0.02)
    assert score > 0.6
