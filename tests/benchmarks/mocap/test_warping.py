"""Dynamic time warping: the path is the cheapest of all, and the nearest of curves is that of a plain search."""

from itertools import pairwise

import numpy as np
import pytest

from benchmarks.mocap import warping


def test_the_path_is_the_cheapest_of_all():
    cost = np.random.default_rng(2).uniform(size=(5, 4))

    def least(i, j):
        if i < 0 or j < 0:
            return np.inf
        if i == j == 0:
            return cost[0, 0]
        return cost[i, j] + min(least(i - 1, j), least(i, j - 1), least(i - 1, j - 1))

    path = warping.warping_path(cost)
    assert path[0].tolist() == [0, 0]
    assert path[-1].tolist() == [4, 3]
    assert all(tuple(step) in {(0, 1), (1, 0), (1, 1)} for step in np.diff(path, axis=0))
    assert cost[tuple(path.T)].sum() == pytest.approx(least(4, 3))
    assert all((a != b).any() for a, b in pairwise(path))


def test_what_a_path_matches_is_averaged():
    path, curve = np.array([[0, 0], [1, 0], [2, 1], [2, 2]]), np.array([[1.0], [3.0], [7.0]])
    assert warping.mean_along(path, curve, 3).tolist() == [[2.0], [7.0], [7.0]]


def plain_distance(a, b):
    square = ((a[:, None] - b[None]) ** 2).sum(axis=2)
    return square[tuple(warping.warping_path(square).T)].sum()


@pytest.mark.parametrize("normalised", [False, True])
def test_the_nearest_curve_is_that_of_a_plain_search(normalised):
    rng = np.random.default_rng(4)
    known, asked = ([rng.normal(size=(n, 2)).cumsum(axis=0) for n in lengths] for lengths in ((1, 9, 4, 6), (5, 1, 12)))
    rows = [np.cumsum([0, *map(len, curves)]) for curves in (known, asked)]
    found = warping.nearest(np.concatenate(asked), rows[1], np.concatenate(known), rows[0], 1.0, normalised)
    for one, answer in zip(asked, found, strict=True):
        units = [max(len(one), len(other)) if normalised else 1 for other in known]
        assert answer == np.argmin([plain_distance(one, b) / unit for b, unit in zip(known, units, strict=True)])


def test_a_narrow_window_forbids_what_a_wide_one_allows():
    a, b = np.zeros((20, 1)), np.zeros((20, 1))
    a[2], b[15] = 1.0, 1.0
    assert warping.warped_distance(a, b, 1.0, np.inf) == 0.0
    assert warping.warped_distance(a, b, 0.1, np.inf) == 2.0
    assert warping.warped_distance(a, b, 0.1, 1.5) == np.inf
