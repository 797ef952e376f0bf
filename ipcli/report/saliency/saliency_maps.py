"""The page of `saliency-maps`: each picture beside where people are likely to look."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ipcli.report.kit import pictures
from ipcli.report.kit.numbers import number
from ipcli.report.kit.page import TURNED, Markup, bar, element, figure, gallery, join, notice, section
from ipcli.report.kit.page import page as document
from ipcli.report.kit.provenance import origin
from ipcli.report.saliency.overlay import LEAST_BRIGHT, PALETTE, TURNS, around, glow, items

MOST = 40  # pictures on a page


def page(arrays: Mapping[str, np.ndarray], provenance: Mapping[str, object], *, widest: int = pictures.WIDEST) -> str:
    """The HTML of a `saliency-maps` artefact; no picture is stored wider than `widest` pixels."""
    names, surfaces = items(arrays, "pictures"), items(arrays, "surfaces")
    what = f"{len(names)} picture{'s' if len(names) != 1 else ''}" if names else ", ".join(surfaces)
    verdict = (
        f"{what}, predicted by: {arrays['model']}. Bright is where people are likely to look, dark where they are not."
    )
    left = notice(f"{len(names) - MOST} more are in the file and not shown here.") if len(names) > MOST else Markup("")
    shown = [_picture(arrays, name, min(widest, 560)) for name in names[:MOST]]
    shown += [_surface(arrays, name) for name in surfaces]
    return document("Where people look", "ipcli saliency-predict", verdict, *shown, left, origin(provenance))


def _picture(arrays: Mapping[str, np.ndarray], name: str, widest: int) -> Markup:
    picture, saliency = arrays[f"pictures/{name}/picture"], arrays[f"pictures/{name}/map"]
    scale = pictures.Scale(0.0, float(f"{max(float(saliency.max()), LEAST_BRIGHT):.2g}"), PALETTE, "times chance")
    return section(
        name,
        gallery(
            figure(pictures.photograph(glow(picture, saliency), widest), "lit by its saliency"),
            figure(pictures.draw(saliency, scale), "saliency", f"highest {number(float(saliency.max()))}", scale=scale),
            columns=2,
        ),
    )


def _surface(arrays: Mapping[str, np.ndarray], name: str) -> Markup:
    points, normals, saliency = (arrays[f"surfaces/{name}/{part}"] for part in ("points", "normals", "map"))
    scale = pictures.from_zero([saliency], PALETTE, "times chance")
    turns = [figure(pictures.photograph(around(points, normals, saliency, scale, turn)), f"{turn}°") for turn in TURNS]
    lead = join(
        "From around, upright (--up names the axis of the file that is); bright is likely to be looked at. The page ",
        TURNED,
        " shows it to be turned.",
    )
    return section(name, gallery(*turns, columns=4), element("div", bar(scale), class_="beside"), lead=lead)
