"""The page of the demo: one card a command, what the command's own page says, links that lead somewhere."""

import tomllib
from pathlib import Path

import numpy as np
import pytest

from ipcli.errors import FormatError
from ipcli.report.kit.page import Markup, element
from tests.fixtures.maker import Maker
from tools import make_index
from tools.make_index import Card

ROOT = Path(__file__).parents[2]
CARD = Card("do-it", "What is it?", "a.views", "views", lambda arrays: np.zeros((4, 6, 3), np.uint8), "A <thing>")


@pytest.fixture
def folder(tmp_path):
    maker = Maker(tmp_path)
    maker()
    (maker.output.parent / "a.views.html").write_text('<h1>x</h1><p class="verdict">3 &lt; 4, <b>surely</b>.</p>')
    return maker.output.parent


def test_the_eight_commands_each_have_a_card_of_what_the_demo_makes():
    scripts = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["scripts"]
    assert {card.command for card in make_index.CARDS} == set(scripts) - {"ipcli"}
    makefile = (ROOT / "Makefile").read_text()
    for card in make_index.CARDS:
        assert f"-o $(DEMO)/{card.stem}." in makefile


def test_a_card_shows_the_picture_and_what_the_page_says_and_leads_to_it(folder):
    card = make_index.card_of(CARD, folder)
    assert "data:image/jpeg;base64," in card
    assert "A &lt;thing&gt;" in card
    assert "3 &lt; 4, surely." in card
    assert 'href="a.views.html"' in card


def test_pages_to_be_turned_are_linked_where_they_are(folder):
    card = Card(**{**vars(CARD), "turns": (("turn", "to be turned"), ("gone", "not there"))})
    (folder / "a.views.turn.html").write_text("")
    assert 'href="a.views.turn.html"' in make_index.links(card, folder)
    assert "not there" not in make_index.links(card, folder)


def test_a_drawing_is_taken_as_it_is():
    assert "<svg></svg>" in make_index.shown(element("svg"), "words")
    assert "&lt;" not in make_index.shown(Markup("<svg></svg>"), "words")


def test_a_demo_that_has_not_run_is_a_format_error(tmp_path):
    with pytest.raises(FormatError):
        make_index.index(tmp_path)
