from __future__ import annotations

import re
from xml.etree import ElementTree

import numpy as np
import pytest

from ipcli.report.kit.curves import BOTTOM, LEFT, RIGHT, TOP, Series, plot

WIDTH, HEIGHT = 560, 300


def drawn(svg: str) -> ElementTree.Element:
    return ElementTree.fromstring(svg)


def labels(svg: str, anchor: str) -> list[tuple[str, float]]:
    """Texts of one axis and where they stand along it."""
    coordinate = "x" if anchor == "middle" else "y"
    found = [
        node for node in drawn(svg).iter("text") if node.get("class") == "tick" and node.get("text-anchor") == anchor
    ]
    return [(node.text.replace("\N{MINUS SIGN}", "-"), float(node.get(coordinate))) for node in found]


def vertices(svg: str) -> list[np.ndarray]:
    """The pieces of the first line as arrays (n, 2) of pixels."""
    path = next(node.get("d") for node in drawn(svg).iter("path") if "line s0" in node.get("class"))
    return [np.array([pair.split() for pair in piece.split("L")], float) for piece in re.findall(r"M([^M]+)", path)]


@pytest.mark.parametrize("log", [False, True])
def test_ticks_stand_where_the_line_passes_their_value(log):
    y = np.geomspace(0.002, 70, 40) if log else np.linspace(-3, 12, 40)
    svg = plot([Series("a", np.arange(40), y)], "t", "x", "y", log_y=log)
    (line,) = vertices(svg)
    found = labels(svg, "end")
    assert len(found) >= 3
    transform = np.log if log else np.asarray
    for text, at in found:
        if y[0] <= float(text) <= y[-1]:
            along = np.interp(transform(float(text)), transform(y), np.arange(40))
            assert np.interp(along, np.arange(40), line[:, 1]) == pytest.approx(at, abs=0.6)


def test_the_line_spans_the_axes():
    (line,) = vertices(plot([Series("a", np.arange(5), np.array([0, 3, 1, 4, 2.0]))], "t", "x", "y"))
    assert line[0, 0] == 0
    assert line[-1, 0] == WIDTH - LEFT - RIGHT
    assert (line[:, 1] >= 0).all()
    assert (line[:, 1] <= HEIGHT - TOP - BOTTOM).all()
    assert line[:, 1].argmin() == 3


def test_values_without_a_place_break_the_line():
    y = np.array([1, 2, np.nan, 3, 4, 0, 5, 6.0])
    assert [len(piece) for piece in vertices(plot([Series("a", np.arange(8), y)], "t", "x", "y", log_y=True))] == [
        2,
        2,
        2,
    ]


def test_large_numbers_give_their_power_to_the_label():
    svg = plot([Series("a", np.arange(3), np.array([1.1e5, 1.3e5, 1.6e5]))], "t", "x", "energy")
    assert "energy, 10⁵" in svg
    assert all(0.5 < float(text) < 2 for text, _ in labels(svg, "end"))


@pytest.mark.parametrize(
    "y", [np.empty(0), np.full(4, np.nan), np.ones(4), np.array([5.0]), np.zeros(3), np.array([-1.0, -2.0])]
)
@pytest.mark.parametrize("log", [False, True])
def test_degenerate_lines_still_make_a_plot(y, log):
    svg = plot(
        [Series("<a>", np.arange(len(y)), y), Series("b", np.arange(len(y)), y)], "a < b", "x & y", "y", log_y=log
    )
    assert "nan" not in svg
    assert "inf" not in svg
    drawn(svg)


def test_a_ring_stands_at_its_place_and_the_axes_reach_it():
    svg = plot([Series("a", np.array([1.0, 2, 4]), np.array([3.0, 1, 2]), ring=(8.0, 5.0))], "t", "x", "y", log_x=True)
    ring = next(node for node in drawn(svg).iter("circle") if node.get("r") == "6")
    (line,) = vertices(svg)
    assert float(ring.get("cx")) == pytest.approx(line[1, 0] * 3, abs=0.2)
    assert 0 <= float(ring.get("cy")) < line[:, 1].min()


def test_a_long_legend_goes_on_in_a_second_row_within_the_plot():
    names = ["median", "rof-median", "tgv-l1", "l1-heuristic", "l1-adapt (acs)", "adapt-hprior"]
    svg = plot([Series(name, np.arange(3), np.arange(3)) for name in names], "t", "x", "y", width=470)
    found = [node for node in drawn(svg).iter("text") if node.text in names]
    assert len({node.get("y") for node in found}) == 2
    assert max(float(node.get("x")) for node in found) < 470 - 60
