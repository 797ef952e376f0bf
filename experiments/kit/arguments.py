"""The argument line of every experiment: `python -m experiments.CHAPTER.page [--quick] NAME OUT.html FILE...`."""

from __future__ import annotations

import argparse
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Arguments:
    """Which experiment, where its page goes, what it is made from, and whether it is a quick look alone."""

    name: str
    out: Path
    files: tuple[Path, ...]
    quick: bool = False


def parse_arguments(names: Collection[str], line: Sequence[str] | None = None) -> Arguments:
    """The argument line of the process, or `line`; ends with usage and exit code 2 if it is not one."""
    parser = argparse.ArgumentParser(description="Make the page, the table and the figures of an experiment.")
    parser.add_argument("--quick", action="store_true", help="say that it shows that everything runs, not how good")
    parser.add_argument("name", choices=sorted(names), metavar="NAME", help=", ".join(names))
    parser.add_argument("out", type=Path, metavar="OUT.html", help="the page; OUT.csv, OUT.json, figures/ beside it")
    parser.add_argument("files", type=Path, nargs="+", metavar="FILE", help="artefacts, told apart by their kind")
    given = parser.parse_args(line)
    return Arguments(given.name, given.out, tuple(given.files), given.quick)
