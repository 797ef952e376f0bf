"""Surfaces and their curvatures on shapes whose curvature is known."""

import numpy as np
import pytest

from ipcli.errors import ParameterError
from ipcli.models.saliency import surface
from ipcli.models.saliency.scene_parameters import SurfaceFit

COARSE = SurfaceFit(nodes=1600, eta=1e-7)


def ball(count=8000, radius=1.0, seed=0):
    """Points of a ball's cap before the camera; outwards is towards it."""
    x, y = np.random.default_rng(seed).uniform(-0.5, 0.5, (2, count))
    return np.stack([x, y, 3.0 - np.sqrt(radius**2 - x**2 - y**2)], axis=1)


@pytest.mark.parametrize("over", ["plane", "pixels"])
def test_a_ball_has_the_curvature_of_its_radius_everywhere(over):
    found = surface.fit(ball(), SurfaceFit(nodes=1600, eta=1e-7, over=over))
    inner = (slice(6, -6),) * 2
    assert np.median(found.gaussian[inner]) == pytest.approx(1.0, rel=0.05)
    assert np.median(np.abs(found.mean[inner])) == pytest.approx(1.0, rel=0.05)
    assert np.percentile(np.abs(found.gaussian[inner] - 1), 90) < 0.2


def test_a_slanted_plane_is_exact_over_pixels_with_its_normal():
    x, y = np.random.default_rng(1).uniform(-1, 1, (2, 2000))
    z = 2 + 0.8 * x
    found = surface.fit(np.stack([x, y, z], axis=1), COARSE)
    assert found.error < 1e-6
    assert np.abs(found.gaussian).max() < 1e-6
    assert found.points[..., 2] == pytest.approx(2 + 0.8 * found.points[..., 0], abs=1e-5)
    assert np.abs(found.normals @ np.array([0.8, 0, -1]) / np.hypot(0.8, 1)) == pytest.approx(
        np.ones(found.known.shape)
    )


def test_what_no_point_is_near_is_unknown():
    cloud = ball()
    cloud = cloud[(cloud[:, 0] < -0.2) | (cloud[:, 0] > 0.2)]
    known = surface.fit(cloud, COARSE).known
    assert not known[:, known.shape[1] // 2].any()
    assert known[:, 2].all()


def test_gross_errors_leave_the_surface_alone():
    cloud = ball()
    cloud[::20, 2] += 1.5
    assert surface.fit(cloud, COARSE).error < 0.02


def test_too_few_points_are_refused():
    with pytest.raises(ParameterError, match="before the camera"):
        surface.fit(-ball(), COARSE)
