"""Maxima by ascent, their patches, and tracks of those that last."""

import numpy as np

from ipcli.models.saliency import proto_objects

GRID = (40, 50)


def hills(*places):
    rows, columns = np.indices(GRID)
    return sum(h * np.exp(-((rows - r) ** 2 + (columns - c) ** 2) / 30) for r, c, h in places)


def plane():
    rows, columns = np.indices(GRID)
    return np.stack([0.05 * columns, 0.05 * rows, np.full(GRID, 2.0)], axis=-1).reshape(-1, 3)


def test_ascent_leads_to_the_summit_of_each_hill_and_leaves_the_unknown_alone():
    field = hills((10, 10, 1.0), (28, 38, 2.0))
    field[0, 0] = np.nan
    top = proto_objects.summits(field)
    assert top[0] == -1
    assert top[12 * 50 + 9] == 10 * 50 + 10
    assert top[25 * 50 + 40] == 28 * 50 + 38


def test_the_highest_come_first_apart_from_each_other_with_patches_of_their_radius():
    energy = hills((10, 10, 1.0), (28, 38, 2.0), (28, 44, 1.9)).ravel()
    place = np.arange(energy.size)
    found = proto_objects.find(energy, plane(), place, GRID, 0.3, 5)
    assert [item.node for item in found][1] == 10 * 50 + 10
    assert abs(found[0].node % 50 - 39) <= 3
    assert len(found) == 2  # the third hill is within two radii of the first
    assert np.linalg.norm(plane()[found[1].patch] - plane()[found[1].node], axis=1).max() < 0.3


def test_nothing_arises_where_there_is_no_energy():
    assert proto_objects.find(np.zeros(2000), plane(), np.arange(2000), GRID, 0.3, 5) == []


def test_what_comes_back_to_a_place_is_of_one_track():
    points = np.array([[0.0, 0, 0], [1.0, 0, 0], [0.1, 0, 0], [1.05, 0, 0], [3.0, 0, 0]])
    assert proto_objects.lasting(points, np.array([0, 0, 1, 2, 2]), 0.3).tolist() == [0, 1, 0, 1, 2]
