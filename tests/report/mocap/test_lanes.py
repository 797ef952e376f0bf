"""Segments stand in the lane of their class at their time."""

from __future__ import annotations

from xml.etree import ElementTree

import pytest

from ipcli.report.mocap.lanes import LANE, Segment, lanes

NAMES = ["kick", "squat & rise"]


def bars(svg, name):
    return [node for node in ElementTree.fromstring(svg).iter("rect") if node.get("class") == name]


def test_a_bar_is_as_long_as_its_time_in_the_lane_of_its_name():
    found = [Segment(0, 2, "kick"), Segment(2, 3, "squat & rise", 0.5), Segment(3, 3.5, "none")]
    svg = lanes(found, [Segment(0, 1, "kick"), Segment(9, 10, "kick")], NAMES, "take")
    first, second = bars(svg, "hit")  # "none" has no lane
    scale = float(first.get("width")) / 2
    assert float(second.get("width")) == pytest.approx(scale, abs=0.11)
    assert float(second.get("x")) - float(first.get("x")) == pytest.approx(2 * scale, abs=0.11)
    assert float(second.get("y")) - float(first.get("y")) == LANE
    assert float(first.get("fill-opacity")) == 1 > float(second.get("fill-opacity"))
    last = bars(svg, "true")[1]
    ends = float(last.get("x")) + float(last.get("width"))
    view = float(ElementTree.fromstring(svg).get("viewBox").split()[2])
    assert ends - float(first.get("x")) == pytest.approx(10 * scale, abs=0.3)
    assert ends < view
    assert "squat &amp; rise, 2 s to 3 s, 50 %" in svg


def test_nothing_found_is_an_empty_axis():
    svg = lanes([], [], NAMES, "take")
    assert not bars(svg, "hit")
    assert "nan" not in svg
