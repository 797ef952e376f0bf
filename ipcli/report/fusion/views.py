"""The contact sheet of a "views" artefact: every view with its image, its depth and its camera."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ipcli.report.kit import curves, pictures
from ipcli.report.kit.numbers import aligned, finite, number, percent
from ipcli.report.kit.page import Markup, bar, columns_for, element, figure, gallery, meter, notice, section, table
from ipcli.report.kit.page import page as document
from ipcli.report.kit.pictures import Scale, draw, photograph
from ipcli.report.kit.provenance import origin

MOST = 48  # views shown as pictures; the table has them all
NOT_SHOWN = ("/confidence", "/truth")  # fields of a view that the sheet does not need: large, and left unread
Views = Mapping[str, Mapping[str, np.ndarray]]


def page(arrays: Mapping[str, np.ndarray], provenance: Mapping[str, Any], *, widest: int = pictures.WIDEST) -> str:
    """The HTML page of a "views" artefact, the same bytes for the same artefact; no picture is stored wider than
    ``widest`` pixels.
    """
    views = by_name(arrays)
    unit = str(np.asarray(arrays["unit"]).item())
    scale = pictures.robust([view["depth"] for view in views.values()], "turbo", unit)
    parts = (
        [_sheet(views, scale, min(widest, 240)), _cameras(views, unit)]
        if views
        else [notice("there is nothing to show.")]
    )
    return document("Depth views", "ipcli views", _verdict(views, arrays), *parts, origin(provenance))


def needed(field: str) -> bool:
    """Whether the sheet shows a field of the artefact."""
    return not field.endswith(NOT_SHOWN)


def by_name(arrays: Mapping[str, np.ndarray]) -> Views:
    """The fields of each view, views in the order of the sequence: views/NAME/field becomes [NAME][field]."""
    views: dict[str, dict[str, np.ndarray]] = {}
    for path in sorted(arrays):
        if path.startswith("views/"):
            name, field = path.removeprefix("views/").rsplit("/", 1)
            views.setdefault(name, {})[field] = arrays[path]
    return dict(sorted(views.items()))


def spread(names: Sequence[str], most: int) -> list[str]:
    """At most ``most`` of the names, evenly spread, the first and the last among them."""
    if len(names) <= most:
        return list(names)
    return [names[index] for index in np.linspace(0, len(names) - 1, most).round().astype(int)]


def _verdict(views: Views, arrays: Mapping[str, np.ndarray]) -> str:
    if not views:
        return "The artefact holds no view."
    sizes = sorted({view["depth"].shape[::-1] for view in views.values()})
    known = [np.count_nonzero(np.isfinite(view["depth"])) / view["depth"].size for view in views.values()]
    written = f"{sizes[0][0]} × {sizes[0][1]} pixels" if len(sizes) == 1 else f"{len(sizes)} sizes"
    unit = str(np.asarray(arrays["unit"]).item()) or "no stated unit"
    many = "One view" if len(views) == 1 else f"{len(views)} views"
    measured = str(np.asarray(arrays["measured"]).item())
    held = f"{percent(float(np.mean(known)))} of the pixels hold depth"
    return f"{many} of {written}, depth in {unit}, measured as {measured}; {held}."


def _sheet(views: Views, scale: Scale, widest: int) -> Markup:
    names = spread(list(views), MOST)
    height, width = views[names[0]]["depth"].shape
    shown = [_thumbnail(name, views[name], scale, widest) for name in names]
    columns = columns_for(width / height * (2 if "image" in views[names[0]] else 1), max(4, len(shown)), small=True)
    lead = "Depth of all views on one scale. Hatched grey is missing data."
    lead += f" {len(names)} of {len(views)} views, evenly spread." if len(names) < len(views) else ""
    return section(
        "Contact sheet",
        gallery(*shown, columns=columns, small=True),
        element("div", bar(scale), class_="shared"),
        lead=lead,
    )


def _thumbnail(name: str, view: Mapping[str, np.ndarray], scale: Scale, widest: int) -> Markup:
    depth = figure(draw(view["depth"], scale, widest), name, _size(view["depth"]))
    if "image" not in view:
        return depth
    return element("div", depth, figure(photograph(view["image"], widest), "Image"), class_="pair")


def _size(depth: np.ndarray) -> str:
    return f"{depth.shape[1]} × {depth.shape[0]}"


def _cameras(views: Views, unit: str) -> Markup:
    centres = np.array([centre(view["cam_from_world"]) for view in views.values()])
    suffix = f", {unit}" if unit else ""
    dots = len(centres) < 40
    axes = [
        curves.Series(axis, np.arange(len(centres)), values, dots=dots)
        for axis, values in zip("xyz", centres.T, strict=True)
    ]
    track = curves.plot(axes, "Camera centre along the sequence", "view", f"coordinate{suffix}", width=640)
    return section("Cameras", element("div", track, class_="plots"), _camera_table(views, centres, suffix))


def _camera_table(views: Views, centres: np.ndarray, suffix: str) -> Markup:
    heads = (
        "View",
        "Size",
        "Valid depth",
        f"Nearest 1 %{suffix}",
        f"Median{suffix}",
        f"Farthest 1 %{suffix}",
        "Focal length, px",
        *(f"Centre {axis}{suffix}" for axis in "xyz"),
    )
    shares = [np.count_nonzero(np.isfinite(view["depth"])) / view["depth"].size for view in views.values()]
    spans = np.array([_span(view["depth"]) for view in views.values()])
    columns = [
        list(views),
        [_size(view["depth"]) for view in views.values()],
        [meter(share, percent(share)) for share in shares],
        *map(aligned, spans.T),
        [number(view["intrinsics"][0, 0], 4) for view in views.values()],
        *map(aligned, centres.T),
    ]
    return table(heads, list(zip(*columns, strict=True)))


def _span(depth: np.ndarray) -> np.ndarray:
    """The 1st, 50th and 99th percentile of the known depth; NaN if there is none."""
    known = finite([depth])
    return np.percentile(known, (1, 50, 99)) if known.size else np.full(3, np.nan)


def centre(cam_from_world: np.ndarray) -> np.ndarray:
    """The camera centre (3,) in the world: -R^T t."""
    return -cam_from_world[:3, :3].T @ cam_from_world[:3, 3]
