"""Features: columns are what their names say, limits of F7, the task domain."""

import numpy as np
import pytest

from ipcli.models.saliency import features, surface
from ipcli.models.saliency.scene_parameters import Membranes, SurfaceFit
from tests.fixtures import search


def nodes(number=0):
    sub = search.sequence().load(number)
    pose = sub.cam_from_world
    plate = surface.fit(sub.cloud @ pose[:3, :3].T + pose[:3, 3], SurfaceFit(nodes=900))
    return features.of_nodes(sub, plate, search.CAMERA, np.array([0.0, 0.0, 1.0]), Membranes())


def column(found, name):
    return found.table[:, [c.name for c in features.COLUMNS].index(name)]


def test_places_are_in_the_world_and_told_from_where_the_search_began():
    found = nodes(3)
    assert found.points[:, 2] == pytest.approx(np.full(len(found.points), search.WALL), abs=0.15)
    assert found.table[:, :3] == pytest.approx(found.points - [0, 0, 1], abs=1e-5)
    assert column(found, "time") == pytest.approx(np.full(len(found.points), 0.8 * 3 + 0.25))


def test_colours_are_those_of_the_picture_at_the_node():
    found = nodes()
    on = np.linalg.norm(found.points - search.DISCS[0], axis=1) < 0.06
    assert column(found, "red")[on].mean() > 2 * column(found, "blue")[on].mean()
    off = np.linalg.norm(found.points[:, None] - search.DISCS, axis=2).min(axis=1) > 0.3
    assert column(found, "unlikeness in colour")[on].mean() > 3 * column(found, "unlikeness in colour")[off].mean()


def test_a_patch_fills_the_acute_angle_up_to_three_metres_and_shrinks_beyond():
    size = features.patch_size(np.array([1.0, 3.0, 6.0]), 100.0)
    assert size == pytest.approx(2 * 100 * np.tan(np.radians(7.5)) * np.array([1, 1, 0.5]))


def test_radius_and_sigma_of_membranes_keep_to_their_limits():
    found = nodes().membrane
    assert found.radius == pytest.approx(np.full(len(found.radius), 5.0))
    assert (found.sigma >= 0.2).all()
    assert (found.sigma <= 2.0).all()
    assert features.excited(found, np.linspace(0, 1, len(found.z))).sigma[[0, -1]] == pytest.approx([0.2, 2.0])


def test_curvature_of_a_picture_is_that_of_its_intensity_as_a_surface():
    """A paraboloid of revolution: the Gaussian curvature at its summit is its second derivative squared."""
    v, u = np.indices((61, 61)) - 30
    grey = 220 - 0.05 * (u**2 + v**2)
    image = np.clip(grey, 0, 255)[..., None].repeat(3, axis=2)
    bend = features.channels(np.rint(image).astype(np.uint8))[30, 30, 3]
    assert bend == pytest.approx(0.1 / 255 * features.RELIEF, rel=0.3)


def test_the_task_domain_holds_most_of_what_was_looked_at():
    looked = np.random.default_rng(0).uniform(-1, 1, (500, 3))
    domain = features.task_domain(looked, 0.1)
    assert features.inside(looked, domain).mean() > 0.9
    assert not features.inside(np.array([[0.0, 0.0, 2.0]]), domain).any()
    assert features.columns_of(("F5", "membrane")).tolist() == [6, 7, 8, 18]
