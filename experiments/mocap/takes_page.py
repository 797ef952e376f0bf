"""The page of the experiment on long takes: how much of the time is named right by windows of several lengths, and the
timelines.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ipcli.report.kit.numbers import percent
from ipcli.report.kit.page import page as document
from ipcli.report.kit.page import section, table
from ipcli.report.mocap.action_recognition import shares_of_time, timelines

Arrays = Mapping[str, np.ndarray]


def page(title: str, lead: str, found: Mapping[tuple[float, bool], Arrays], shown: tuple[float, bool]) -> str:
    """Recognitions by length of the window in seconds and whether "none" was allowed; the timelines are of the one
    `shown`.
    """
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
    words = f"The window is {shown[0]:g} s. Bars: what was recognised, the darker, the surer; outlines: the labels."
    return document(
        title,
        "experiments/mocap/mocap.mk",
        lead,
        section("Time named right", table(heads, rows), lead=lead_table),
        section("Timelines", *timelines(found[shown]), lead=words),
    )
