"""Mean curvature flow against the exact shrinking of spheres and cylinders; distances; closed meshes."""

import numpy as np
import pytest

from ipcli.geometry import level_sets as ls


def grid(n=41):
    return np.stack(np.meshgrid(*[np.arange(n) - n // 2] * 3, indexing="ij"), axis=-1).astype(float)


def sphere(radius, n=41):
    return np.linalg.norm(grid(n), axis=-1) - radius


def radius_along(phi, axis=0):
    n = phi.shape[0]
    line = np.moveaxis(phi, axis, 0)[n // 2 :, n // 2, n // 2]
    k = int(np.argmax(line > 0))
    return k - 1 + line[k - 1] / (line[k - 1] - line[k])


@pytest.mark.parametrize("time", [2.0, 10.0, 20.0])
def test_a_sphere_shrinks_by_four_times_the_time(time):
    phi = ls.flow(sphere(12.0), time)
    exact = np.sqrt(12.0**2 - 4 * time)
    assert radius_along(phi) == pytest.approx(exact, abs=0.03)
    v, f = ls.mesh(phi)
    assert np.linalg.norm(v - 20, axis=1) == pytest.approx(exact, abs=0.08)


@pytest.mark.parametrize("axis", [0, 1])
def test_a_cylinder_shrinks_by_twice_the_time(axis):
    g = grid()
    phi = np.linalg.norm(np.delete(g, 2, axis=-1), axis=-1) - 10.0
    assert radius_along(ls.flow(phi, 15.0), axis) == pytest.approx(np.sqrt(70.0), abs=0.03)


def test_redistancing_on_the_way_keeps_the_exact_time_of_a_warped_field():
    warped = sphere(9.0, 25) * (1.5 + np.sin(grid(25)[..., 0] / 3))
    assert radius_along(ls.flow(warped, 5.0, every=5)) == pytest.approx(np.sqrt(61.0), abs=0.1)
    cylinder = np.linalg.norm(np.delete(grid(25), 2, axis=-1), axis=-1) - 8.0
    assert radius_along(ls.flow(cylinder, 5.0, every=5)) == pytest.approx(np.sqrt(54.0), abs=0.1)


def test_a_plane_stays():
    g = grid()
    phi = (g @ np.array([1.0, 2, 2])) / 3
    moved = ls.flow(phi, 5.0)[15:-15, 15:-15, 15:-15]
    assert np.abs(moved - phi[15:-15, 15:-15, 15:-15]).max() < 1e-4  # away from the mirrored border


def test_redistancing_mends_a_scaled_and_warped_field():
    exact = sphere(12.0)
    found = ls.redistance(exact * (1.5 + np.sin(grid()[..., 0] / 3) / 2), reach=5.0)
    near = np.abs(exact) < 4
    assert np.abs(found - exact)[near].max() < 0.2
    assert np.abs(found - exact)[near].mean() < 0.03
    assert np.abs(found).max() == 5.0


@pytest.mark.parametrize("value", [-1.0, 1.0])
def test_redistancing_a_field_without_a_surface(value):
    assert (np.sign(ls.redistance(np.full((4, 5, 6), value))) == value).all()


def closed(vertices, faces):
    import trimesh

    m = trimesh.Trimesh(vertices, faces, process=False)
    return m.is_watertight and m.is_winding_consistent and m.volume > 0


def test_meshes_are_closed_even_where_the_surface_meets_grid_points():
    assert closed(*ls.mesh(sphere(12.0)))
    box = np.abs(grid()).max(axis=-1) - 5.0  # exact zeros on whole faces
    assert closed(*ls.mesh(box))


def test_a_surface_that_leaves_the_grid_is_closed_there():
    assert closed(*ls.mesh(sphere(25.0)))


def test_spacing_and_origin_place_the_mesh():
    v, _ = ls.mesh(sphere(12.0), 0.5, np.array([1.0, 2, 3]))
    assert (v.min(axis=0) + v.max(axis=0)) / 2 == pytest.approx([11, 12, 13], abs=1e-6)


def test_nothing_inside_is_refused():
    with pytest.raises(ValueError, match="inside"):
        ls.mesh(np.ones((4, 4, 4)))


def test_the_largest_blob_and_filled_cavities():
    inside = np.zeros((9, 9, 9), bool)
    inside[1:6, 1:6, 1:6] = True
    inside[3, 3, 3] = False
    inside[8, 8, 8] = True
    assert ls.largest(inside).sum() == 124
    assert ls.fill(ls.largest(inside)).sum() == 125
