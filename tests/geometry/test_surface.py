"""Normals of planes and spheres, and triangles that look at the camera."""

import numpy as np
import pytest

from ipcli.geometry import surface
from ipcli.geometry.cameras import back_project, rays
from ipcli.geometry.surface import normals, normals_of_slopes, triangulate

SHAPE = (36, 48)
K = np.array([[60.0, 0, 22.5], [0, 58.0, 17.5], [0, 0, 1]])


def plane(normal, offset=2.0):
    return offset / (rays(SHAPE, K) @ np.asarray(normal, float))


@pytest.mark.parametrize("normal", [(0, 0, 1), (0.4, 0, 1), (-0.3, 0.5, 1), (0.9, 0.9, 1)])
@pytest.mark.parametrize("factor", [1, 1000])
def test_normals_of_a_plane_are_exact_up_to_the_border_and_face_the_camera(normal, factor):
    n = normals(factor * plane(normal), K)
    expected = -np.array(normal) / np.linalg.norm(normal)
    np.testing.assert_allclose(n, np.broadcast_to(expected, n.shape), atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(n, axis=-1), 1, atol=1e-6)


@pytest.mark.parametrize("normal", [(0, 0, 1), (0.4, 0, 1), (-0.3, 0.5, 1)])
def test_normals_of_the_slopes_of_a_plane_are_exact(normal):
    depth, inverse = plane(normal), np.linalg.inv(K)
    # z = o / (n . K^-1 (u, v, 1)), so dz / du = -z^2 / o n . K^-1 e_u
    slopes = np.stack([-(depth**2) / 2.0 * (np.asarray(normal, float) @ inverse[:, axis]) for axis in (0, 1)])
    n = normals_of_slopes(depth, slopes, K)
    np.testing.assert_allclose(n, np.broadcast_to(-np.array(normal) / np.linalg.norm(normal), n.shape), atol=1e-6)


def sphere(centre=(0.1, -0.05, 3.0), radius=0.8):
    directions = rays(SHAPE, K)
    a, b = (directions**2).sum(axis=-1), directions @ centre
    inside = b * b - a * (np.dot(centre, centre) - radius**2)
    return np.where(inside > 0, (b - np.sqrt(np.maximum(inside, 0))) / a, np.nan), np.array(centre)


def test_normals_of_a_sphere_point_away_from_its_centre_within_a_degree():
    depth, centre = sphere()
    n, points = normals(depth, K), back_project(depth, K)
    outward = points - centre
    outward /= np.linalg.norm(outward, axis=-1, keepdims=True)
    frontal = (-points * outward).sum(axis=-1) > 0.5 * np.linalg.norm(points, axis=-1)  # not where it turns away
    angle = np.degrees(np.arccos(np.clip((n * outward).sum(axis=-1), -1, 1)))[frontal]
    assert angle.size > 200
    assert angle.mean() < 0.5
    assert angle.max() < 1


def test_normals_do_not_smear_over_an_edge_and_stop_at_gaps():
    depth = np.full(SHAPE, 2.0)
    depth[:, 20:] = 3.0
    depth[10, 30] = np.nan
    n = normals(depth, K)
    known = np.isfinite(depth)
    np.testing.assert_allclose(n[known], np.broadcast_to([0, 0, -1.0], n[known].shape), atol=1e-6)
    assert np.isnan(n[10, 30]).all()


def test_a_pixel_without_neighbours_along_an_axis_has_no_normal():
    depth = np.full(SHAPE, np.nan)
    depth[5, :] = 2.0
    assert np.isnan(normals(depth, K)).all()
    assert np.isnan(normals(np.full((1, 9), 2.0), K)).all()


def test_triangles_turn_counter_clockwise_as_seen_from_the_camera_and_cover_the_grid():
    depth = plane((0.3, -0.2, 1)).astype(np.float32)
    pixels, faces = triangulate(depth, np.ones(SHAPE, bool), jump=1.0)
    np.testing.assert_array_equal(pixels, np.arange(depth.size))
    assert len(faces) == 2 * (SHAPE[0] - 1) * (SHAPE[1] - 1)
    points = back_project(depth, K).reshape(-1, 3)[pixels]
    a, b, c = (points[faces[:, i]] for i in range(3))
    assert (np.einsum("ij,ij->i", np.cross(b - a, c - a), a) < 0).all()
    v, u = np.divmod(pixels[faces], SHAPE[1])
    area = ((u[:, 1] - u[:, 0]) * (v[:, 2] - v[:, 0]) - (u[:, 2] - u[:, 0]) * (v[:, 1] - v[:, 0])) / 2
    assert (np.abs(area) == 0.5).all()
    assert np.abs(area).sum() == (SHAPE[0] - 1) * (SHAPE[1] - 1)


def test_a_jump_is_left_open_in_either_direction():
    depth = np.full((4, 6), 2.0, np.float32)
    depth[:, 3:] = 2.2
    across = lambda faces: ((faces % 6 < 3).any(axis=1) & (faces % 6 >= 3).any(axis=1)).sum()  # noqa: E731
    for image in (depth, depth[:, ::-1]):
        pixels, faces = triangulate(image, np.ones((4, 6), bool), jump=0.05)
        assert across(pixels[faces]) == 0
        assert len(faces) == 2 * 3 * 4
        assert across(triangulate(image, np.ones((4, 6), bool), jump=0.11)[1]) == 2 * 3


def test_only_kept_pixels_are_vertices_and_faces_index_them():
    depth = plane((0, 0, 1)).astype(np.float32)
    keep = np.random.default_rng(0).random(SHAPE) < 0.8
    depth[~keep] = np.nan
    pixels, faces = triangulate(depth, keep)
    np.testing.assert_array_equal(pixels, np.flatnonzero(keep))
    assert faces.min() >= 0
    assert faces.max() < len(pixels)
    corners = pixels[faces]
    assert keep.ravel()[corners].all()
    quads = keep[:-1, :-1] & keep[:-1, 1:] & keep[1:, 1:] & keep[1:, :-1]
    assert len(faces) == 2 * quads.sum()
    none = triangulate(depth, np.zeros(SHAPE, bool))
    assert none[0].size == 0
    assert none[1].shape == (0, 3)


def test_triangles_made_in_bands_are_those_made_at_once(monkeypatch):
    rng = np.random.default_rng(0)
    depth, keep = plane((0.4, 0, 1)) + rng.normal(0, 0.05, SHAPE), rng.random(SHAPE) > 0.1
    at_once = triangulate(depth, keep)[1]
    monkeypatch.setattr(surface, "BAND", 7)
    grid = surface.PixelGrid.of(depth, keep)
    np.testing.assert_array_equal(np.concatenate(list(grid.faces())), at_once)
    assert grid.count() == len(at_once)
    assert grid.bands()[-1].stop == SHAPE[0]
    for rows in grid.bands():
        np.testing.assert_array_equal(back_project(depth[rows], K, rows.start), back_project(depth, K)[rows])
