"""Clouds of bounded size."""

import numpy as np
import pytest

from ipcli.models.saliency.gathered import GatheredCloud


def test_points_of_one_voxel_become_their_mean_however_they_come():
    cloud = GatheredCloud(1)
    for value in (1.0, 2.0, 6.0):
        cloud.add(np.full((1, 3), 0.501), np.array([[value]]))
    assert cloud.rows == pytest.approx(np.array([[0.501, 0.501, 0.501, 3.0]]))


def test_the_cloud_stays_below_its_bound_and_keeps_the_mean():
    cloud, rng = GatheredCloud(1, most=500), np.random.default_rng(0)
    total = 0.0
    for _ in range(8):
        values = rng.normal(size=(400, 1))
        cloud.add(rng.uniform(-2, 2, (400, 3)), values)
        total += values.sum()
    assert len(cloud.rows) <= 500
    assert (cloud.rows[:, 3] * cloud.counts).sum() == pytest.approx(total)
