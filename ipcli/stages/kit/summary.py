"""What a command says of its result on the console, and with --json."""

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
