"""Multivariate t densities against SciPy."""

import numpy as np
import pytest
from scipy import stats

from ipcli.inverse.bayes.student import Students


@pytest.mark.parametrize("d", [1, 2, 6])
def test_densities_are_those_of_scipy(d):
    rng = np.random.default_rng(d)
    chol = np.tril(rng.normal(size=(3, d, d)), -1) + np.eye(d) * rng.uniform(0.3, 2, (3, d, 1))
    students = Students(np.array([1.0, 4.5, 80.0]), rng.normal(size=(3, d)), chol)
    x = 3 * rng.normal(size=(20, d))
    each = zip(students.location, students.chol, students.dof, strict=True)
    expected = [stats.multivariate_t(m, c @ c.T, df).logpdf(x).reshape(20) for m, c, df in each]
    np.testing.assert_allclose(students.log_density(x), np.transpose(expected), rtol=1e-10)
    at_home = [students.log_density(place[None])[0, j] for j, place in enumerate(students.location)]
    np.testing.assert_allclose(students.log_normaliser(), at_home, rtol=1e-12)


def test_without_dimensions_every_density_is_one():
    students = Students(np.array([3.0]), np.empty((1, 0)), np.empty((1, 0, 0)))
    np.testing.assert_allclose(students.log_density(np.empty((4, 0))), np.zeros((4, 1)), atol=1e-15)
