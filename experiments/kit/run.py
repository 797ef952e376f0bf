"""One experiment from its argument line to its files: the page, its table as CSV and JSON, its figures.

A chapter's page.py ends with `run(EXPERIMENTS, make)`, where `make` turns `Arguments` into `Findings`.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from experiments.kit.arguments import Arguments, parse_arguments
from experiments.kit.tables import write_table
from ipcli.io.files import atomic
from ipcli.report.kit.page import Markup
from ipcli.report.kit.page import page as document


@dataclass(frozen=True)
class Findings:
    """All that an experiment leaves: its page, the rows of its table, what is said about them, and its figures."""

    page: str
    rows: Sequence[Mapping[str, object]]
    about: Mapping[str, object] = field(default_factory=dict)
    draw: Callable[[Path], None] | None = None  # writes the figures into a folder


def run(names: Collection[str], make: Callable[[Arguments], Findings], line: Sequence[str] | None = None) -> None:
    """Make the experiment that the argument line names and write what it found; the page comes last."""
    arguments = parse_arguments(names, line)
    found = make(arguments)
    write_table(arguments.out, found.rows, **found.about)
    if found.draw is not None:
        found.draw(arguments.out.parent / "figures")
    atomic.write_text(arguments.out, found.page)


def page_of(chapter: str, title: str, lead: str, *sections: Markup | None) -> str:
    """The whole page: title, the folder whose makefiles make it, lead, and the sections that there are."""
    return document(title, f"experiments/{chapter}", lead, *(part for part in sections if part))


def quick_lead(data: str) -> str:
    """The warning that a quick look's page begins with; `data` says what stands in for the data sets."""
    return f"A quick look at {data}: it shows that everything runs, not how good it is. "
