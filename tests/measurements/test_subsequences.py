"""Where a camera sees points of the world."""

import numpy as np
import pytest

from ipcli.measurements.subsequences import before, over_cloud, seen_at
from tests.fixtures.search import CAMERA, sequence


def test_points_are_seen_where_they_project_and_nowhere_behind_or_outside():
    pose = np.eye(4)
    pose[0, 3] = 0.1
    points = np.array([[0.0, 0.0, 2.0], [0.0, 0.0, -2.0], [9.0, 0.0, 2.0]])
    pixels = seen_at(CAMERA, pose, points)
    assert pixels[0] == pytest.approx([47.5 + 80 * 0.05, 35.5])
    assert np.isnan(pixels[1:]).all()


def test_what_lies_behind_something_is_not_seen():
    rng = np.random.default_rng(0)
    wall = np.concatenate([rng.uniform(-2, 2, (20000, 2)), np.full((20000, 1), 3.0)], axis=1)
    screen = np.concatenate([rng.uniform(-0.5, 0.5, (20000, 2)), np.full((20000, 1), 1.5)], axis=1)
    seen = before(CAMERA, np.eye(4), np.concatenate([wall, screen]))
    behind = (seen[:, 2] == 3.0) & (np.abs(seen[:, :2]) < 0.85).all(axis=1)
    assert not behind.any()
    assert (seen[:, 2] == 1.5).sum() == len(screen)
    assert (seen[:, 2] == 3.0).any()
    assert len(before(CAMERA, np.eye(4), -wall)) == 0


def test_another_cloud_takes_the_place_of_the_map():
    cloud = np.array([[0.0, 0, 2], [0, 0, -2]])
    found = over_cloud(sequence(), cloud, ())
    assert found.load(1).cloud.tolist() == [[0.0, 0.0, 2.0]]
    assert found.load(1).frames == sequence().load(1).frames
