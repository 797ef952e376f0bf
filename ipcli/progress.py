"""How long work tells how far it is: `progress(share done in [0, 1], what was just done)`."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[float, str], None]


def portion(progress: Progress, start: float, end: float) -> Progress:
    """Progress of a part of the work, which takes shares from `start` to `end` of all of it."""
    return lambda share, text: progress(start + (end - start) * share, text)


def silent(share: float, text: str) -> None:
    """Progress that nobody is told."""
