"""Parameters of the commands that serve all chapters."""

from __future__ import annotations

from dataclasses import dataclass

from ipcli.params import option


@dataclass(frozen=True)
class Report:
    """How the page is drawn."""

    width: int = option(900, "Widest picture that is stored.", flag="--width", low=64, high=8192, unit="pixels")
