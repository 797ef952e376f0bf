"""The page of a walk, with gaze and without."""

import re

import numpy as np
import pytest

from ipcli.report.gaze.gaze_experiment import page
from tests.fixtures import search
from tests.fixtures.pages import Balance

GAZE = ("gaze/", "por/", "shown/", "fixations/")


@pytest.fixture(scope="module")
def walk():
    return search.experiment(12)


@pytest.fixture(scope="module")
def blind(walk):
    """The same walk as it is without gaze: no scores, since the head did not move, and nothing looked at."""
    a = {name: array for name, array in walk.items() if not name.startswith(GAZE)}
    nothing = np.full(len(a["times"]), np.nan)
    return a | dict.fromkeys(("gric_f", "gric_h", "change", "parted"), nothing) | {"notes": np.array(["no gaze"])}


def titles(html):
    return re.findall(r"<h2>(.*?)</h2>", html)


def test_a_page_with_gaze_has_the_sections_of_attention(walk):
    score = np.linspace(100, 200, len(walk["times"]))
    known = {
        "gric_f": score,
        "gric_h": 2 * score,
        "parted": score / 100,
        "offset_blocks": np.array([0.25, np.nan, 0.5]),
    }
    begun = {"how": walk["how"].copy(), "error": np.full(len(score), 0.5)}
    begun["how"][0], begun["error"][0] = "first", 90.0  # it begins the map: its error says nothing
    html = page(walk | known | begun, {})
    Balance(html)
    assert {"What was looked at", "Keyframes", "Coherent subsequences"} <= set(titles(html))
    for words in ("median place x, y, z, m", "0.25, 0.5\N{NO-BREAK SPACE}px", "2 coherent subsequences."):
        assert words in html
    drawn = html.partition("Reprojection error")[2].partition("</svg>")[0]
    assert all(float(tick) < 1 for tick in re.findall(r"text-anchor=\"end\">([0-9.]+)<", drawn))


def test_without_gaze_no_section_plot_or_column_is_empty(blind):
    unknown = np.array(np.nan)
    one = {name: blind[name][:1] for name in blind if name.startswith("subsequences/")}
    nothing = {"offset_estimate": unknown, "offset_blocks": np.full(4, np.nan), "offset_error": unknown}
    html = page(blind | one | nothing, {})
    Balance(html)
    assert "Keyframes" not in titles(html)
    for words in (
        "median place",
        "extent, m",
        "Change of gaze",
        "points of regard",
        "focus of attention",
        "—",
        "in contiguous parts",
    ):
        assert words not in html
    assert "1 coherent subsequence." in html


@pytest.mark.parametrize("known", [True, False])
def test_errors_of_what_was_looked_at_are_told_where_its_place_is_known(walk, known):
    regarded = {
        "accuracy/labels": np.array(["cup"]),
        "accuracy/regards": np.array([7]),
        "accuracy/dwell": np.array([0.5]),
        "accuracy/rms": np.array([0.04 if known else np.nan]),
        "accuracy/inside": np.array([[0.7, 0.9] if known else [np.nan, np.nan]]),
    }
    html = page(walk | regarded, {})
    Balance(html)
    assert "time on it, s" in html
    assert ("truth in 68 % region" in html) == known
    assert ("regions are honest" in html) == known
