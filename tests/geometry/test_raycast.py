"""Ray casting against closed forms, and the two camera paths."""

import numpy as np
import pytest

from ipcli.geometry import raycast
from ipcli.geometry.cameras import project, rays, transform
from ipcli.geometry.raycast import Caster, Mesh
from ipcli.measurements.views import View, check_view

CAMERA = np.array([[144.0, 0, 80], [0, 144.0, 60], [0, 0, 1]])
SHAPE = (120, 160)


def ball(subdivisions=5):
    import trimesh

    mesh = trimesh.creation.icosphere(subdivisions=subdivisions)
    return Mesh(np.asarray(mesh.vertices), np.asarray(mesh.faces))


def box(low, high):
    import trimesh

    mesh = trimesh.creation.box(bounds=[low, high])
    return Mesh(np.asarray(mesh.vertices), np.asarray(mesh.faces))


def test_the_depth_of_a_sphere_is_that_of_the_closed_form_from_every_place_of_the_orbit():
    caster, directions = Caster(ball()), rays(SHAPE, CAMERA)
    a, b = (directions**2).sum(-1), directions[..., 2] * raycast.DISTANCE
    inside = b * b - a * (raycast.DISTANCE**2 - 1)
    expected = np.where(inside > 0, (b - np.sqrt(np.maximum(inside, 0))) / a, np.nan)
    well_inside = inside > 0.1  # away from the limb, where the facets show
    for pose in raycast.orbit(3, 7.0):
        depth, image = caster.view(SHAPE, CAMERA, pose)
        np.testing.assert_allclose(depth[well_inside], expected[well_inside], atol=1e-3)
        assert np.isnan(depth[inside < 0]).all()
        assert (image[np.isnan(depth)] == raycast.BACKGROUND).all()
        assert image[60, 80, 0] == 225


def test_depth_is_measured_along_the_optical_axis():
    """A wall across it has one depth in every pixel."""
    depth, _ = Caster(box((-50, -50, -9), (50, 50, 0))).view(SHAPE, CAMERA, raycast.strip(1, 1.0)[0])
    seen = np.isfinite(depth)
    assert seen.sum() > 1000
    np.testing.assert_allclose(depth[seen], raycast.HEIGHT, rtol=1e-6)


@pytest.mark.parametrize("path", [raycast.orbit, raycast.strip])
@pytest.mark.parametrize("views", [1, 4, 11])
def test_poses_are_rigid_and_the_middle_one_is_the_same_for_any_number(path, views):
    poses = path(views, 2.0)
    for pose in poses:
        check_view(View("v", np.ones((2, 2), np.float32), CAMERA, pose))
    np.testing.assert_array_equal(poses[(views - 1) // 2], path(1, 1.0)[0])


def test_the_orbit_keeps_the_centre_at_the_principal_point_and_its_distance_and_turns_by_the_step():
    poses = raycast.orbit(5, 1.0)
    for pose in poses:
        np.testing.assert_allclose(project(transform(pose, np.zeros(3)), CAMERA), CAMERA[:2, 2])
        assert transform(pose, np.zeros(3))[2] == raycast.DISTANCE
        assert transform(pose, np.array([0.0, 1, 0]))[1] == -1  # up is up in the image
    between = poses[3, :3, :3] @ poses[2, :3, :3].T
    assert np.arccos((np.trace(between) - 1) / 2) == pytest.approx(np.radians(5))


def test_along_the_strip_the_ground_shifts_by_its_disparity():
    scene = raycast.on_ground(box((-400, -400, 3), (400, 400, 13)))
    tower = box((-10, -10, -5), (10, 10, 50))
    scene = Mesh(np.concatenate([scene.vertices, tower.vertices]), np.concatenate([scene.faces, tower.faces + 8]))
    step = 10 * 250.0 / 144  # 10 pixels at the top of the tower
    caster = Caster(scene)
    first, second = (caster.view(SHAPE, CAMERA, pose)[0] for pose in raycast.strip(2, step))
    top = np.isclose(first, 250, rtol=1e-5)
    assert top.sum() > 50
    np.testing.assert_array_equal(np.isclose(second, 250, rtol=1e-5), np.roll(top, -10, axis=1))


@pytest.mark.parametrize("up", ["x", "y", "z"])
def test_an_object_fills_the_unit_sphere_upright_and_is_not_mirrored(up):
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]]) + 7
    scaled = raycast.unit_sphere(Mesh(vertices, np.array([[0, 1, 2]])), up).vertices
    assert np.linalg.norm(scaled, axis=1).max() == pytest.approx(1)
    np.testing.assert_allclose(scaled.min(axis=0), -scaled.max(axis=0), atol=1e-12)
    edges = scaled[1:] - scaled[0]
    assert np.linalg.det(edges) > 0
    assert edges["xyz".index(up), 1] > 0


def test_a_scene_stands_on_the_ground():
    vertices = raycast.on_ground(box((85000.0, 446000, -3), (85010, 446020, 4))).vertices
    np.testing.assert_allclose([vertices.min(axis=0), vertices.max(axis=0)], [[-5, -10, 0], [5, 10, 7]])
