"""Units of the noise: what they measure and that they can be undone."""

import numpy as np
import pytest

from ipcli.errors import NoSolution
from ipcli.models.fusion.observations import measure, noise_scale

# What a normal distribution of deviation 1, or a Laplace distribution of scale 1, is to be measured as.
TRUE = {"normal": 1.0, "laplace": 1.4826 * np.log(2)}


def noisy(distribution, k, shape=(150, 200), scale=0.03, seed=0):
    rows, columns = np.indices(shape)
    plane = 2 + 0.01 * columns - 0.004 * rows
    return plane + scale * getattr(np.random.default_rng(seed), distribution)(size=(k, *shape))


@pytest.mark.parametrize("distribution", TRUE)
@pytest.mark.parametrize("k", range(2, 12))
def test_the_noise_scale_is_the_same_for_any_number_of_observations(distribution, k):
    """Within 5 %; so few as 2 or 3 values do not tell the distributions apart, whose best factors differ by 16 and 12
    %.
    """
    layers = noisy(distribution, k).astype(np.float32)
    assert noise_scale(layers) == pytest.approx(0.03 * TRUE[distribution], rel={2: 0.1, 3: 0.07, 4: 0.07}.get(k, 0.055))


@pytest.mark.parametrize(("distribution", "tolerance"), [("normal", 0.05), ("laplace", 0.2)])
def test_the_noise_scale_of_one_view_of_a_plane_comes_from_its_second_differences(distribution, tolerance):
    """A sum of three Laplace variables is nearly normal, so that their scale is taken for 1 / 1.18 of what it is."""
    assert noise_scale(noisy(distribution, 1).astype(np.float32)) == pytest.approx(
        0.03 * TRUE[distribution], rel=tolerance
    )


@pytest.mark.parametrize("k", [3, 7])
def test_missing_pixels_hardly_change_the_noise_scale_and_outliers_do_not_carry_it_away(k):
    layers, rng = noisy("laplace", k), np.random.default_rng(9)
    layers[rng.random(layers.shape) < 0.2] = np.nan
    assert noise_scale(layers.astype(np.float32)) == pytest.approx(0.03 * TRUE["laplace"], rel=0.1)
    layers[rng.random(layers.shape) < 0.1] *= 0.5  # the standard deviation becomes 15 times the noise
    assert noise_scale(layers.astype(np.float32)) == pytest.approx(0.03 * TRUE["laplace"], rel=0.4)


@pytest.mark.parametrize("inverse", [False, True])
def test_depth_survives_the_units_and_missing_depth_stays_missing(inverse):
    layers = noisy("laplace", 4).astype(np.float32)
    layers[0, :5] = np.inf
    units = measure(layers, inverse=inverse)
    x = units.normalise(layers)
    np.testing.assert_allclose(units.depth(x), np.where(np.isinf(layers), np.nan, layers), rtol=1e-5)
    assert np.isnan(x[0, :5]).all()
    assert abs(np.nanmedian(x)) < 1e-3
    assert noise_scale(x) == pytest.approx(1, rel=1e-3)


def test_units_do_not_depend_on_the_unit_of_length():
    layers = noisy("normal", 3).astype(np.float32)
    for inverse in (False, True):
        metres, millimetres = (measure(factor * layers, inverse=inverse) for factor in (1, np.float32(1000)))
        # depth is known to 1 part in 10^7 and the noise is some hundredth of it
        np.testing.assert_allclose(metres.normalise(layers), millimetres.normalise(1000 * layers), rtol=1e-5, atol=3e-4)


def test_an_in_painted_inverse_depth_cannot_cross_zero():
    units = measure(noisy("normal", 3).astype(np.float32), inverse=True)
    assert 0 < units.depth(np.float32([-1e6]))[0] < np.inf


def test_observations_without_noise_have_a_scale_and_none_at_all_no_solution():
    assert measure(np.full((3, 4, 5), 2, np.float32), inverse=False).scale > 0
    with pytest.raises(NoSolution, match="no view has a valid depth"):
        measure(np.full((3, 4, 5), np.inf, np.float32), inverse=False)
