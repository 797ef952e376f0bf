"""Reliefs: the front faces the viewer, the closed one is watertight with the volume it should have."""

import numpy as np
import pytest

from ipcli.geometry.relief import closed, front


def test_the_front_faces_the_viewer_in_the_frame_x_right_y_up():
    vertices, faces, pixels = front(np.zeros((3, 4)), pixel=2.0)
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    assert (np.cross(b - a, c - a)[:, 2] > 0).all()
    assert len(faces) == 12
    np.testing.assert_array_equal(vertices[0], [-3, 2, 0])
    np.testing.assert_array_equal(pixels, np.arange(12))


@pytest.mark.parametrize("holes", [False, True])
def test_a_closed_relief_is_watertight_and_has_its_volume(holes):
    trimesh = pytest.importorskip("trimesh")
    height = np.random.default_rng(0).uniform(0, 2, (12, 15))
    if holes:
        height[4:7, 5:8] = np.nan
        height[0, 0] = np.nan
        height[3, 4] = np.nan  # touches the hole in a corner
    vertices, faces = closed(height, plate=0.2)
    mesh = trimesh.Trimesh(vertices, faces)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    if not holes:
        known = vertices[: len(vertices) // 2].reshape(12, 15, 3)[..., 2]
        base = vertices[:, 2].min()
        a, b, c, d = known[:-1, :-1], known[:-1, 1:], known[1:, :-1], known[1:, 1:]
        under = ((a + c + d) / 6 + (a + d + b) / 6 - base).sum()
        assert mesh.volume == pytest.approx(under, rel=1e-9)


def test_nothing_makes_an_empty_relief():
    vertices, faces = closed(np.full((4, 4), np.nan))
    assert len(vertices) == len(faces) == 0
