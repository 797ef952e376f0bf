"""Statistics of labelled points against plain NumPy."""

import numpy as np
import pytest

from ipcli.kernels import points as kernels


@pytest.mark.parametrize("d", [0, 1, 5])
def test_statistics_are_those_of_numpy(d):
    rng = np.random.default_rng(3)
    x, labels = rng.normal(size=(40, d)), np.array([0, 2, 4, 2] * 10, np.int32)
    count, mean, scatter = kernels.statistics(x, labels, 5)
    np.testing.assert_array_equal(count, [10, 0, 20, 0, 10])
    for k in (0, 2, 4):
        mine = x[labels == k]
        np.testing.assert_allclose(mean[k], mine.mean(axis=0), rtol=1e-12)
        np.testing.assert_allclose(scatter[k], (mine - mean[k]).T @ (mine - mean[k]), rtol=1e-10, atol=1e-12)
    assert not mean[[1, 3]].any()
    assert not scatter[[1, 3]].any()


def test_far_from_the_origin_no_digits_are_lost():
    """Two passes: sums of squares less squares of sums would leave nothing of the scatter."""
    x = np.random.default_rng(4).normal(size=(50, 2))
    labels = np.zeros(50, np.int32)
    near, far = (kernels.statistics(x + shift, labels, 1)[2] for shift in (0.0, 1e8))
    np.testing.assert_allclose(far, near, rtol=1e-6, atol=1e-6)
