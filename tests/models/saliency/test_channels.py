import numpy as np
import pytest

from ipcli.models.saliency import channels
from tests.fixtures.fixation_sets import picture


@pytest.fixture(scope="module")
def found():
    canvas, middle = picture(3)
    return channels.channels(canvas), middle


def test_all_channels_are_finite_maps_of_one_grid(found):
    maps, _ = found
    assert len(maps) >= 35
    assert {part.shape for part in maps.values()} == {(150, 200)}
    assert all(part.dtype == np.float32 and np.isfinite(part).all() for part in maps.values())


@pytest.mark.parametrize(
    "name", ["Boolean maps", "red-green contrast 5", "rare colours", "rare answers", "unlike the mean"]
)
def test_the_one_thing_that_differs_is_what_a_channel_points_at(found, name):
    maps, (x, y) = found
    row, column = int(y * 150 / 96), int(x * 200 / 128)
    near = maps[name][row - 14 : row + 15, column - 14 : column + 15].max()
    assert near >= np.percentile(maps[name], 99)


def test_a_flat_grey_picture_has_finite_channels_and_a_tiny_one_too():
    for shape in ((60, 80, 3), (5, 3, 3)):
        maps = channels.channels(np.full(shape, 128, np.uint8))
        assert all(np.isfinite(part).all() for part in maps.values())


def test_gaussian_curvature_of_a_sphere_and_of_a_saddle():
    y, x = np.mgrid[-10:11, -10:11].astype(float)
    ball = channels.gaussian_curvature(np.sqrt(50.0**2 - x**2 - y**2))
    assert ball[10, 10] == pytest.approx(1 / 50**2, rel=1e-2)
    assert channels.gaussian_curvature(0.01 * x * y)[10, 10] == pytest.approx(-(0.01**2), rel=1e-6)


def test_the_centre_prior_is_even_about_the_middle():
    prior = channels.centre_prior((30, 40))
    assert np.allclose(prior, prior[::-1, ::-1])
    assert prior[15, 20] == prior.max()


def test_spectral_residual_finds_a_dot_in_a_regular_pattern():
    y, x = np.mgrid[0:96, 0:128]
    pattern = np.repeat((0.5 + 0.2 * np.sin(x / 3) * np.sin(y / 3))[..., None], 3, axis=2).astype(np.float32)
    pattern[40:46, 90:96] = 1.0
    row, column = np.unravel_index(channels.spectral_residual(pattern, 64).argmax(), (96, 128))
    assert abs(row - 43) < 8
    assert abs(column - 93) < 8
