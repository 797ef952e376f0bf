"""Artefacts as self-contained HTML pages: which kind is drawn by which module."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module

from ipcli.errors import ParameterError

PAGES = {
    "clips": "ipcli.report.mocap.clips",
    "behaviours": "ipcli.report.mocap.behaviours",
    "cloud": "ipcli.report.fusion.fusion_cloud",
    "comparison": "ipcli.report.fusion.fusion_comparison",
    "depth": "ipcli.report.fusion.fused_depth",
    "evaluation": "ipcli.report.mocap.action_evaluation",
    "recognition": "ipcli.report.mocap.recognition",
    "trials": "ipcli.report.fusion.fusion_trials",
    "tuning": "ipcli.report.fusion.fusion_tuning",
    "views": "ipcli.report.fusion.views",
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
