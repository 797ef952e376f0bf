"""Thin plates: planes are free, bending is not, samples are bilinear, gross errors do not bend the plate."""

import numpy as np
import pytest

from ipcli.errors import ParameterError
from ipcli.inverse.regularize import thin_plate

SHAPE = (17, 23)


def scattered(count=400, seed=0):
    return np.random.default_rng(seed).uniform(0, [SHAPE[1] - 1, SHAPE[0] - 1], (count, 2))


def test_sampling_is_bilinear():
    at = np.array([[2.25, 3.5], [22.0, 16.0], [0.0, 0.0]])
    grid = np.random.default_rng(1).normal(size=SHAPE)
    expected = [
        0.75 * (grid[3, 2] + grid[4, 2]) / 2 + 0.25 * (grid[3, 3] + grid[4, 3]) / 2, grid[16, 22], grid[0, 0]
    ]  # fmt: skip
    assert thin_plate.sampling(at, SHAPE) @ grid.ravel() == pytest.approx(expected)


def test_bending_is_the_sum_of_squared_second_differences():
    grid = np.random.default_rng(2).normal(size=SHAPE)
    xx, yy = np.diff(grid, 2, axis=1), np.diff(grid, 2, axis=0)
    xy = np.diff(np.diff(grid, axis=0), axis=1)
    energy = grid.ravel() @ thin_plate.bending(SHAPE) @ grid.ravel()
    assert energy == pytest.approx((xx**2).sum() + (yy**2).sum() + 2 * (xy**2).sum())


def test_a_plane_is_found_whatever_the_stiffness():
    at = scattered()
    rows, columns = np.indices(SHAPE)
    nodes = thin_plate.fit(at, 3 + 0.2 * at[:, 0] - 0.1 * at[:, 1], SHAPE, 1e4)
    assert nodes == pytest.approx(3 + 0.2 * columns - 0.1 * rows, abs=1e-5)


def test_the_fit_is_where_the_gradient_of_the_energy_is_nought():
    at, rng = scattered(), np.random.default_rng(3)
    values = rng.normal(size=len(at))
    nodes = thin_plate.fit(at, values, SHAPE, 0.7).ravel()
    sample = thin_plate.sampling(at, SHAPE)
    gradient = sample.T @ (sample @ nodes - values) + 0.7 * (thin_plate.bending(SHAPE) @ nodes)
    assert np.abs(gradient).max() < 1e-9


def test_gross_errors_do_not_bend_a_robust_plate():
    at = scattered(900)
    values = 1 + 0.05 * at[:, 0] + np.random.default_rng(4).normal(0, 0.01, len(at))
    values[::10] += 5
    rows, columns = np.indices(SHAPE)
    true = 1 + 0.05 * columns
    plain = np.abs(thin_plate.fit(at, values, SHAPE, 1.0) - true).max()
    assert np.abs(thin_plate.fit(at, values, SHAPE, 1.0, rounds=6) - true).max() < 0.1 * plain


def test_too_little_is_refused():
    with pytest.raises(ParameterError, match="three points"):
        thin_plate.fit(np.zeros((2, 2)), np.zeros(2), SHAPE, 1.0)
