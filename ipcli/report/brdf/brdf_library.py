"""The page of a `brdf-library`: balls of every material under some of the lights, and how well rims are told from cut
edges.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ipcli.report.brdf import relief
from ipcli.report.kit import pictures
from ipcli.report.kit.numbers import number, percent
from ipcli.report.kit.page import Markup, element, figure, gallery, section, table
from ipcli.report.kit.page import page as document
from ipcli.report.kit.provenance import origin

SHOWN = 8  # lights a material is shown under


def page(arrays: Mapping[str, np.ndarray], provenance: Mapping[str, object], *, widest: int = 0) -> str:
    """The HTML of a `brdf-library` artefact; its balls are small, so there is nothing for ``widest`` to bound."""
    materials, maps = arrays["materials"], len(arrays["chart_material"])
    verdict = (
        f"{len(materials)} materials under {maps // max(len(materials), 1)} lights. On generated scenes that were "
        f"not learnt from, "
        f"{percent(float(arrays['rim_accuracy']))} of the outlines are told right: rim or cut edge; of other "
        f"surfaces under other lights, "
        f"{percent(float(arrays['material_accuracy'][0]))} of the materials are named right and "
        f"{percent(float(arrays['material_accuracy'][1]))} "
        "told right as metal or not."
    )
    return document(
        "A library of materials",
        "ipcli brdf-train",
        verdict,
        *(_material(arrays, index) for index in range(len(materials))),
        _rims(arrays),
        origin(provenance),
    )


def _material(arrays: Mapping[str, np.ndarray], index: int) -> Markup:
    mine = np.flatnonzero(arrays["chart_material"] == index)
    some = mine[np.linspace(0, len(mine) - 1, min(SHOWN, len(mine))).round().astype(int)]
    balls = [
        figure(
            pictures.photograph(relief.ball(arrays["charts"][j].astype(np.float64), 120)),
            str(arrays["probes"][arrays["chart_probe"][j]]),
            f"turned by {np.degrees(float(arrays['chart_heading'][j])):.0f}°",
        )
        for j in some
    ]
    kind = "metal" if arrays["is_metal"][index] else "no metal"
    return section(str(arrays["materials"][index]), gallery(*balls, columns=8, small=True), lead=kind)


def _rims(arrays: Mapping[str, np.ndarray]) -> Markup:
    count = len(arrays["rim_features"])
    weights = arrays["rim_weights"]
    rows = [
        (
            str(name),
            number(float(weights[1 + k])),
            number(float(weights[1 + count + k])),
            number(float(arrays["rim_mean"][k])),
        )
        for k, name in enumerate(arrays["rim_features"])
    ]
    lead = f"Learnt from {int(arrays['rim_scenes'])} generated scenes. Positive weights speak for a cut edge."
    return section(
        "Rim or cut edge", element("div", table(("Feature", "weight", "of its square", "mean"), rows)), lead=lead
    )
