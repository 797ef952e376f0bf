"""Tables as the thesis prints them, one a file: `# TITLE`, the head, and the rows as comma-separated values."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Printed:
    """A table as the thesis prints it: its title, its columns, and a row of texts for each line."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    @property
    def number(self) -> str:
        """`Table 5.1` of the title `Table 5.1: of what`."""
        return self.title.split(": ", 1)[0]

    @property
    def words(self) -> str:
        """The title without its number, as a sentence begins."""
        words = self.title.split(": ", 1)[-1]
        return words[:1].upper() + words[1:]


def read_printed(path: Path) -> Printed:
    """The table in a file; ValueError where a row is longer or shorter than the head."""
    title, *lines = path.read_text(encoding="utf-8").splitlines()
    head, *rows = (tuple(row) for row in csv.reader(lines))
    if wrong := next((row for row in rows if len(row) != len(head)), None):
        raise ValueError(f"{path}: {len(wrong)} cells in the row of {wrong[0]}, {len(head)} in the head")
    return Printed(title.removeprefix("# "), head, tuple(rows))
