"""Coherent regions: what counts as looked at, and what a picture shows of the surface."""

import numpy as np

from ipcli.models.saliency import regions
from tests.fixtures.search import CAMERA, WALL


def test_labels_tell_now_from_another_time_from_never():
    points = np.array([[0.0, 0, 2], [1.0, 0, 2], [3.0, 0, 2]])
    assert regions.labels(points, points[:1] + 0.05, points[:2] + 0.05, 0.2).tolist() == [1, 0, -1]
    assert regions.labels(points, np.empty((0, 3)), np.empty((0, 3)), 0.2).tolist() == [-1, -1, -1]


def test_each_cell_shows_the_nearest_node_and_none_where_there_is_no_surface():
    u, v = np.meshgrid(np.arange(0, 48, 4.0), np.arange(0, 72, 4.0))
    k = CAMERA.intrinsics
    points = np.stack([(u - k[0, 2]) / k[0, 0] * WALL, (v - k[1, 2]) / k[1, 1] * WALL, np.full(u.shape, WALL)], axis=-1)
    cells = regions.nodes_in_picture(CAMERA, np.eye(4), points.reshape(-1, 3))
    assert cells.shape == regions.cells_of(CAMERA) == (18, 24)
    assert (cells[:, -6:] == -1).all()
    assert (cells[:, :11] >= 0).all()
    shown = regions.shown(u.ravel(), cells)
    assert np.abs(shown[:, :11] - np.arange(11) * 4 - 1.5).max() <= 2.6
    assert np.isnan(shown[:, -1]).all()
