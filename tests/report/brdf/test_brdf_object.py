"""What the page of an object warns of."""

import numpy as np
import pytest

from ipcli.report.brdf import brdf_object

SOUND = {"tie": np.array(0.5), "sheet": np.array(0.0), "saturated": np.array(0.0), "residual": np.array(0.02)}


def test_a_sound_object_warns_of_nothing():
    assert brdf_object.warnings(SOUND) == []


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("tie", 0.01, "convex from concave"),
        ("sheet", 0.5, "rim or a cut edge"),
        ("saturated", 0.1, "saturated"),
        ("residual", 0.3, "poorly"),
    ],
)
def test_each_doubt_is_told(key, value, words):
    (only,) = brdf_object.warnings(SOUND | {key: np.array(value)})
    assert words in only


def test_a_tie_that_was_not_looked_for_is_none():
    assert brdf_object.warnings(SOUND | {"tie": np.array(np.nan)}) == []
