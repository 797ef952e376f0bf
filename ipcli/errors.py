"""Every error a user can meet: one line that says what, where, expected and got, and what to do next."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path


class IpcliError(Exception):
    """The work could not be done. The message is one line, ready to print."""

    exit_code = 1


class ParameterError(IpcliError):
    """An unknown parameter, a bad value, or a combination that makes no sense."""

    exit_code = 2


class NoSolution(IpcliError):
    """The method ran on sound input, but that input holds no solution (no overlap between views, say)."""

    exit_code = 3


class OutputExists(IpcliError):
    """The output is there already and is not what this run would write."""

    def __init__(self, path: Path | str, why: str):
        super().__init__(f"{path}: exists and {why}. Give --overwrite to replace it, or another output name")


class OutputRefused(IpcliError):
    """A name that this run must not write to, whatever the options: an input, or a file that is not of its making."""

    def __init__(self, path: Path | str, why: str):
        super().__init__(f"{path}: {why}. Move it away, or give another output name")


class FormatError(IpcliError):
    """A file is not what it should be: `path: what (expected X, got Y). fix`."""

    def __init__(self, path: Path | str, what: str, *, expected=None, got=None, fix: str | None = None):
        facts = [f"{label} {value}" for label, value in (("expected", expected), ("got", got)) if value is not None]
        detail = f" ({', '.join(facts)})" if facts else ""
        text = f"{path}: {what}{detail}"
        super().__init__(f"{text}{'' if text.endswith('?') else '.'} {fix}" if fix else text)


class VersionTooNew(FormatError):
    """The file was written by a newer ipcli."""


class VersionTooOld(FormatError):
    """The file was written by an older ipcli whose layout is no longer read."""


def nearest(name: str, known: Iterable[str]) -> str:
    """`; did you mean 'x'?` with the known name most like `name`, or nothing when there is none at all."""
    import difflib

    matches = difflib.get_close_matches(name, list(known), n=1, cutoff=0.0)
    return f"; did you mean '{matches[0]}'?" if matches else ""
