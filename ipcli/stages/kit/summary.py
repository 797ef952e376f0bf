"""What a command says of its result on the console, and with --json.

The command line loads this before it knows what is asked for, so numpy is loaded where a figure needs it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
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


def of_items(folder: Path, outcomes: Mapping[Path, Enum]) -> dict[str, Any]:
    """The name of a folder as `output`, and how each of the files in it that a command was to make came about."""
    ends = [end.value for end in outcomes.values()]
    counts = ", ".join(f"{ends.count(end)} {end}" for end in dict.fromkeys(ends))
    outputs = {str(path): end for path, end in zip(outcomes, ends, strict=True)}
    return {"output": folder, "outputs": Figure(outputs, counts or "none")}


@of_result
def of_views(output: Path) -> dict[str, Any]:
    """How many views a `views` artefact holds, what they measure and in which unit."""
    from ipcli.io.files import h5

    found = h5.read(output, "views", lambda name: name in ("unit", "measured") or name.endswith("/intrinsics")).arrays
    count = sum(name.endswith("/intrinsics") for name in found)
    return {"views": count, "measured": str(found["measured"]), "unit": str(found["unit"])}


@of_result
def of_recording(output: Path) -> dict[str, Any]:
    """How many frames a `recording` artefact holds, over how long, and what it has besides."""
    from ipcli.io.files import h5

    times = h5.read(output, "recording", lambda name: name == "times").arrays["times"]
    names, seconds = h5.names(output), float(times[-1] - times[0]) if len(times) else 0.0
    has = [word for word in ("gaze", "depth", "truth", "targets") if any(word in name.split("/") for name in names)]
    return {
        "frames": len(times),
        "length": Figure(seconds, f"{seconds:.4g} s"),
        "holds": Figure(has, ", ".join(["pictures", *has])),
    }


@of_result
def of_clips(output: Path) -> dict[str, Any]:
    """How many clips, frames, actions and people a `clips` artefact holds."""
    from ipcli.io.files import h5

    found = h5.read(output, "clips", lambda name: name in ("clips", "labels", "actors", "frames")).arrays
    counts = {"actions": found["labels"], "people": found["actors"]}
    told = {name: len({text for text in values.tolist() if text}) for name, values in counts.items()}
    return {"clips": len(found["clips"]), "frames": int(found["frames"].sum())} | told
