"""Least absolute deviations: primal-dual, reweighting and the linear programme find one optimum."""

import numpy as np
import pytest
from scipy.optimize import linprog

from ipcli.inverse.regularize.least_absolute import deviation, primal_dual, reweighted


def programme(p, jacobian, bound):
    n, k = jacobian.shape
    cost = np.concatenate([np.zeros(k), np.ones(n)])
    above = np.block([[jacobian, -np.eye(n)], [-jacobian, -np.eye(n)]])
    limits = [(-bound, bound)] * k + [(0, None)] * n
    return linprog(cost, above, np.concatenate([-p, p]), bounds=limits, method="highs").x[:k]


def problem(seed, outliers=0.2):
    rng = np.random.default_rng(seed)
    jacobian = rng.normal(size=(150, 5)) * [1, 1, 3, 0.3, 1]
    p = -jacobian @ [0.5, -0.2, 0.3, 0.9, 0.0] + 0.05 * rng.normal(size=150)
    p[: int(outliers * 150)] += 4
    return p, jacobian


@pytest.mark.parametrize("solve", [primal_dual, reweighted])
@pytest.mark.parametrize("bound", [2.0, 0.4])  # the second cuts off the free optimum
def test_both_reach_the_optimum_of_the_linear_programme(solve, bound):
    p, jacobian = problem(1)
    best = programme(p, jacobian, bound)
    found = solve(p, jacobian, bound)
    assert np.abs(found).max() <= bound
    assert deviation(p, jacobian, found) <= deviation(p, jacobian, best) * (1 + 2e-4)
    assert np.abs(found - best).max() < 5e-3


def test_outliers_do_not_draw_it():
    p, jacobian = problem(2)
    assert np.abs(reweighted(p, jacobian, 3.0) - [0.5, -0.2, 0.3, 0.9, 0.0]).max() < 0.05
    assert np.abs(np.linalg.lstsq(jacobian, -p, rcond=None)[0] - [0.5, -0.2, 0.3, 0.9, 0.0]).max() > 0.1


def test_a_jacobian_of_zeros_moves_nothing():
    assert np.array_equal(primal_dual(np.ones(4), np.zeros((4, 2)), 1.0), np.zeros(2))
