"""Triangulations of masks: area, shape of the triangles, closed surfaces."""

import numpy as np
import pytest

from ipcli.geometry import triangulation as tri


def disc(radius=40, size=100):
    v, u = np.mgrid[:size, :size]
    return (u - size / 2 + 0.5) ** 2 + (v - size / 2 + 0.5) ** 2 < radius**2


def smallest_angles(points, triangles):
    corners = points[triangles]
    sides = np.roll(corners, -1, axis=1) - corners
    sides /= np.linalg.norm(sides, axis=-1, keepdims=True)
    return np.degrees(np.arccos(-(sides * np.roll(sides, 1, axis=1)).sum(-1))).min(axis=1)


@pytest.mark.parametrize("spacing", [2.0, 4.0, 7.0])
def test_the_area_is_that_of_the_mask_and_no_triangle_is_a_sliver(spacing):
    points, triangles = tri.triangulate_mask(disc(), spacing)
    area = tri.signed_area(points, triangles)
    assert (area > 0).all()
    assert area.sum() == pytest.approx(np.pi * 40**2, rel=0.02)
    angles = smallest_angles(points, triangles)
    assert angles.min() > 12
    assert np.median(angles) > 50


def test_holes_are_filled_and_the_largest_blob_is_taken():
    mask = disc()
    mask[45:55, 45:55] = False
    mask[:6, :6] = True
    points, triangles = tri.triangulate_mask(mask, 4.0)
    assert tri.signed_area(points, triangles).sum() == pytest.approx(np.pi * 40**2, rel=0.02)


def test_a_mask_at_the_border_of_the_image_keeps_its_contour():
    mask = np.ones((30, 50), bool)
    points, triangles = tri.triangulate_mask(mask, 3.0)
    assert tri.signed_area(points, triangles).sum() == pytest.approx(1500, rel=0.02)
    assert points.min() == pytest.approx(-0.5, abs=0.3)


def test_reflection_closes_the_surface_outwards():
    import trimesh

    points, triangles = tri.triangulate_mask(disc(), 4.0)
    heights = np.sqrt(np.maximum(40**2 - ((points - 49.5) ** 2).sum(axis=1), 0))
    mesh = trimesh.Trimesh(*tri.reflect(points, triangles, heights), process=False)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume == pytest.approx(4 / 3 * np.pi * 40**3, rel=0.03)


def test_resampling_is_even():
    square = np.array([[0.0, 0], [10, 0], [10, 10], [0, 10]])
    points = tri.resample(square, 1.0)
    assert len(points) == 40
    assert np.linalg.norm(np.diff(points, axis=0), axis=1) == pytest.approx(np.ones(39))


def test_distance_to_a_polygon():
    square = np.array([[0.0, 0], [10, 0], [10, 10], [0, 10]])
    assert tri.distance_to(square, np.array([[5.0, 5], [5, 1], [-3, -4], [12, 5]])) == pytest.approx([5, 1, 5, 2])


@pytest.mark.parametrize("mask", [np.zeros((9, 9), bool), np.eye(3, dtype=bool)])
def test_too_little_is_refused(mask):
    with pytest.raises(ValueError, match="mask"):
        tri.triangulate_mask(mask, 5.0)


def test_what_is_farther_from_a_polygon_is_what_its_distance_says():
    rng = np.random.default_rng(0)
    angles = np.sort(rng.uniform(0, 2 * np.pi, 9))
    polygon = 10 * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    points = rng.uniform(-30, 30, (500, 2))
    farther = tri.is_farther(polygon, points, 2.0)
    assert (farther == (tri.distance_to(polygon, points) > 2.0)).all()
    assert 50 < farther.sum() < 499
