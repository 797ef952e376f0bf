"""The figures of none of these are those of the scores, and the page holds them."""

import numpy as np
import pytest

from ipcli import schema
from ipcli.report.mocap import action_novelty
from tests.fixtures.pages import ESCAPED, HOSTILE, sound
from tests.fixtures.report_artefacts import texts


def arrays():
    """Two actions left out of three; of the third nobody was asked without it."""
    truth = texts("kick", "kick", "wave", "wave", "bow", "kick", "wave", "wave", "bow", "bow")
    left = np.array([0, 0, 0, 0, 0, 1, 1, 1, 1, 1])
    return {
        "people": np.array("test on dan"),
        "left_out": texts("kick", "wave", "bow"),
        "threshold": np.array([2.0, 2.0, 2.0]),
        "surprise_threshold": np.array([9.0, 9.0, 9.0]),
        "query_left_out": left,
        "clips": np.array([f"clip {n}" for n in range(10)]),
        "truth": truth,
        "best": texts(*["bow"] * 10),
        "posterior": np.full(10, 0.5),
        "novelty": np.array([3.0, 1.0, 0.0, 2.5, 0.5, 0.0, 5.0, np.nan, 1.0, 2.0]),
        "surprise": np.arange(10.0),
    }


def test_an_area_is_the_share_of_pairs_in_order():
    assert action_novelty.area(np.array([1.0, 2.0]), np.array([2.0, 3.0])) == 3.5 / 4
    assert np.isnan(action_novelty.area(np.empty(0), np.ones(1)))
    found = action_novelty.areas(arrays())
    assert found[0] == 5 / 6
    assert found[1] == 1.0
    assert np.isnan(found[2])


def test_lost_and_caught_are_what_is_above_the_threshold():
    """A clip without a frame that tells is none."""
    found = action_novelty.shares(arrays())
    np.testing.assert_allclose(found[:2], [[1 / 3, 1 / 2], [0.0, 1.0]])
    assert np.isnan(found[2]).all()


def test_the_curve_is_monotone_and_passes_through_what_a_threshold_gives():
    found = action_novelty.curve(arrays())
    assert (np.diff(found) >= 0).all()
    assert found[0] == (0.5 + 1.0) / 2  # nothing lost: the threshold at the most novel of the known
    assert found[-1] == 1.0


@pytest.mark.parametrize("caught", [True, False])
def test_the_page_is_sound(provenance, caught):
    told = arrays()
    told["novelty"] = told["novelty"] if caught else np.zeros(10)
    schema.validate(schema.kind("action-novelty"), told)
    html = action_novelty.page(told, provenance)
    sound(html)
    assert ESCAPED in html
    assert HOSTILE not in html
    assert ("75\N{NO-BREAK SPACE}% of the clips of an action" in html) == caught
