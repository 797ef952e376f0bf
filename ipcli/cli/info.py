"""`ipcli info`: what a file holds."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click

from ipcli.cli import options
from ipcli.params import Run


@click.command("info")
@click.argument("file", type=options.PATH)
@options.reading
def main(file: Path, run: Run) -> None:
    """Tell what FILE (an .h5 artefact or a .ply) holds: kind, fields, units, what its texts say (actions, people,
    outcomes: how often each) and how it was made.
    """
    from ipcli.stages.kit import info

    found = info.run(file)
    if run.json:
        options.conclude(found, run)
    else:
        click.echo("\n".join(_ply(found) if found["kind"] == "ply" else _artefact(found)))


def _artefact(found: dict[str, Any]) -> Iterator[str]:
    yield f"{found['file']}: kind '{found['kind']}', version {found['version']}"
    rows = [
        (name, _shape(d["shape"]), d["dtype"], d["units"] or "-", d["doc"]) for name, d in found["datasets"].items()
    ]
    widths = [max(map(len, column)) for column in list(zip(*rows, strict=True))[:4]]
    for row in rows:
        yield "  " + "  ".join([*(cell.ljust(width) for cell, width in zip(row, widths, strict=False)), row[4]])
    yield from (f"  {name}: {_counts(told)}" for name, told in found["texts"].items() if any(told["values"]))
    record = found["provenance"]
    yield f"made by ipcli {record.get('ipcli', '?')} {record.get('command', '?')}, seed {record.get('seed', '?')}"
    yield f"digest {record.get('digest', '?')}"
    yield from (f"  input {item['name']}  sha256 {item['sha256']}" for item in record.get("inputs", ()))
    yield from (f"  {key} = {value}" for key, value in _flat(record.get("params", {})))


def _ply(found: dict[str, Any]) -> Iterator[str]:
    yield f"{found['file']}: PLY, {found['format']}"
    for name, element in found["elements"].items():
        yield f"  {element['count']} x {name}: {', '.join(element['properties'])}"
    yield from (f"  comment {text}" for text in found["comments"])


def _counts(told: dict[str, Any]) -> str:
    """`walk 6, wave 5` of values that come again, `a, b, c` of names that do not, with how many more there are."""
    values, many = told["values"], any(count > 1 for count in told["values"].values())
    words = [f"{_shown(value)} {count}" if many else _shown(value) for value, count in values.items()]
    more = told["distinct"] - len(words)
    return ", ".join(words) + (f" and {more} more" if more else "")


def _shown(value: str) -> str:
    """A value in one line, the empty one as quotes."""
    return " ".join(value.split()) or "''"


def _shape(shape: tuple[int, ...]) -> str:
    return " x ".join(map(str, shape)) or "scalar"


def _flat(tree: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for name, value in tree.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value
