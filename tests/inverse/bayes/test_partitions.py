"""Distances between partitions, and the one that stands for many."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipcli.inverse.bayes import partitions
from ipcli.inverse.bayes.partitions import nearest, variation_of_information

LABELS = st.lists(st.integers(0, 4), min_size=8, max_size=8).map(lambda values: np.array(values, np.int32))


@given(LABELS, LABELS, LABELS)
def test_it_is_a_distance_whatever_the_labels_are_called(a, b, c):
    assert variation_of_information(a, b) == pytest.approx(variation_of_information(b, a), abs=1e-12)
    assert variation_of_information(a, 4 - a) == pytest.approx(0, abs=1e-12)
    through = variation_of_information(a, c) + variation_of_information(c, b)
    assert -1e-12 <= variation_of_information(a, b) <= through + 1e-12


def test_one_cluster_against_halves_is_one_bit_and_against_single_points_the_whole_entropy():
    whole = np.zeros(8, np.int32)
    assert variation_of_information(whole, np.repeat([0, 1], 4)) == pytest.approx(np.log(2))
    assert variation_of_information(whole, np.arange(8)) == pytest.approx(np.log(8))


def test_the_nearest_is_found_among_all_if_they_are_few():
    rows = np.array([[0, 0, 0, 0], [0, 0, 1, 1], [1, 1, 0, 0], [0, 1, 2, 3]], np.int32)
    assert nearest(rows) in (1, 2)  # the same partition by other labels


def test_of_many_rows_candidates_stand_for_all():
    rows = np.tile(np.repeat([0, 1], 5), (3 * partitions.CANDIDATES, 1)).astype(np.int32)
    rows[0] = 0
    found = nearest(rows)
    assert found > 0
    assert variation_of_information(rows[found], rows[-1]) == pytest.approx(0, abs=1e-12)
