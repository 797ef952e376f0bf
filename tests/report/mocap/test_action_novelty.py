"""The figures of none of these are those of the scores, and the page holds them."""

import numpy as np
import pytest

from ipcli import schema
from ipcli.report.mocap import action_novelty
from tests.fixtures.pages import ESCAPED, HOSTILE, sound
from tests.fixtures.report_artefacts import texts


def arrays():
    """Two actions left out of three; of the third nobody was asked without it."""
    levels = np.linspace(0, 1, 5)
    return {
        "people": np.array("test on dan"),
        "left_out": texts("kick", "wave", "bow"),
        "threshold": np.array(2.0),
        "lost": np.array([0.5, 0.0, np.nan]),
        "caught": np.array([0.5, 1.0, np.nan]),
        "area": np.array([0.8, 1.0, np.nan]),
        "surprise_area": np.array([0.6, 0.7, np.nan]),
        "levels": levels,
        "curve": np.sqrt(levels),
        "surprise_curve": levels,
        "query_left_out": np.array([0, 0, 0, 0, 0, 1, 1, 1, 1, 1]),
        "clips": np.array([f"clip {n}" for n in range(10)]),
        "truth": texts("kick", "kick", "wave", "wave", "bow", "kick", "wave", "wave", "bow", "bow"),
        "best": texts(*["bow"] * 10),
        "posterior": np.full(10, 0.5),
        "novelty": np.array([3.0, 1.0, 0.0, 2.5, 0.5, 0.0, 5.0, np.nan, 1.0, 2.0]),
        "surprise": np.arange(10.0),
    }


@pytest.mark.parametrize("known", [True, False])
def test_the_page_says_what_is_caught_and_lost_if_that_is_known(provenance, known):
    told = arrays() if known else arrays() | {name: np.full(3, np.nan) for name in ("lost", "caught", "area")}
    schema.validate(schema.kind("action-novelty"), told)
    html = action_novelty.page(told, provenance)
    sound(html)
    assert ESCAPED in html
    assert HOSTILE not in html
    assert ("75\N{NO-BREAK SPACE}% of the clips of an action" in html) == known
    assert ("25\N{NO-BREAK SPACE}% of the others were lost" in html) == known
    assert "Taken for" in html
