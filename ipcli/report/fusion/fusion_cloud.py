"""The page of a `cloud`: what it looks like, and what each map gave to it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ipcli.report.kit import pictures, surface
from ipcli.report.kit.numbers import percent, with_unit
from ipcli.report.kit.page import TURNED, Markup, figure, join, meter, section, table
from ipcli.report.kit.page import page as document
from ipcli.report.kit.pictures import photograph
from ipcli.report.kit.provenance import origin

CANVAS = (540, 860)  # rows and columns of the picture


def page(arrays: Mapping[str, np.ndarray], provenance: Mapping[str, Any], *, widest: int = pictures.WIDEST) -> str:
    """The HTML of a "fusion-cloud" artefact; no picture is stored wider than `widest` pixels."""
    unit, count = str(arrays["unit"]), len(arrays["points"])
    most = int(np.median(arrays["views"])) if count else 0
    share = float((arrays["views"] >= most).mean()) if count else 0.0
    verdict = (
        f"{count} points on a grid of {with_unit(float(arrays['spacing']), unit)}; {percent(share)} of them are seen "
        f"alike by {most} maps or more."
        if count
        else "The cloud is empty."
    )
    verdict += "".join(f" Warning: {warning}." for warning in arrays.get("warnings", np.array([])).tolist())
    title = f"One cloud of {len(arrays['maps'])} fused maps"
    return document(
        title,
        "ipcli merge-depth",
        verdict,
        _picture(arrays, widest),
        _by_map(arrays),
        _by_views(arrays),
        origin(provenance),
    )


def _picture(arrays: Mapping[str, np.ndarray], widest: int) -> Markup:
    middle = arrays["cam_from_world"][len(arrays["cam_from_world"]) // 2]
    rotation, shift = middle[:3, :3], middle[:3, 3]
    points, normals = arrays["points"] @ rotation.T + shift, arrays["normals"] @ rotation.T
    shown = surface.cloud(points, normals, arrays.get("colors"), CANVAS)
    lead = join("The page ", TURNED, " shows it to be turned.")
    return section(
        "Cloud", figure(photograph(shown, widest), "The cloud, seen from beside the middle camera"), lead=lead
    )


def _by_map(arrays: Mapping[str, np.ndarray]) -> Markup:
    rows = [
        (
            name,
            f"{points}",
            *(meter(part, percent(part)) for part in (confirmed / max(points, 1), contradicted / max(points, 1))),
        )
        for name, points, confirmed, contradicted in zip(
            *(arrays[field].tolist() for field in ("maps", "map_points", "map_confirmed", "map_contradicted")),
            strict=True,
        )
    ]
    lead = "Confirmed: enough other maps see the point where it is. Contradicted: more of them look through it."
    return section("Map by map", table(("map", "points", "confirmed", "contradicted"), rows), lead=lead)


def _by_views(arrays: Mapping[str, np.ndarray]) -> Markup:
    numbers, counts = np.unique(arrays["views"], return_counts=True)
    total = max(int(counts.sum()), 1)
    rows = [
        (f"{n}", f"{c}", meter(c / total, percent(c / total))) for n, c in zip(numbers, counts.tolist(), strict=True)
    ]
    return section("Maps that agree on a point", table(("maps", "points", "share"), rows))
