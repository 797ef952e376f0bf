"""Rendered views and the noise of a poor sensor, without files."""

import numpy as np
import pytest

from ipcli.geometry.cameras import back_project, transform
from ipcli.geometry.raycast import Mesh
from ipcli.models.fusion.synthetic import add_noise, camera_matrix, orbit, render, strip
from tests.fixtures.fusion_scenes import scene

CUBE = np.array([[x, y, z] for x in (-1.0, 1) for y in (-1.0, 1) for z in (-1.0, 1)])


@pytest.fixture(scope="module")
def cube():
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return Mesh(CUBE, np.array([corner for a, b, c, d in quads for corner in ((a, b, c), (a, c, d))]))


def test_a_rendered_depth_lies_on_the_surface_from_every_view(cube):
    path = orbit(cube, 3, 2.0, "y")
    found = list(render(path, (30, 40), 40.0))
    assert [view.name for view in found] == ["0", "1", "2"]
    side = np.abs(path.mesh.vertices).max()
    for view in found:
        world = transform(np.linalg.inv(view.cam_from_world), back_project(view.depth, view.intrinsics))
        known = np.isfinite(view.depth)
        assert known.mean() > 0.1
        np.testing.assert_allclose(np.abs(world[known]).max(axis=-1), side, atol=1e-5)
        np.testing.assert_array_equal(view.truth, view.depth)


def test_the_baselines_are_half_a_chord_of_the_orbit_and_the_step_of_the_strip(cube):
    path = orbit(cube, 2, 3.0, "z")
    centres = [np.linalg.inv(pose)[:3, 3] for pose in path.poses]
    assert path.baseline == pytest.approx(np.linalg.norm(centres[1] - centres[0]) / 2)
    path = strip(cube, 2, 0.7)
    centres = [np.linalg.inv(pose)[:3, 3] for pose in path.poses]
    assert path.baseline == pytest.approx(np.linalg.norm(centres[1] - centres[0]))


def test_the_camera_looks_through_the_middle_of_its_image():
    np.testing.assert_array_equal(camera_matrix((48, 64), 50.0), [[50, 0, 32], [0, 50, 24], [0, 0, 1]])


def test_noise_goes_to_the_depth_or_to_the_disparity_and_what_was_there_becomes_the_truth():
    view = scene(1, shape=(200, 200), noise=0.0, holes=0.0)[0]
    clean = add_noise(view, np.random.default_rng(0), ("gauss", 0.0))
    np.testing.assert_array_equal(clean.depth, view.depth)
    np.testing.assert_array_equal(clean.truth, view.truth)
    noisy = add_noise(view, np.random.default_rng(0), ("laplace", 0.01))
    assert np.abs(noisy.depth - view.depth).mean() == pytest.approx(0.01, rel=0.05)
    disparity = 40.0 / add_noise(view, np.random.default_rng(0), ("laplace", 0.1), 0.0, 40.0).depth
    assert np.abs(disparity - 40.0 / view.depth).mean() == pytest.approx(0.1, rel=0.05)
