"""Grids seen by cameras: where points fall, and visual hulls that are known."""

import numpy as np
import pytest

from ipcli.geometry.orthographic import Orthographic, looking, of_view
from ipcli.geometry.voxels import FAR, Sight, VoxelGrid, hull, signed_distance

GRID = VoxelGrid.around(np.full(3, -1.0), np.full(3, 1.0), 0.1, margin=2)


def disc(radius, size=101):
    v, u = np.mgrid[:size, :size] - size // 2
    return u**2 + v**2 <= radius**2


def test_planes_are_products_with_the_points():
    row = np.array([0.3, -2.0, 1.0])
    assert GRID.plane(row, 0.5) == pytest.approx(GRID.points() @ row + 0.5)


def test_points_fall_where_the_camera_projects_them():
    camera = Orthographic(looking(33.0, 20.0), 30.0, np.array([50.0, 48.0]))
    sight = Sight.of(GRID, camera)
    pixels = camera.project(GRID.points())
    assert np.abs(sight.columns - pixels[..., 0]).max() < 1e-3
    assert np.abs(sight.rows - pixels[..., 1]).max() < 1e-3
    assert sight.depth * GRID.spacing == pytest.approx(camera.depth(GRID.points()), abs=1e-4)


def test_signed_distance_of_a_disc():
    v, u = np.mgrid[:101, :101] - 50
    assert np.abs(signed_distance(disc(30)) - (np.hypot(u, v) - 30)).max() < 1.0
    assert signed_distance(np.zeros((5, 7), bool)).min() == 7


def test_the_hull_of_three_discs_is_their_common_body():
    cameras = [Orthographic(of_view(view), 40.0, np.array([50.0, 50.0])) for view in ("left", "front", "top")]
    field = hull([Sight.of(GRID, c) for c in cameras], [disc(32)] * 3)
    x, y, z = np.moveaxis(GRID.points(), -1, 0)
    inside = np.maximum.reduce([np.hypot(x, z), np.hypot(y, z), np.hypot(x, y)]) < 0.8
    assert ((field < 0) != inside).mean() < 0.02


def test_the_least_of_a_ray_and_rays_that_meet_nothing():
    sight = Sight.of(GRID, Orthographic(of_view("front"), 10.0, np.zeros(2)))
    least = sight.least(sight.depth, GRID.points()[..., 2] > 0)
    met = least < FAR / 2
    assert met.mean() == pytest.approx((GRID.points()[0, 0, :, 2] > 0).mean(), abs=0.03)
    assert least[met] == pytest.approx(np.full(met.sum(), sight.depth.min()), abs=1e-3)


@pytest.mark.parametrize("rotation", [of_view("left"), of_view("top"), looking(33.0, 20.0)])
def test_images_are_sampled_where_the_points_fall(rotation):
    rows, columns = np.mgrid[:90, :100]
    ramp = (2.0 * rows - columns).astype(np.float32)
    sight = Sight.of(GRID, Orthographic(rotation, 30.0, np.array([50.0, 48.0])))
    inside = (sight.rows >= 0) & (sight.rows <= 89) & (sight.columns >= 0) & (sight.columns <= 99)
    expected = np.where(inside, 2 * sight.rows - sight.columns, -7.0)
    sampled = sight.sample(ramp, -7.0)
    assert sampled.flags.writeable
    assert sampled[inside] == pytest.approx(expected[inside], abs=1e-3)
    assert (sampled[(sight.rows < -1) | (sight.columns < -1)] == -7.0).all()
