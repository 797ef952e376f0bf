"""What is asked about has the frames, times and labels it should; windows of one answer make segments."""

from dataclasses import replace

import numpy as np
import pytest

from ipcli.models.mocap import queries
from ipcli.models.mocap.motions import Motions
from tests.fixtures.mocap_bodies import GROUPS
from tests.fixtures.mocap_clips import clip, take


@pytest.fixture(scope="module")
def known():
    """A clip of 24 frames, and a take of 135 with labels frame by frame; 30 Hz."""
    return Motions((clip("kick", 0), take()), GROUPS)


def test_whole_clips_have_all_their_frames(known):
    found = queries.whole_clips(known)
    assert np.bincount(found.query).tolist() == [24, 135]
    np.testing.assert_array_equal(found.rows, np.arange(159))
    np.testing.assert_allclose(found.times, [[0, 0.8], [0, 4.5]])


def test_unordered_frames_are_of_their_clip_each_at_most_once_and_drawn_anew(known):
    found = queries.unordered_frames(known, 5, 3, seed=0)
    assert found.clip.tolist() == [0, 1] * 3
    for n, index in enumerate(found.clip):
        rows = found.rows[found.query == n]
        assert len({*rows}) == len(rows) == 5
        assert (known.clip[rows] == index).all()
    assert {*found.rows[found.query == 1]} != {*found.rows[found.query == 3]}
    again = queries.unordered_frames(known, 5, 3, seed=0)
    np.testing.assert_array_equal(again.rows, found.rows)
    assert (np.bincount(queries.unordered_frames(known, 100, 1, seed=0).query) == [24, 100]).all()


def test_windows_overlap_and_the_last_ends_where_its_clip_ends(known):
    found = queries.windows(known, 1.0, 0.5)
    assert found.clip.tolist() == [0] + [1] * 8
    np.testing.assert_allclose(found.times[0], [0, 0.8])
    np.testing.assert_allclose(found.times[1:, 0], np.arange(8) / 2)
    for n, (start, end) in enumerate(found.times):
        first = 24 * found.clip[n] + round(30 * start)
        np.testing.assert_array_equal(found.rows[found.query == n], np.arange(first, first + round(30 * (end - start))))


def test_a_query_has_the_label_of_most_of_its_frames(known):
    found = queries.query_labels(known, queries.windows(known, 1.0, 0.5))
    assert found["truth"].tolist() == ["kick", "wave", "wave", "kick", "kick", "kick", "bow", "bow", "bow"]
    nameless = Motions((replace(clip("kick", 0), label=""),), GROUPS)
    assert queries.query_labels(nameless, queries.whole_clips(nameless)) == {}


def test_windows_of_one_answer_are_one_segment_that_ends_half_way_to_the_next(known):
    asked = queries.windows(known, 1.0, 0.5)
    answers = np.array(["none", *["wave"] * 3, *["kick"] * 2, *["bow"] * 3])
    posterior = np.tile([0.7, 0.2, 0.1], (9, 1))
    posterior[1:4, 0] = [0.8, 0.9, 1.0]
    posterior[1:4, 1] = [0.2, 0.1, 0.0]
    posterior[1:4, 2] = 0
    told = {
        "answers": answers,
        "posterior": posterior,
        "novelty": np.arange(9.0),
        "actions": np.array(["wave", "kick", "bow"]),
    }
    found = queries.segments(known, told, asked)
    assert found["segment_clip"].tolist() == [known.clips[0].name, *["take"] * 3]
    assert found["segment_answer"].tolist() == ["none", "wave", "kick", "bow"]
    np.testing.assert_allclose(found["segment_time"], [[0, 0.8], [0, 1.75], [1.75, 2.75], [2.75, 4.5]])
    assert found["segment_best"].tolist() == ["wave"] * 4
    np.testing.assert_allclose(found["segment_posterior"], [0.7, 0.9, 0.7, 0.7])  # of the likeliest, also of none
    np.testing.assert_allclose(found["segment_novelty"], [0, 2, 4.5, 7])
    assert found["truth_segment_answer"].tolist() == ["wave", "kick", "bow"]
    np.testing.assert_allclose(found["truth_segment_time"], [[0, 1.5], [1.5, 3], [3, 4.5]])


@pytest.mark.parametrize(
    ("values", "expected"),
    [("", []), ("a", [(0, 1)]), ("aab", [(0, 2), (2, 3)]), ("aba", [(0, 1), (1, 2), (2, 3)])],
)
def test_runs_are_equal_values_in_a_row(values, expected):
    assert queries.runs(np.array(list(values), np.str_)) == expected
