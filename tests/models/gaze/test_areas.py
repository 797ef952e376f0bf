"""Distances from areas of interest, and dwell, visits and transitions of a gaze that is known."""

import numpy as np
import pytest

from ipcli.measurements.recording import Areas
from ipcli.models.gaze import areas

BOX = np.array([[0.0, 0, 0], [1, 1, 1]])
L_SHAPE = np.array([[0.0, 0, 2], [2, 0, 2], [2, 1, 2], [1, 1, 2], [1, 2, 2], [0, 2, 2]])


def test_distances_from_a_box_a_polygon_with_a_notch_and_a_cloud():
    shapes = Areas(("box", "corner", "cloud"), {0: BOX}, {1: L_SHAPE}, {2: np.array([[5.0, 0, 0], [6, 0, 0]])})
    points = np.array([[0.5, 0.5, 0.5], [1.5, 1.5, 2.3], [0.5, 1.5, 2.3], [6, 3, 4], [np.nan, 0, 0]])
    found = areas.distances(points, shapes)
    assert found[0, 0] == 0
    assert found[3, 0] == pytest.approx(np.sqrt(25 + 4 + 9))
    assert found[1, 1] == pytest.approx(np.hypot(0.5, 0.3))  # in the notch: from the edge
    assert found[2, 1] == pytest.approx(0.3)  # above the inside: from the plane
    assert found[3, 2] == pytest.approx(5)
    assert np.isnan(found[4]).all()


def test_a_point_belongs_to_the_nearest_area_within_the_margin():
    shapes = Areas(("a", "b"), {0: BOX, 1: BOX + [1.1, 0, 0]})
    points = np.array([[1.04, 0.5, 0.5], [1.07, 0.5, 0.5], [0.5, 0.5, 1.2], [np.nan] * 3])
    assert areas.area_of(points, shapes, 0.1).tolist() == [0, 1, -1, -1]


def test_dwell_visits_first_look_and_transitions():
    shapes = Areas(("a", "b", "never"), {0: BOX, 1: BOX + [3, 0, 0], 2: BOX + [9, 0, 0]})
    inside, other, away = [0.5] * 3, [3.5, 0.5, 0.5], [0.5, 5, 5]
    blink = [np.nan] * 3
    looks = [away, *[inside] * 4, blink, *[inside] * 3, away, *[other] * 5, *[away] * 5, *[other] * 2, *[inside] * 3]
    times = 0.05 * np.arange(len(looks))
    fixation = np.array([-1, *[0] * 8, -1, *[1] * 5, *[2] * 5, *[-1] * 5])
    a = areas.attention(times, np.array(looks), fixation, shapes, 0.05)
    assert a["aoi/dwell"] == pytest.approx([0.05 * 10, 0.05 * 7, 0])
    assert a["aoi/share"] == pytest.approx([10 / 24, 7 / 24, 0])
    assert a["aoi/visits"].tolist() == [2, 2, 0]  # the blink ends none; a quarter of a second elsewhere does
    assert a["aoi/fixations"].tolist() == [1, 1, 0]
    assert a["aoi/first"][:2] == pytest.approx([0.05, 0.5])
    assert np.isnan(a["aoi/first"][2])
    assert a["aoi/transitions"].tolist() == [[0, 1, 0], [1, 0, 0], [0, 0, 0]]
