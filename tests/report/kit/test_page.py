"""Elements of pages: escaped, closed, read back by the standard library's parser as what went into them."""

from __future__ import annotations

from html.parser import HTMLParser

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipcli.report.kit import page
from ipcli.report.kit.pictures import OPENCV, Scale, photograph
from tests.fixtures.pages import HOSTILE, decoded, sound

TEXT = st.text(st.characters(codec="utf-8", exclude_characters="\r\0"), max_size=20)


class Reader(HTMLParser):
    """What a browser is told: text and attributes with their escapes undone."""

    def __init__(self, html):
        super().__init__()
        self.text, self.attributes, self.tags = "", [], []
        self.feed(html)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += attrs

    def handle_data(self, data):
        self.text += data


@given(TEXT, TEXT)
def test_text_and_attributes_come_back_whatever_is_in_them(text, value):
    read = Reader(page.element("p", text, title=value))
    assert read.tags == ["p"]
    assert read.text == text
    assert read.attributes == [("title", value)]


def test_what_is_markup_is_not_escaped_again():
    inner = page.element("b", HOSTILE)
    assert page.element("p", inner, HOSTILE) == f"<p>{inner}{page.join(HOSTILE)}</p>"
    assert "<script>" not in page.element("p", inner)
    assert isinstance(page.join(inner, 3), page.Markup)
    assert page.join(1, None, page.Markup("<br>")) == "1None<br>"


def test_names_of_attributes_and_elements_without_an_end():
    assert page.element("i", class_="a", aria_label="b", title=None, n=0) == '<i class="a" aria-label="b" n="0"></i>'
    assert page.element("img", src="x") == '<img src="x">'


def test_a_whole_page_is_sound_and_says_its_words_once():
    html = page.page(
        "T & t",
        "above",
        "verdict",
        page.section("First", page.notice("watch out"), lead="how to read"),
        page.section("Second", page.details("more", page.element("p", "inside"))),
    )
    found = Reader(html[html.index("<body") :])
    sound(html)
    for word in ("T & t", "above", "verdict", "First", "how to read", "Note: watch out", "Second", "more", "inside"):
        assert found.text.count(word) == 1, word
    assert html.startswith('<!doctype html>\n<html lang="en">')
    assert '<p class="lead">' not in page.section("No lead")


def test_a_table_has_names_in_its_first_column_and_marks_what_is_asked_for():
    html = page.table(["Name", "x"], [["a", 1], ["b", HOSTILE]], bold=[(1, 1)], warn={0: "odd & so"})
    read = Reader(html)
    assert read.tags.count("tr") == 3
    assert read.tags.count("td") == 2
    assert [value for name, value in read.attributes if name == "scope"] == ["col", "col", "row", "row"]
    assert ("title", "odd & so") in read.attributes
    assert html.count('class="warn"') == 1
    assert html.count("<strong>") == 1
    assert f"<strong>{page.join(HOSTILE)}</strong>" in html


@pytest.mark.parametrize(
    ("share", "width"), [(0.0, "0.0%"), (0.123, "12.3%"), (1.0, "100.0%"), (1.7, "100.0%"), (-1.0, "0.0%")]
)
def test_a_meter_is_filled_by_its_share(share, width):
    assert f"width:{width}" in page.meter(share, "x")


def test_a_meter_of_no_number_is_empty():
    html = page.meter(float("nan"), "—")
    assert "width" not in html
    assert "—" in html


def test_a_figure_shows_its_picture_whole_and_frames_a_part():
    image = np.random.default_rng(0).integers(0, 256, (5, 7, 3), dtype=np.uint8)
    picture = photograph(image)
    html = page.figure(picture, "a < b", "note", crisp=True, frame=(0.1, 0.2, 0.5, 0.25))
    found = sound(f"<html><body>{html}</body></html>")
    (shown,) = found.pictures
    assert (shown["width"], shown["height"], shown["class"], shown["alt"]) == ("7", "5", "crisp", "a < b")
    assert decoded(shown["src"]).shape == image.shape
    assert "left:10.00%;top:20.00%;width:50.00%;height:25.00%" in html
    assert 'class="frame"' not in page.figure(picture, "a")


def test_a_colour_bar_says_its_limits_and_its_unit():
    scale = Scale(0.0, 2.5, next(iter(OPENCV)), unit="m")
    read = Reader(page.bar(scale))
    assert read.text.startswith("0")
    assert "2.5" in read.text
    assert read.text.endswith("m")
    places = [float(value[5:-1]) for name, value in read.attributes if name == "style"]
    assert places == sorted(places)
    assert (places[0], places[-1]) == (0, 100)


@pytest.mark.parametrize("small", [False, True])
@given(aspect=st.floats(0.1, 10), count=st.integers(1, 20))
def test_at_least_two_go_side_by_side_wide_ones_fewer(small, aspect, count):
    found = page.columns_for(aspect, count, small=small)
    assert 2 <= found <= max(2, count)
    assert found >= page.columns_for(2 * aspect, count, small=small)
    assert found <= page.columns_for(aspect, count + 1, small=small)
    assert f"--columns:{found}" in page.gallery(page.Markup("<p></p>"), columns=found, small=small)


def test_the_link_to_the_page_beside_leads_to_its_file_or_is_mere_words():
    html = page.element("p", page.TURNED)
    assert page.with_turning_page(html, "a b<c.turn.html") == (
        '<p><a href="a%20b%3Cc.turn.html">a b&lt;c.turn.html</a></p>'
    )
    assert page.with_turning_page(html, None) == "<p>X.turn.html</p>"


def test_a_table_of_many_columns_is_set_closer_so_that_it_fits():
    names = [f"c{n}" for n in range(page.WIDE + 1)]
    assert 'class="scroll dense"' in page.table(names, [names])
    assert 'class="scroll"' in page.table(names[:-1], [names[:-1]])
