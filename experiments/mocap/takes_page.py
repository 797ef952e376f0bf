"""The page of the experiment on long takes: how much of the time is named right by windows of several lengths, and the
timelines.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from experiments.kit.credits import Credit, credits_section
from experiments.kit.run import Findings, page_of
from ipcli.io.files import h5
from ipcli.report.kit.numbers import percent
from ipcli.report.kit.page import Markup, section, table
from ipcli.report.mocap.action_recognition import shares_of_time, timelines

NAME = "takes"
TITLE = "Long takes of people not learnt from"
LEAD = (
    "Clips of one actor after the other make a take with a label for every frame; between clips the pose jumps. The "
    "model knows the other "
    "actors alone. Order plays no part in it: a window is asked about as a set of frames."
)
SHOWN = (1.0, True)  # the window of the timelines in seconds, and whether "none" was allowed
Arrays = Mapping[str, np.ndarray]
Recognised = Mapping[tuple[float, bool], Arrays]  # by length of the window in seconds and whether "none" was allowed


def make(files: Sequence[Path], lead: str, credits: Sequence[Credit]) -> Findings:
    """The page and the table of recognitions; `lead` comes before the page's own."""
    found = {}
    for path in files:
        recognition = h5.read(path, "action-recognition")
        params = recognition.provenance["params"]
        found[params["window"], params["none"]] = recognition.arrays
    page = page_of("mocap", TITLE, lead + LEAD, *sections(found), credits_section(credits))
    return Findings(page, rows_of(found), {"title": TITLE})


def rows_of(found: Recognised) -> list[dict[str, object]]:
    """A row for each length of the window, with "none" allowed or not."""
    rows: list[dict[str, object]] = []
    for (window, allowed), arrays in found.items():
        right, unnamed = (round(100 * share, 2) for share in shares_of_time(arrays))
        told: dict[str, object] = {"window s": window, "none allowed": allowed}
        rows.append(told | {"time named right %": right, "called none %": unnamed})
    return rows


def sections(found: Recognised) -> list[Markup]:
    """How much of the time is named right, and the timelines of the recognition `SHOWN`."""
    rows = [
        (
            f"{window:g} s",
            *(
                percent(share)
                for allowed in (True, False)
                for share in shares_of_time(found[window, allowed])[: 1 + allowed]
            ),
        )
        for window in sorted({window for window, _ in found})
    ]
    heads = ("window", "named right", "called none", "named right if none is not allowed")
    lead_table = "Shares of the time that has a label. A quarter of a window from one to the next."
    words = f"The window is {SHOWN[0]:g} s. Bars: what was recognised, the darker, the surer; outlines: the labels."
    return [
        section("Time named right", table(heads, rows), lead=lead_table),
        section("Timelines", *timelines(found[SHOWN]), lead=words),
    ]
