"""The coarse-to-fine start keeps affine images, its energy, and feasible duals."""

import numpy as np
import pytest

from ipcli.inverse.regularize import tgv
from ipcli.inverse.regularize.fidelity import AbsoluteDeviations, Observations
from ipcli.inverse.regularize.parameters import Regulariser, Solver
from ipcli.models.fusion.pyramid import filled_median, halved, start

TGV = Regulariser()


def affine(shape):
    rows, columns = np.indices(shape)
    return (1 + 0.25 * columns - 0.5 * rows).astype(np.float32)


def test_halving_takes_the_mean_of_the_observations_that_there_are():
    layers = np.array([[[1, 2, np.nan, np.nan, 7], [3, np.nan, np.nan, np.nan, 7], [9, 9, 9, 9, 9]]], np.float32)
    np.testing.assert_array_equal(halved(layers), np.array([[[2, np.nan]]], np.float32))


def test_the_median_is_filled_with_the_median_of_the_medians():
    layers = np.array([[[1, 5, np.nan]], [[3, 5, np.inf]]], np.float32)
    np.testing.assert_array_equal(filled_median(Observations.of(layers)), [[2, 5, 3.5]])


@pytest.mark.parametrize("shape", [(96, 128), (97, 131), (48, 48)], ids=str)
@pytest.mark.parametrize("levels", [2, 3])
def test_a_start_reproduces_an_affine_image_with_its_slopes(shape, levels):
    """Inside: enlarging stretches the border, and an odd image as a whole, by less than the slope over a pixel."""
    x = affine(shape)
    iterate = start(np.stack([x, x + 1, x - 1]), 0.5, TGV, Solver(level_iterations=400), levels)
    even = all(side % 4 == 0 for side in shape)
    inside = (slice(8, -8), slice(8, -8))
    np.testing.assert_allclose(iterate.x[inside], x[inside], atol=0.02 if even else 0.25 + 0.5)
    assert np.median(iterate.v[0]) == pytest.approx(0.25, abs=0.01)
    assert np.median(iterate.v[1]) == pytest.approx(-0.5, abs=0.01)


def noisy(shape=(100, 124)):
    rng = np.random.default_rng(4)
    layers = affine(shape) / 4 + rng.laplace(size=(3, *shape)).astype(np.float32)
    layers[:, 40:70, 50:90] = np.nan
    return layers.astype(np.float32)


def test_a_start_has_feasible_duals_that_are_zero_where_no_difference_is():
    iterate = start(noisy(), 0.5, TGV, Solver(relaxation=1.0), 3)
    p, q = iterate.p, iterate.q
    assert np.hypot(*p).max() <= 1 + 1e-5
    assert np.sqrt(q[0] ** 2 + q[1] ** 2 + 2 * q[2] ** 2).max() <= 2 + 1e-5
    assert not p[0, :, -1].any()
    assert not p[1, -1].any()
    assert not q[0, :, 0].any()
    assert not q[1, 0].any()
    assert not q[2, 0].any()
    assert not q[2, :, 0].any()
    assert np.abs(p).max() > 0.5  # they are not just empty


def test_half_the_size_is_half_the_energy():
    """TGV with alpha0 halved plus twice the data term of the halved image is half of the energy of a smooth image."""
    rows, columns = np.indices((96, 128)) / 16
    x = (np.sin(columns) * np.cos(rows) * 9).astype(np.float32)
    gradients = [np.stack(np.gradient(a)[::-1]).astype(np.float32) for a in (x, halved(x[None])[0])]
    fine = tgv.value(x, gradients[0], Regulariser(alpha1=0.0))
    coarse = tgv.value(halved(x[None])[0], gradients[1], Regulariser(alpha1=0.0, alpha0=1.0))
    assert coarse == pytest.approx(fine / 2, rel=0.05)
    zero = [0 * g for g in gradients]
    fine, coarse = (
        tgv.value(a, z, Regulariser(alpha0=0.0)) for a, z in zip((x, halved(x[None])[0]), zero, strict=True)
    )
    assert coarse == pytest.approx(fine / 2, rel=0.02)


def test_the_start_is_nearer_to_the_optimum_than_the_median():
    layers = noisy()
    fidelity = AbsoluteDeviations(Observations.of(layers), np.full(layers.shape[1:], 0.3, np.float32))
    energies = []
    for levels in (1, 3):
        iterate = start(layers, 0.3, TGV, Solver(), levels)
        energies.append(tgv.minimise(fidelity, TGV, iterate, fidelity.data.bounds, Solver(iterations=50))[-1].energy)
    assert energies[1] < energies[0]
