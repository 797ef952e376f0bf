"""What the page of an object warns of."""

import numpy as np
import pytest

from ipcli.report.brdf import brdf_object

MASK = np.pad(np.ones((4, 5), np.uint8), 1)
SOUND = {"tie": np.array(0.5), "sheet": np.array(0.0), "saturated": np.array(0.0), "residual": np.array(0.02)}
SOUND |= {"intensity": np.where(MASK > 0, np.linspace(0.5, 1, 7), np.nan).astype(np.float32)}
SOUND |= {"mask": MASK, "materials": np.array(["brass", "steel"])}


def test_a_sound_object_warns_of_nothing():
    assert brdf_object.warnings(SOUND) == []


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("tie", 0.01, "convex from concave"),
        ("sheet", 0.5, "rim or a cut edge"),
        ("saturated", 0.1, "of the object is saturated; a shorter exposure"),
        ("saturated", 0.5, "hardly tells its shape"),
        ("intensity", np.where(MASK > 0, 1.0, np.nan), "one brightness all over"),
        ("residual", 0.3, "poorly (residual 0.3)"),
        ("residual", 0.3, "likeliest of the 2 of the library"),
        ("mask", MASK[:, 1:], "runs along 4 pixels of the picture's border"),
    ],
)
def test_each_doubt_is_told(key, value, words):
    (only,) = brdf_object.warnings(SOUND | {key: np.array(value)})
    assert words in only


def test_a_tie_that_was_not_looked_for_is_none():
    assert brdf_object.warnings(SOUND | {"tie": np.array(np.nan)}) == []


def test_a_burnt_or_flat_picture_is_told_on_the_console_too():
    for key, value in (("saturated", 0.5), ("intensity", np.where(MASK > 0, 1.0, np.nan))):
        assert len(brdf_object.doubts(SOUND | {key: np.array(value)})) == 1
    assert brdf_object.doubts(SOUND | {"saturated": np.array(0.1)}) == []


def test_the_headline_does_not_decide_what_is_open():
    assert "is taken for an occluding rim" in brdf_object.outline(SOUND)
    assert "is taken for a cut edge" in brdf_object.outline(SOUND | {"sheet": np.array(1.0)})
    assert "may be an occluding rim or a cut edge" in brdf_object.outline(SOUND | {"sheet": np.array(0.55)})


def test_what_is_unusual_is_for_the_console_too_and_a_tie_is_not():
    odd = SOUND | {"tie": np.array(0.0), "residual": np.array(0.3)}
    assert len(brdf_object.doubts(odd)) == 1
    assert brdf_object.warnings(odd)[1:] == brdf_object.doubts(odd)
