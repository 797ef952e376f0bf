"""How any source of measurements is opened: recognised among the layouts of its family, then opened with the hints that
the layout takes.

A family is a table of layouts (`io.views.layouts`, `io.motion.layouts`) in the order in which they are tried: the more
particular first.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

from ipcli.errors import FormatError, ParameterError, nearest
from ipcli.inputs import check_file

Source = TypeVar("Source")


@dataclass(frozen=True)
class Layout(Generic[Source]):
    """A known layout: how to tell it, how to open it (hints are its keyword-only parameters), and its look in words."""

    recognise: Callable[[Path], bool]
    open: Callable[..., Source]
    looks_like: str


def open_source(
    path: Path, layouts: Mapping[str, Layout[Source]], what: str, fix: str, format: str = "auto", **hints: Any
) -> Source:
    """What is at `path`, lazily. `format` is a key of the layouts or "auto"; hints that are None count as not given.

    Raises FormatError for a pipe or a device, and when no layout fits (listing what was looked for); ParameterError for
    an unknown format or a hint that the layout has no use for.
    """
    path = check_file(path)
    if not path.exists():
        raise FormatError(path, "no such file or folder", fix="Check the path")
    layout = _recognised(path, layouts, what, fix) if format == "auto" else _named(format, layouts)
    given = {key: value for key, value in hints.items() if value is not None}
    known = [name for name, item in inspect.signature(layout.open).parameters.items() if item.kind is item.KEYWORD_ONLY]
    if unknown := [key for key in given if key not in known]:
        takes = ", ".join(known) or "no hints"
        raise ParameterError(f"{path}: '{unknown[0]}' means nothing to {layout.looks_like}; that takes {takes}")
    return layout.open(path, **given)


def _recognised(path: Path, layouts: Mapping[str, Layout[Source]], what: str, fix: str) -> Layout[Source]:
    for layout in layouts.values():
        if layout.recognise(path):
            return layout
    looked_for = "; ".join(f"{name}: {layout.looks_like}" for name, layout in layouts.items())
    raise FormatError(path, f"no known layout of {what}. Looked for {looked_for}", fix=fix)


def _named(format: str, layouts: Mapping[str, Layout[Source]]) -> Layout[Source]:
    if format not in layouts:
        raise ParameterError(f"unknown format '{format}'{nearest(format, layouts)} Known: auto, {', '.join(layouts)}")
    return layouts[format]
