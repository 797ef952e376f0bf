"""Orthographic cameras: what is left and right of an animal, and that lifting undoes projecting."""

import numpy as np
import pytest

from ipcli.geometry import orthographic as ortho

HEAD, LEFT_SIDE, BACK = np.eye(3)  # a point ahead, one to the left, one above


def pixel(view, point):
    return ortho.Orthographic(ortho.of_view(view), 1.0, np.zeros(2)).project(point)


@pytest.mark.parametrize("view", ortho.NAMED)
def test_named_views_are_rotations(view):
    r = ortho.of_view(view)
    assert r @ r.T == pytest.approx(np.eye(3))
    assert np.linalg.det(r) == pytest.approx(1.0)


def test_the_head_is_where_a_viewer_sees_it():
    assert pixel("left", HEAD)[0] == -1
    assert pixel("right", HEAD)[0] == 1
    assert pixel("front", LEFT_SIDE)[0] == 1
    assert pixel("back", LEFT_SIDE)[0] == -1
    assert all(pixel(view, BACK)[1] == -1 for view in ("left", "right", "front", "back"))


@pytest.mark.parametrize(("azimuth", "view"), [(0, "front"), (90, "left"), (180, "back"), (270, "right")])
def test_azimuths_of_the_named_views(azimuth, view):
    assert ortho.looking(azimuth, 0.0) == pytest.approx(ortho.of_view(view), abs=1e-12)


def test_one_view_has_one_word():
    words = [ortho.by_angles(*angles) for angles in ((0, 0), (360, 0), (-270, 0), (180, 90), (-40, 15), (320, 15))]
    assert words == ["front", "front", "left", "top", "320,15", "320,15"]


def test_a_view_by_angles_is_what_a_camera_there_sees():
    assert ortho.by_angles(40.0, 15) == "40,15"
    assert ortho.of_view("40,15") == pytest.approx(ortho.looking(40.0, 15.0))
    assert ortho.of_view(ortho.by_angles(90, 0)) == pytest.approx(ortho.of_view("left"), abs=1e-12)
    for wrong in ((400.0, 0.0), (0.0, 91.0), (float("nan"), 0.0)):
        with pytest.raises(ValueError, match="outside"):
            ortho.by_angles(*wrong)


def test_lifting_undoes_projecting():
    rng = np.random.default_rng(0)
    camera = ortho.Orthographic(ortho.looking(33.0, 20.0, 10.0), 3.0, np.array([5.0, 7.0]))
    points = rng.normal(size=(10, 3))
    assert camera.lift(camera.project(points), camera.depth(points)) == pytest.approx(points)


def test_turning_by_an_angle_turns_by_that_angle():
    camera = ortho.Orthographic(ortho.of_view("left"), 1.0, np.zeros(2))
    turned = camera.turned(np.radians([3.0, 0.0, 4.0]))
    assert ortho.angle_between(camera.rotation, turned.rotation) == pytest.approx(5.0)


def test_directions_cover_the_sphere():
    d = ortho.fibonacci(1500)
    assert np.linalg.norm(d, axis=1) == pytest.approx(np.ones(1500))
    rng = np.random.default_rng(1)
    probe = rng.normal(size=(200, 3))
    probe /= np.linalg.norm(probe, axis=1, keepdims=True)
    assert np.degrees(np.arccos((probe @ d.T).max(axis=1))).max() < 5


def test_the_pixel_of_a_point_is_the_nearest_and_in_the_image():
    camera = ortho.Orthographic(ortho.of_view("left"), 2.0, np.array([5.0, 4.0]))
    points = camera.lift(np.array([[3.4, 2.6], [-3.0, 99.0]]), 1.0)
    row, column = camera.pixel(points, (8, 10))
    assert (row.tolist(), column.tolist()) == ([3, 7], [3, 0])
