"""Whose data an experiment shows: data.csv beside a chapter's code, named at the end of the page.

The head of the file is `experiments` (names, with spaces between), `name`, `authors`, `licence`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from experiments.kit.tables import read_rows
from ipcli.report.kit.page import Markup, section, table


@dataclass(frozen=True)
class Credit:
    """A data set, who made it, and on what terms."""

    name: str
    authors: str
    licence: str


def read_credits(path: Path, experiment: str) -> list[Credit]:
    """The data sets of one experiment, in the order of the file."""
    rows = read_rows(path)
    return [
        Credit(row["name"], row["authors"], row["licence"]) for row in rows if experiment in row["experiments"].split()
    ]


def credits_section(credits: Sequence[Credit]) -> Markup | None:
    """Data sets, authors and licences; None without any."""
    rows = [(credit.name, credit.authors, credit.licence) for credit in credits]
    return section("Data", table(("", "by", "terms"), rows)) if rows else None
