"""What a command says of its result on the console, and with --json.

The command line loads this before it knows what is asked for, so numpy is loaded where a figure needs it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Figure:
    """A figure as --json has it, numbers or names, and as a person reads it on the console."""

    value: Any
    text: str

    def __str__(self) -> str:
        return self.text


def of_result(figures: Callable[[Path], Mapping[str, Any]]) -> Callable[[Path], dict[str, Any]]:
    """The name of a result as `output` and its figures; of none that is there (a dry run) the name alone."""

    @wraps(figures)
    def summary(output: Path) -> dict[str, Any]:
        return {"output": output} | (dict(figures(output)) if output.is_file() else {})

    return summary


@of_result
def of_views(output: Path) -> dict[str, Any]:
    """How many views a `views` artefact holds, what they measure and in which unit."""
    from ipcli.io.files import h5

    found = h5.read(output, "views", lambda name: name in ("unit", "measured") or name.endswith("/intrinsics")).arrays
    count = sum(name.endswith("/intrinsics") for name in found)
    return {"views": count, "measured": str(found["measured"]), "unit": str(found["unit"])}


@of_result
def of_clips(output: Path) -> dict[str, Any]:
    """How many clips, frames, actions and people a `clips` artefact holds."""
    from ipcli.io.files import h5

    found = h5.read(output, "clips", lambda name: name in ("clips", "labels", "actors", "frames")).arrays
    counts = {"actions": found["labels"], "people": found["actors"]}
    told = {name: len({text for text in values.tolist() if text}) for name, values in counts.items()}
    return {"clips": len(found["clips"]), "frames": int(found["frames"].sum())} | told
