"""Confusions are shaded by their share of the row, and no more is written than was counted."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest

from ipcli.report.mocap.confusion import CELL, PANEL, histogram, matrix

NAMES = ["kick", "<squat>", "walk"]
COUNTS = np.array([[8, 2, 0], [0, 5, 0], [0, 0, 0]])


def nodes(svg, tag, name):
    return [node for node in ElementTree.fromstring(svg).iter(tag) if name in (node.get("class") or "").split()]


def test_each_cell_has_its_percentage_where_row_and_column_meet():
    svg = matrix(COUNTS, NAMES, NAMES, "frames")
    texts = nodes(svg, "text", "inside")
    assert [node.text for node in texts] == ["80", "20", "100"]
    x, y = (np.array([float(node.get(axis)) for node in texts]) for axis in "xy")
    np.testing.assert_allclose(np.diff(x), [CELL, 0], atol=0.01)
    np.testing.assert_allclose(np.diff(y), [0, CELL], atol=0.01)
    shades = [float(node.get("fill-opacity")) for name in ("hit", "miss") for node in nodes(svg, "rect", name)]
    np.testing.assert_allclose(shades, [0.12 + 0.88 * share for share in (0.8, 1, 0.2)], atol=0.006)
    assert "n = 10" in svg
    assert "n = 0" in svg
    assert "&lt;squat&gt;" in svg


def test_all_but_one_is_not_all():
    assert [node.text for node in nodes(matrix(np.array([[9999, 1]]), ["a"], ["a", "b"], ""), "text", "inside")] == [
        "99.9"
    ]


def test_answers_that_are_no_class_get_a_column():
    svg = matrix(np.array([[6, 0, 4]]), ["a"], ["a", "b", "none"], "")
    assert [node.text for node in nodes(svg, "text", "inside")] == ["60", "40"]
    assert len(nodes(svg, "rect", "cell")) == 3


@pytest.mark.parametrize(("counts", "names"), [(np.zeros((0, 0), int), []), (np.zeros((2, 2), int), ["a", "b"])])
def test_without_answers_there_is_an_empty_matrix(counts, names):
    svg = matrix(counts, names, names, "")
    assert not nodes(svg, "text", "inside")
    assert "nan" not in svg


def test_a_bar_is_as_tall_as_its_share_and_the_true_one_stands_out():
    svg = histogram(np.array([3, 1, 0]), NAMES, "kick")
    heights = [float(node.get("height")) for node in ElementTree.fromstring(svg).iter("rect")]
    np.testing.assert_allclose(heights, [0.75 * PANEL, 0.25 * PANEL, 0], atol=0.06)
    assert len(nodes(svg, "rect", "hit")) == 1
    assert len(nodes(svg, "rect", "miss")) == 2
    assert "nan" not in histogram(np.zeros(3, int), NAMES, "walk")
