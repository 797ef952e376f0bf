"""Errors are one line of what, where, expected, got and what to do; each kind has its exit code."""

import difflib
import inspect

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipcli import errors
from ipcli.errors import FormatError, IpcliError, NoSolution, OutputExists, OutputRefused, ParameterError, nearest

WORDS = st.text("abc", min_size=1, max_size=5)


@pytest.mark.parametrize(
    ("facts", "text"),
    [
        ({}, "a.h5: is cut"),
        ({"fix": "Copy it again"}, "a.h5: is cut. Copy it again"),
        ({"expected": 3}, "a.h5: is cut (expected 3)"),
        ({"got": 0, "fix": "Copy it again"}, "a.h5: is cut (got 0). Copy it again"),
        ({"expected": "", "got": False, "fix": ""}, "a.h5: is cut (expected , got False)"),
    ],
)
def test_a_format_error_says_where_what_expected_got_and_what_to_do(facts, text):
    assert str(FormatError("a.h5", "is cut", **facts)) == text


def test_a_question_is_not_ended_twice():
    assert str(FormatError("a", "no 'b'; did you mean 'c'?", fix="Look")) == "a: no 'b'; did you mean 'c'? Look"


def test_exit_codes_are_those_of_the_readme():
    codes = {ParameterError: 2, NoSolution: 3}
    every = [item for _, item in inspect.getmembers(errors, inspect.isclass) if issubclass(item, IpcliError)]
    assert len(every) >= 8
    for item in every:
        expected = next((code for kind, code in codes.items() if issubclass(item, kind)), 1)
        assert item.exit_code == expected, item


def test_outputs_in_the_way_say_what_to_do():
    assert "--overwrite" in str(OutputExists("a.h5", "holds another run"))
    refused = str(OutputRefused("a.h5", "is an input"))
    assert refused.startswith("a.h5: is an input")
    assert "--overwrite" not in refused


@given(WORDS, st.lists(WORDS, min_size=1, max_size=5, unique=True))
def test_the_nearest_name_is_the_most_alike_of_all(name, known):
    alike = {other: difflib.SequenceMatcher(None, other, name).ratio() for other in known}
    found = nearest(name, iter(known)).removeprefix("; did you mean '").removesuffix("'?")
    assert alike[found] == max(alike.values())


def test_of_nothing_nothing_is_near():
    assert nearest("a", ()) == ""
    assert nearest("a", {"abc": 1}) == "; did you mean 'abc'?"
