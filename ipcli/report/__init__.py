"""Artefacts as self-contained HTML pages: which kind is drawn by which module."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module

from ipcli.errors import ParameterError

PAGES = {
    "clips": "ipcli.report.clips",
    "behaviours": "ipcli.report.mocap_train",
    "cloud": "ipcli.report.merge_depth",
    "comparison": "ipcli.report.compare",
    "depth": "ipcli.report.fuse_depth",
    "evaluation": "ipcli.report.mocap_evaluate",
    "recognition": "ipcli.report.mocap_classify",
    "trials": "ipcli.report.evaluate_fusion",
    "tuning": "ipcli.report.tune_fusion",
    "views": "ipcli.report.views",
}


def renderer(kind: str) -> Callable[..., str]:
    """The function page(arrays, provenance, *, widest) -> HTML of a kind; ParameterError for a kind without a page."""
    if kind not in PAGES:
        raise ParameterError(
            f"no report for artefacts of kind {kind!r}; there are some for {', '.join(sorted(PAGES))}. See ipcli info"
        )
    return import_module(PAGES[kind]).page


def needed(kind: str) -> Callable[[str], bool] | None:
    """Which fields the page of a kind shows, to read no others; None for all."""
    return getattr(import_module(PAGES[kind]), "needed", None)
