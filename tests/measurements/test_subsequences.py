"""Where a camera sees points of the world."""

import numpy as np
import pytest

from ipcli.measurements.subsequences import seen_at
from tests.fixtures.search import CAMERA


def test_points_are_seen_where_they_project_and_nowhere_behind_or_outside():
    pose = np.eye(4)
    pose[0, 3] = 0.1
    points = np.array([[0.0, 0.0, 2.0], [0.0, 0.0, -2.0], [9.0, 0.0, 2.0]])
    pixels = seen_at(CAMERA, pose, points)
    assert pixels[0] == pytest.approx([47.5 + 80 * 0.05, 35.5])
    assert np.isnan(pixels[1:]).all()
