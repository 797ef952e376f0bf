"""The figures of none of these are those of the scores."""

import numpy as np

from ipcli.models.mocap import open_set


def answers():
    """Two actions left out of three; of the third nobody was asked without it."""
    return {
        "left_out": np.array(["kick", "wave", "bow"]),
        "threshold": np.array(2.0),
        "query_left_out": np.array([0, 0, 0, 0, 0, 1, 1, 1, 1, 1]),
        "truth": np.array(["kick", "kick", "wave", "wave", "bow", "kick", "wave", "wave", "bow", "bow"]),
        "novelty": np.array([3.0, 1.0, 0.0, 2.5, 0.5, 0.0, 5.0, np.nan, 1.0, 2.0]),
        "surprise": np.arange(10.0),
    }


def test_an_area_is_the_share_of_pairs_in_order():
    assert open_set.area(np.array([1.0, 2.0]), np.array([2.0, 3.0])) == 3.5 / 4
    assert np.isnan(open_set.area(np.empty(0), np.ones(1)))
    found = open_set.figures(answers())
    assert found["area"][:2].tolist() == [5 / 6, 1.0]
    assert found["surprise_area"][:2].tolist() == [0.0, 1 / 3]
    assert np.isnan([found["area"][2], found["surprise_area"][2]]).all()


def test_lost_and_caught_are_what_is_above_the_threshold():
    """A clip without a frame that tells is none."""
    found = open_set.figures(answers())
    np.testing.assert_allclose(found["lost"], [1 / 3, 0.0, np.nan])
    np.testing.assert_allclose(found["caught"], [1 / 2, 1.0, np.nan])


def test_the_curve_is_monotone_and_passes_through_what_a_threshold_gives():
    found = open_set.figures(answers())["curve"]
    assert (np.diff(found) >= 0).all()
    assert found[0] == (0.5 + 1.0) / 2  # nothing lost: the threshold at the most novel of the known
    assert found[-1] == 1.0
    assert np.isnan(open_set.mean_curve([(np.empty(0), np.ones(1))])).all()
