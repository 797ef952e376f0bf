"""Procedural surfaces by ray marching: the ball in closed form, normals against heights."""

import numpy as np
import pytest

from ipcli.models.brdf import surfaces


def test_a_marched_ball_is_a_ball():
    made = surfaces.march(surfaces.ellipsoid(np.full(3, 0.8)), 100)
    rows, columns = np.nonzero(made.mask)
    x, y = (columns + 0.5) / 50 - 1, 1 - (rows + 0.5) / 50
    z = np.sqrt(0.64 - x * x - y * y)
    np.testing.assert_allclose(made.height[made.mask], 50 * z, atol=0.02)
    np.testing.assert_allclose(made.normals[made.mask], np.stack([x, y, z], axis=-1) / 0.8, atol=1e-3)


def test_marching_and_embree_see_the_same_ring():
    trimesh = pytest.importorskip("trimesh")
    pytest.importorskip("embreex")
    made = surfaces.march(surfaces.torus(0.5, 0.2), 64)
    mesh = trimesh.creation.torus(0.5, 0.2, major_sections=256, minor_sections=128)
    axis = (np.arange(64) + 0.5) / 32 - 1
    x, y = np.meshgrid(axis, -axis)
    origins = np.stack([x.ravel(), y.ravel(), np.full(x.size, 2.0)], axis=-1)
    points, rays, _ = mesh.ray.intersects_location(origins, np.tile([0, 0, -1.0], (x.size, 1)), multiple_hits=False)
    seen = np.full(x.size, np.nan)
    seen[rays] = points[:, 2] * 32
    seen = seen.reshape(x.shape)
    assert (np.isfinite(seen) != made.mask).mean() < 0.005
    both = np.isfinite(seen) & made.mask
    inner = both & (made.normals[..., 2] > 0.2)
    assert np.abs(seen - made.height)[inner].max() < 0.05


def test_a_bowl_is_hollow():
    made = surfaces.march(surfaces.bowl(0.8, 0.1, 0.0), 80)
    assert made.height[40, 40] < made.height[40, 12] - 10
