"""Prior confidences of surfaces and images whose answer is known."""

import numpy as np
import pytest

from ipcli.geometry.cameras import rays
from ipcli.models.fusion.confidence import LEAST, SHARE, image_edges, uncertainty, view_angle
from tests.fixtures.fusion_scenes import camera

K = camera((40, 50))


def plane_depth(normal):
    return (2.0 / (rays((40, 50), K) @ normal)).astype(np.float32)


@pytest.mark.parametrize("normal", [(0, 0, 1.0), (0.5, -0.2, 1.0)])
def test_view_angle_is_the_cosine_between_the_normal_of_a_plane_and_the_ray(normal):
    directions = rays((40, 50), K)
    cosine = directions @ normal / np.linalg.norm(directions, axis=-1) / np.linalg.norm(normal)
    np.testing.assert_allclose(view_angle(plane_depth(normal), K), np.abs(cosine), atol=1e-3)


def test_view_angle_never_cuts_a_pixel_off():
    depth = plane_depth((0, 0, 1.0))
    depth[10:20, 10:20] = np.nan
    least = view_angle(depth, K)
    assert np.isfinite(least).all()
    assert least.min() == np.float32(LEAST)


def test_image_edges_are_1_on_even_areas_and_rise_to_the_gain_at_the_strongest_edge():
    image = np.zeros((40, 50, 3), np.uint8)
    image[:, 25:] = 200
    confidence = image_edges(image, gain=3.0, power=2.0, blur=0.0)
    assert (confidence[:, :20] == 1).all()
    assert confidence[:, 24:26] == pytest.approx(4)
    assert confidence.max() <= 4
    assert (image_edges(np.full_like(image, 77), 3.0, 1.0, 1.0) == 1).all()


def test_the_uncertainty_of_an_even_plane_is_the_noise_that_observations_leave_plus_its_slope():
    x = np.tile(np.arange(40, dtype=np.float32) * 0.2, (40, 1))
    middle = uncertainty(x, np.full((40, 40), 9 * 0.7), np.full((40, 40), 9.0))[20, 20]
    assert middle == pytest.approx(SHARE * 0.7 / 3 + 0.2, rel=1e-3)


def test_the_uncertainty_grows_at_a_step_and_where_observations_are_few():
    x, count = np.zeros((40, 60), np.float32), np.full((40, 60), 9.0)
    x[:, 40:], count[:, :15] = 5, 1
    found = uncertainty(x, 0.7 * count, count)[20]
    assert found[40] > found[5] > found[27]
