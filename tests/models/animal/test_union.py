"""The thesis' union of aspects: fields of known bodies, where an aspect lies, and that nothing is clipped."""

import numpy as np
import pytest
import trimesh

from ipcli.geometry import meshes
from ipcli.geometry.voxels import VoxelGrid
from ipcli.models.animal import union, whole
from ipcli.models.animal.parameters import FIELDS
from ipcli.models.animal.parts import OUTSIDE, carve
from tests.fixtures import limbs

GRID = VoxelGrid(np.full(3, -1.6), 0.1, (33, 33, 33))
AWAY = np.linalg.norm(GRID.points(), axis=-1)


@pytest.mark.parametrize("field", FIELDS)
def test_the_field_of_a_ball_is_the_distance_in_voxels(field):
    ball = trimesh.creation.icosphere(subdivisions=3)
    phi = union.implicit(ball.vertices + [0.0, 0.0, 0.2], ball.faces, GRID, field)
    exact = (np.linalg.norm(GRID.points() - [0.0, 0.0, 0.2], axis=-1) - 1) / 0.1
    near = np.abs(exact) < 3
    assert np.abs(phi - exact)[near].max() < 0.12  # the facets' sagitta
    assert (phi[near] < 0).mean() == pytest.approx((exact[near] < 0).mean(), abs=0.01)


def test_the_tangent_planes_of_a_box_are_its_distance_beside_faces_and_less_beside_edges():
    box = trimesh.creation.box((1.63, 1.23, 0.83))
    sdf, ipf = (union.implicit(box.vertices, box.faces, GRID, field) for field in FIELDS)
    known = sdf < 100
    assert ((sdf < 0) == (ipf < 0)).all()
    beyond = np.maximum(np.abs(GRID.points()) - np.array([1.63, 1.23, 0.83]) / 2, 0)
    faces, edges = ((beyond > 0).sum(axis=-1) == k for k in (1, 2))
    assert np.abs(ipf - sdf)[known & faces].max() < 1e-5
    normal = np.maximum(beyond, 0)[known & edges].sum(axis=-1) / np.sqrt(2) / 0.1  # the edge's is (1, 1) / sqrt 2
    assert ipf[known & edges] == pytest.approx(normal, abs=1e-5)
    assert (ipf <= sdf + 1e-5)[known & edges].all()


def test_a_triangle_that_lies_on_its_mirror_image_has_no_inside():
    flap = np.array([[-1.0, -1, 0], [1, -1, 0], [0, 1, 0]])
    for field in FIELDS:
        phi = union.implicit(flap, np.array([[0, 1, 2], [0, 2, 1]]), GRID, field)
        assert (phi >= 0).all()


@pytest.fixture(scope="module")
def scene():
    images, cameras = map(list, zip(*limbs.shots(("left", "front", "top"), 80), strict=True))
    grid = whole.grid_of(images, cameras, 40)
    return whole.shots_of(images, cameras, grid), grid


def test_an_aspect_leans_as_its_place_does(scene):
    shots, grid = scene
    front = shots[1]
    leaning = np.abs(grid.points()[..., 0] - 0.4 * grid.points()[..., 2]) / grid.spacing - 3
    heights = np.where(front.image.mask(2), np.float32(5.0), np.float32(0))
    vertices, _ = union.placed_surface(heights, front, leaning.astype(np.float32))
    away = vertices[:, 0] - 0.4 * vertices[:, 2]
    assert np.abs(away).max() == pytest.approx(5 / front.camera.scale, abs=0.7 * grid.spacing)


def test_an_aspect_lies_in_its_image_plane_in_the_middle_of_its_place(scene):
    shots, _ = scene
    torso = carve(shots, limbs.TREE)[0]
    heights = np.where(shots[0].image.mask(0), np.float32(9.0), np.float32(0))
    vertices, faces = union.placed_surface(heights, shots[0], torso)
    assert trimesh.Trimesh(vertices, faces, process=False).is_watertight
    camera = shots[0].camera
    depth = camera.depth(vertices)
    assert [depth.min(), depth.max()] == pytest.approx([-9 / camera.scale, 9 / camera.scale], abs=0.03)
    row, column = camera.pixel(vertices, heights.shape)
    assert (heights[row, column] > 0).mean() > 0.8  # the smoothed rim runs half a pixel beside the mask
    assert meshes.volume(vertices, faces) > 0


def test_the_union_holds_every_aspect_and_no_silhouette_clips_it(scene):
    shots, grid = scene
    carved = carve(shots, limbs.TREE)
    high = {(s.image.name, 0): 30.0 * s.image.mask(0).astype(np.float32) for s in shots[:2]}
    both = union.united(carved, shots, grid, high, "sdf")
    each = [union.united(carved, shots, grid, {key: high[key]}, "sdf")[0] for key in high]
    assert np.array_equal(both[0], np.minimum(*each))
    assert (both[1] == OUTSIDE).all()  # no aspect of it
    beside = shots[1].sight.silhouette_distance(shots[1].image.silhouette) > 2
    assert (both[0][beside] < 0).sum() > 100  # the left aspect, made far too thick, sticks out of the front silhouette


def test_the_smoothed_union_shrinks_as_a_ball_does_whatever_its_field():
    phi = ((AWAY - 1.2) / 0.1) * (1.5 + np.sin(9 * GRID.points()[..., 0]))
    found = union.smoothed(phi, 30)
    radius = ((found < 0).sum() * 3 / (4 * np.pi)) ** (1 / 3)
    assert radius == pytest.approx(np.sqrt(12.0**2 - 4 * 30 / 6), abs=0.1)
