"""The difference operators are adjoint pairs of the stated norm and vanish on the images they should."""

import numpy as np
import pytest

from ipcli.inverse.regularize.operators import (
    NORM,
    dot_test,
    gradient,
    gradient_adjoint,
    symmetric_product,
    symmetrised_gradient,
    symmetrised_gradient_adjoint,
)

each_shape = pytest.mark.parametrize("shape", [(1, 1), (1, 8), (7, 1), (2, 2), (9, 14)], ids=str)
TRUE_NORM = np.sqrt((17 + np.sqrt(33)) / 2)


def fields(*components, shape, seed=3):
    rng = np.random.default_rng(seed)
    return [rng.normal(size=(*c, *shape)) for c in components]


@each_shape
def test_gradient_and_its_adjoint_pass_the_dot_test(shape):
    x, p = fields((), (2,), shape=shape)
    assert dot_test(gradient, gradient_adjoint, x, p) < 1e-14


@each_shape
def test_symmetrised_gradient_and_its_adjoint_pass_the_dot_test(shape):
    v, q = fields((2,), (3,), shape=shape)
    assert dot_test(symmetrised_gradient, symmetrised_gradient_adjoint, v, q, symmetric_product) < 1e-14


@pytest.mark.parametrize(
    "wrong",
    [
        lambda p: -gradient_adjoint(p),
        lambda p: gradient_adjoint(p) * (1 + 1e-9),
        lambda p: gradient_adjoint(p[::-1]),
        lambda p: np.roll(gradient_adjoint(p), 1, axis=1),
        lambda p: -np.gradient(p[0], axis=1) - np.gradient(p[1], axis=0),  # central differences: right inside only
    ],
    ids=["sign", "scale", "swapped", "shifted", "central"],
)
def test_the_dot_test_finds_a_wrong_adjoint(wrong):
    x, p = fields((), (2,), shape=(9, 14))
    assert dot_test(gradient, wrong, x, p) > 1e-11


def test_the_dot_test_finds_a_mixed_entry_that_counts_once():
    v, q = fields((2,), (3,), shape=(9, 14))
    assert dot_test(symmetrised_gradient, symmetrised_gradient_adjoint, v, q) > 1e-3


def test_the_norm_of_the_pair_is_just_below_the_bound_that_the_steps_use():
    """By power iteration of K^T K, K (x, v) = (grad x - v, E v)."""
    x, v = fields((), (2,), shape=(40, 33))
    for _ in range(300):
        size = np.sqrt((x**2).sum() + (v**2).sum())
        x, v = x / size, v / size
        p = gradient(x) - v
        p[0, :, -1] = p[1, -1] = 0
        x, v = gradient_adjoint(p), symmetrised_gradient_adjoint(symmetrised_gradient(v)) - p
    norm = np.sqrt(np.sqrt((x**2).sum() + (v**2).sum()))
    assert 0.95 * TRUE_NORM < norm <= TRUE_NORM * (1 + 1e-12) < NORM


def test_operators_vanish_on_constants_and_on_the_slopes_of_rigid_motions():
    """The kernel of E holds v = (a - c y, b + c x): translations and the infinitesimal rotation."""
    rows, columns = np.indices((6, 9), dtype=float)
    assert not gradient(np.full((6, 9), 4.2)).any()
    rigid = np.stack([0.3 - 0.25 * rows, 0.7 + 0.25 * columns])
    np.testing.assert_allclose(symmetrised_gradient(rigid), 0, atol=1e-15)
