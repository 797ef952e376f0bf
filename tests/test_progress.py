"""Progress that nobody is told says nothing and changes nothing."""

import inspect

from ipcli.progress import silent


def test_silence_takes_what_progress_takes_and_says_nothing(capsys):
    assert list(inspect.signature(silent).parameters) == ["share", "text"]
    assert silent(0.5, "half") is None
    assert capsys.readouterr() == ("", "")
