"""Telling: tables as JSON and Markdown, what they were measured on, and lines of progress."""

from __future__ import annotations

import json
import os
import platform
import sys
import time
from collections.abc import Mapping, Sequence
from importlib import metadata
from pathlib import Path
from typing import Any

from ipcli.io.files import atomic

LIBRARIES = (
    "numpy",
    "numba",
    "pylops",
    "pyproximal",
    "odl",
    "scikit-image",
    "scikit-learn",
    "aeon",
    "open3d-cpu",
    "open3d",
)
Row = Mapping[str, Any]
Tables = Mapping[str, Sequence[Row]]  # by their headings


def say(text: str) -> None:
    """A line of progress on stderr."""
    print(text, file=sys.stderr, flush=True)


def table(rows: Sequence[Mapping[str, Any]]) -> str:
    """A Markdown table with the keys of the rows as columns."""
    columns = list(dict.fromkeys(key for row in rows for key in row))
    cells = [columns, ["---"] * len(columns), *([_cell(row.get(column)) for column in columns] for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in cells)


def _cell(value: Any) -> str:
    if value is None:
        return "-"
    if not isinstance(value, float):
        return str(value)
    return f"{value:.0f}" if 100 <= abs(value) < 1e6 else f"{value:.3g}"


def publish(name: str, title: str, tables: Tables, facts: Mapping[str, Any], output: Path) -> None:
    """Write NAME.json and NAME.md into the folder and print the latter; `facts` say how it was measured."""
    print(save(name, title, tables, facts, output))


def save(name: str, title: str, tables: Tables, facts: Mapping[str, Any], output: Path) -> str:
    """The same without printing, for what is measured so far; the text of NAME.md."""
    facts = machine() | dict(facts)
    lines = [f"# {title}", "", *(f"- {key}: {_cell(value)}" for key, value in facts.items())]
    for heading, rows in tables.items():
        lines += ["", f"## {heading}", "", table(rows)]
    text = "\n".join(lines)
    output.mkdir(parents=True, exist_ok=True)
    atomic.write_text(output / f"{name}.json", json.dumps({"facts": facts, "tables": tables}, indent=1) + "\n")
    atomic.write_text(output / f"{name}.md", text + "\n")
    return text


def machine() -> dict[str, Any]:
    """What the figures depend on: processor, load by others, versions."""
    load = f"{os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "unknown"
    known = {item.metadata["Name"].lower(): item.version for item in metadata.distributions()}
    return {
        "time": time.strftime("%Y-%m-%d %H:%M:%S"),
        "processor": f"{_processor()}, {os.cpu_count()} logical",
        "load at the end (1 min, our own included)": load,
        "python": platform.python_version(),
        "libraries": ", ".join(f"{name} {known[name]}" for name in LIBRARIES if name in known),
    }


def _processor() -> str:
    info = Path("/proc/cpuinfo")
    models = (
        [line.split(":")[1].strip() for line in info.read_text().splitlines() if line.startswith("model name")]
        if info.exists()
        else []
    )
    return models[0] if models else platform.processor() or platform.machine()
