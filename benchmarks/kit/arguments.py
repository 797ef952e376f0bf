"""The options that benchmarks share: `--quick`, `--output`, `--threads`, number and size of generated views."""

from __future__ import annotations

import argparse
from pathlib import Path

OUTPUT = Path(__file__).resolve().parents[2] / "build" / "benchmarks"
SIZE, QUICK_SIZE = (640, 480), (320, 240)  # of generated views: width, height


def parser_of(doc: str | None, quick: str | None = None) -> argparse.ArgumentParser:
    """A parser that tells the module's docstring; `quick` says what --quick leaves out, without it there is none."""
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    if quick is not None:
        parser.add_argument("--quick", action="store_true", help=quick)
    parser.add_argument("--output", type=Path, default=OUTPUT, help="folder for the tables")
    return parser


def add_threads(parser: argparse.ArgumentParser) -> None:
    """For those that measure at one number of threads."""
    parser.add_argument("--threads", type=int, default=2, help="that each method may take; 2")


def add_generated(parser: argparse.ArgumentParser) -> None:
    """Number and size of generated views; `size_of` tells the size."""
    parser.add_argument("--count", type=int, default=11, help="views to fuse; 11")
    parser.add_argument("--size", type=int, nargs=2, metavar=("WIDTH", "HEIGHT"), help="of generated views; 640 480")


def size_of(options: argparse.Namespace) -> tuple[int, int]:
    """(width, height) of generated views: as given, else as is usual, in a quick look or not."""
    width, height = options.size or (QUICK_SIZE if options.quick else SIZE)
    return width, height
