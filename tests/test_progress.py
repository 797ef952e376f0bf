"""Progress that nobody is told says nothing and changes nothing."""

import inspect

import pytest

from ipcli.progress import portion, silent


def test_silence_takes_what_progress_takes_and_says_nothing(capsys):
    assert list(inspect.signature(silent).parameters) == ["share", "text"]
    assert silent(0.5, "half") is None
    assert capsys.readouterr() == ("", "")


def test_progress_of_a_part_is_that_of_the_whole():
    told = []
    portion(lambda fraction, text: told.append(fraction), 0.4, 0.8)(0.5, "")
    assert told == pytest.approx([0.6])
