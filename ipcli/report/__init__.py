"""Artefacts as self-contained HTML pages: that of a kind is the module of that name in the folder of its chapter."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType

from ipcli import schema
from ipcli.errors import ParameterError


def has_page(kind: str) -> bool:
    """Whether a registered kind has a page."""
    return kind in schema.KINDS and find_spec(_name(kind)) is not None


def renderer(kind: str) -> Callable[..., str]:
    """The function page(arrays, provenance, *, widest) -> HTML of a kind; ParameterError for a kind without a page."""
    return _module(kind).page


def needed(kind: str) -> Callable[[str], bool] | None:
    """Which fields the page of a kind shows, to read no others; None for all."""
    return getattr(_module(kind), "needed", None)


def _module(kind: str) -> ModuleType:
    if not has_page(kind):
        known = ", ".join(sorted(filter(has_page, schema.KINDS)))
        raise ParameterError(f"no report for artefacts of kind {kind!r}; there are some for {known}. See ipcli info")
    return import_module(_name(kind))


def _name(kind: str) -> str:
    return f"ipcli.report.{schema.chapter(kind)}.{kind.replace('-', '_')}"
