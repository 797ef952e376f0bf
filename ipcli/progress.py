"""How long work tells how far it is: `progress(share done in [0, 1], what was just done)`."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[float, str], None]


def silent(share: float, text: str) -> None:
    """Progress that nobody is told."""
