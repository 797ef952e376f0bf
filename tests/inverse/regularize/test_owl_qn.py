"""OWL-QN on a problem whose minimum is known in closed form, and against a plain proximal gradient method."""

import numpy as np

from ipcli.inverse.regularize.owl_qn import minimise, pseudo_gradient


def test_a_separable_quadratic_is_soft_thresholded():
    b, d = np.array([3.0, -0.4, 0.2, -5.0]), np.array([1.0, 2.0, 4.0, 0.5])
    found = minimise(lambda x: (float((d * (x - b) ** 2).sum() / 2), d * (x - b)), np.zeros(4), np.ones(4), 60)
    np.testing.assert_allclose(found, np.sign(b) * np.maximum(np.abs(b) - 1 / d, 0), atol=1e-6)
    assert (found[[1, 2]] == 0).all()


def test_a_lasso_comes_to_the_minimum_of_the_proximal_gradient():
    rng = np.random.default_rng(0)
    a, y, weights = rng.normal(size=(40, 15)), rng.normal(size=40), np.full(15, 6.0)
    weights[0] = 0.0  # one that is free of the penalty
    x, step = np.zeros(15), 1 / np.linalg.norm(a, 2) ** 2
    for _ in range(5000):
        x = x - step * a.T @ (a @ x - y)
        x = np.sign(x) * np.maximum(np.abs(x) - step * weights, 0)
    found = minimise(lambda v: (float(((a @ v - y) ** 2).sum() / 2), a.T @ (a @ v - y)), np.ones(15), weights, 200)
    np.testing.assert_allclose(found, x, atol=1e-5)
    np.testing.assert_array_equal(found == 0, x == 0)


def test_where_no_direction_goes_down_the_slope_is_zero():
    slope = pseudo_gradient(np.array([0.0, 0.0, 0.0, 2.0]), np.array([0.5, 3.0, -3.0, 0.0]), np.ones(4))
    np.testing.assert_allclose(slope, [0, 2, -2, 1])
