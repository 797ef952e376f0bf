"""The page of a fused depth map: a pure function of the "fused-depth" artefact."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ipcli.geometry.surface import normals
from ipcli.measurements.accuracy import MAP_PIXELS, thinned_camera, thinning
from ipcli.report.fusion import accuracy
from ipcli.report.kit import curves, pictures, surface
from ipcli.report.kit.numbers import aligned, finite, number, percent, with_unit
from ipcli.report.kit.page import (
    TURNED,
    Markup,
    bar,
    columns_for,
    element,
    figure,
    gallery,
    join,
    meter,
    notice,
    section,
    table,
)
from ipcli.report.kit.page import page as document
from ipcli.report.kit.pictures import Scale, draw, photograph
from ipcli.report.kit.provenance import origin

PIXELS = 280_000  # of the largest pictures: they are shown at about 430 x 320, and noise does not compress
THUMBNAIL_PIXELS = 250_000  # of all thumbnails together
LITTLE_OVERLAP = 0.05  # share of the reference's pixels below which a view hardly takes part
SMALL = (420, 270)  # width and height of plots that stand three in a row


@dataclass(frozen=True)
class PicturedMap:
    """A fused map as its page shows it: the arrays of the artefact, and what all its pictures have in common."""

    arrays: Mapping[str, np.ndarray]
    depth: Scale
    widest: int
    window: tuple[int, int, int, int]  # row, column, height and width of the part that is enlarged
    size: tuple[int, int]  # (h, w) of the whole map
    step: int  # so many-th rows and columns of it are in the arrays

    @property
    def unit(self) -> str:
        return text(self.arrays["unit"])

    @property
    def aspect(self) -> float:
        height, width = self.arrays["depth"].shape
        return width / height


def page(arrays: Mapping[str, np.ndarray], provenance: Mapping[str, Any], *, widest: int = pictures.WIDEST) -> str:
    """The HTML page of a "fused-depth" artefact, the same bytes for the same artefact.

    ``arrays`` and ``provenance`` are those of the artefact; no picture is stored wider than ``widest`` pixels.
    """
    height, width = arrays["depth"].shape
    widest = min(widest, max(64, round((PIXELS * width / height) ** 0.5)))
    step = thinning(height * width, MAP_PIXELS)
    arrays = _thinned(arrays, step)
    scale = pictures.robust([arrays["depth"]], "turbo", text(arrays["unit"]))
    fused = PicturedMap(arrays, scale, widest, _window(arrays), (height, width), step)
    parts = [*_notices(fused), _maps(fused), _surface(fused), _detail(fused)]
    parts += [accuracy.metrics(arrays)] if "metrics" in arrays else []
    parts += [accuracy.maps(arrays, fused.unit, widest)] if "truth" in arrays else []
    parts += [_views(fused), _solver(fused), _explanation(fused), origin(provenance)]
    reference = (provenance.get("params") or {}).get("reference")
    return document(
        f"Fused depth map of {reference}" if reference else "Fused depth map",
        "ipcli fuse-depth",
        _verdict(fused),
        *parts,
    )


def _thinned(arrays: Mapping[str, np.ndarray], step: int) -> Mapping[str, np.ndarray]:
    """Every `step`-th row and column of all maps, with the camera that sees them so."""
    if step == 1:
        return arrays
    shape = arrays["depth"].shape
    thin = {
        name: np.ascontiguousarray(array[::step, ::step]) for name, array in arrays.items() if array.shape[:2] == shape
    }
    return {**arrays, **thin, "intrinsics": thinned_camera(arrays["intrinsics"], step)}


def text(array: np.ndarray) -> str:
    """A scalar text of an artefact."""
    return str(np.asarray(array).item())


def scalar(array: np.ndarray) -> float:
    """The number in an array of one."""
    return float(np.asarray(array).item())


def _verdict(fused: PicturedMap) -> Markup:
    a = fused.arrays
    (height, width), count = fused.size, len(a["views"])
    observed, supported = (np.count_nonzero(mask) / mask.size for mask in (a["observations"], _supported(a)))
    views = f"{count} views" if count > 1 else "one view"
    noise = {"depth": fused.unit, "disparity": "px", "inverse depth": f"1/{fused.unit}"}[text(a["domain"])]
    words = (
        f"{width} × {height} pixels fused from {views} by {text(a['method'])} "
        f"on {text(a['domain'])}, λ = {number(scalar(a['lambda']))}. "
        f"Noise scale {with_unit(scalar(a['noise_scale']), noise)}; {percent(observed)} of the pixels observed"
        + (f", {percent(supported)} near the map; the rest is filled." if supported < observed else ".")
    )
    return join(words, *_gain(fused))


def _gain(fused: PicturedMap) -> list[object]:
    """How far the fused map is from the truth, against the median of the same observations."""
    a = fused.arrays
    rows, columns = ([str(name) for name in a.get(field, ())] for field in ("metric_rows", "metric_columns"))
    if not {"median", "fused"} <= set(rows) or "MAE" not in columns:
        return []
    median, found = (float(a["metrics"][rows.index(name), columns.index("MAE")]) for name in ("median", "fused"))
    if not np.isfinite(found):
        return [" The truth shares no pixel with the map."]
    change = (found - median) / median if median else 0.0
    side = "below" if change <= 0 else "above"
    words = f"mean error {with_unit(found, fused.unit)}, {number(abs(100 * change), 2)} % {side} the median's"
    return [" Against the truth: ", element("strong", words), " (MAE below, where every map has a value)."]


def _notices(fused: PicturedMap) -> list[Markup]:
    a = fused.arrays
    large = f"the map is large: pictures, curves and errors are of one in {fused.step} rows and columns."
    low = [str(name) for name, share in zip(a["views"], a["view_overlap"], strict=True) if not share >= LITTLE_OVERLAP]
    missing = np.count_nonzero(~np.isfinite(a["depth"])) / a["depth"].size
    found = [f"{warning}." for warning in a["warnings"].tolist()] if "warnings" in a else []
    if low:
        shown = ", ".join(low[:6]) + (f" and {len(low) - 6} more" if len(low) > 6 else "")
        verb = "overlaps" if len(low) == 1 else "overlap"
        found += [
            f"{len(low)} of {len(a['views'])} views {verb} the reference by less than {percent(LITTLE_OVERLAP)}: "
            f"{shown}."
        ]
    if missing:
        found += [f"{percent(missing)} of the fused map has no depth."]
    found += [large] if fused.step > 1 else []
    if not np.isfinite(a["confidence"]).any():
        found += ["no pixel has a confidence."]
    return [notice(sentence) for sentence in found]


def _maps(fused: PicturedMap) -> Markup:
    a, widest = fused.arrays, fused.widest
    confidence = _confidence_scale(a["confidence"])
    seen = np.where(_supported(a), a["observations"], np.nan).astype(np.float32)
    count = Scale(0.0, float(max(1, len(a["views"]), a["observations"].max(initial=1))), "sea", whole=True)
    shown = [
        figure(draw(a["reference"], fused.depth, widest), "Reference view", "as it was given", scale=fused.depth),
        figure(
            draw(a["median"], fused.depth, widest), "Median", "of the observations of each pixel", scale=fused.depth
        ),
        figure(
            draw(a["depth"], fused.depth, widest),
            "Fused",
            "the square is enlarged below",
            scale=fused.depth,
            frame=_shares(fused.window, a["depth"].shape),
        ),
        figure(
            draw(a["confidence"], confidence, widest), "Confidence", "Λ, relative to the noise scale", scale=confidence
        ),
        figure(draw(seen, count, widest), "Observations", "per pixel; hatched: none near the map, filled", scale=count),
        *_companion(fused),
    ]
    lead = "All depth maps share one scale: the 1st to the 99th percentile of the fused map. Hatched grey is missing."
    return section("Maps", gallery(*shown, columns=columns_for(fused.aspect, len(shown))), lead=lead)


def _supported(arrays: Mapping[str, np.ndarray]) -> np.ndarray:
    """Where the map rests on observations (h, w); artefacts of before it could tell have only their number."""
    seen: np.ndarray = arrays["observations"] > 0
    return seen & (arrays["filled"] == 0) if "filled" in arrays else seen


def _companion(fused: PicturedMap) -> list[Markup]:
    """The sixth picture: the truth, or else the colour image, or else nothing."""
    if "truth" in fused.arrays:
        return [
            figure(
                draw(fused.arrays["truth"], fused.depth, fused.widest), "Truth", "on the same scale", scale=fused.depth
            )
        ]
    if "image" in fused.arrays:
        return [figure(photograph(fused.arrays["image"], fused.widest), "Image", "of the reference view")]
    return []


def _confidence_scale(confidence: np.ndarray) -> Scale:
    """Logarithmic when the values span more than a factor of 20."""
    scale = pictures.robust([confidence], "viridis", log=True)
    return scale if scale.log and scale.high / scale.low > 20 else pictures.robust([confidence], "viridis")


def _surface(fused: PicturedMap) -> Markup:
    a, widest = fused.arrays, fused.widest
    light = surface.shade(a["normals"], a["intrinsics"])
    before = surface.shade(normals(a["median"], a["intrinsics"]), a["intrinsics"])
    turned = surface.oblique(a["depth"], a["intrinsics"], light, a.get("image"))
    shown = [
        figure(draw(before, surface.SHADE, min(widest, 480)), "Median, shaded", "normals by differences"),
        figure(draw(light, surface.SHADE, widest), "Fused, shaded", "headlight and a soft light from the upper left"),
        figure(
            photograph(turned, widest),
            "Fused, seen from the side",
            f"camera turned by {abs(surface.YAW):.0f}° and raised by {surface.PITCH:.0f}°",
        ),
    ]
    return section(
        "Surface",
        gallery(*shown, columns=columns_for(fused.aspect, 3)),
        lead=join("What the depth map is worth as a shape; ", TURNED, " shows it to be turned."),
    )


def _window(arrays: Mapping[str, np.ndarray]) -> tuple[int, int, int, int]:
    """Row, column, height and width of what to enlarge: where the fused map errs most, or else bends most."""
    depth = arrays["depth"]
    if "truth" in arrays:
        interest = accuracy.error(arrays, "depth")
    else:
        padded = np.pad(
            depth, 1, mode="reflect", reflect_type="odd"
        )  # goes on straight beyond the border: no relief there
        interest = np.abs(np.diff(padded[:, 1:-1], 2, axis=0)) + np.abs(np.diff(padded[1:-1], 2, axis=1))
    interest = np.nan_to_num(interest)
    interest = np.minimum(interest, np.percentile(interest, 99.5))  # a few outliers are no detail
    return _fullest(interest, max(1, min(round(depth.shape[0] / 3.2), depth.shape[1])))


def _fullest(interest: np.ndarray, side: int) -> tuple[int, int, int, int]:
    """The square window with the largest sum, on a grid of an eighth of its side, by an integral image."""
    sums = np.pad(interest, ((1, 0), (1, 0))).cumsum(0, dtype=np.float64).cumsum(1)
    boxes = sums[side:, side:] - sums[:-side, side:] - sums[side:, :-side] + sums[:-side, :-side]
    coarse = boxes[:: max(1, side // 8), :: max(1, side // 8)]
    row, column = np.unravel_index(np.argmax(coarse), coarse.shape)
    return int(row) * max(1, side // 8), int(column) * max(1, side // 8), side, side


def _shares(window: tuple[int, int, int, int], shape: tuple[int, int]) -> tuple[float, float, float, float]:
    row, column, height, width = window
    return column / shape[1], row / shape[0], width / shape[1], height / shape[0]


def _detail(fused: PicturedMap) -> Markup:
    row, column, height, width = fused.window
    crops = {
        name: fused.arrays[name][row : row + height, column : column + width]
        for name in ("reference", "median", "depth")
    }
    scale = pictures.robust([crops["depth"]], "turbo", fused.unit)
    shown = [
        figure(draw(crop, scale), accuracy.CANDIDATES[name], scale=scale, crisp=True) for name, crop in crops.items()
    ]
    change = crops["depth"] - crops["median"]
    signed = pictures.symmetric([change], fused.unit)
    shown += [figure(draw(change, signed), "Fused minus median", scale=signed, crisp=True)]
    why = "the fused map errs most" if "truth" in fused.arrays else "the surface bends most"
    lead = f"The square of {width} × {height} pixels at column {column}, row {row}, where {why}; on scales of its own."
    return section("Detail", gallery(*shown, columns=4), lead=lead)


def _views(fused: PicturedMap) -> Markup:
    a = fused.arrays
    thumbnails = np.asarray(a["thumbnails"])
    small = round((THUMBNAIL_PIXELS * fused.aspect / max(1, len(thumbnails))) ** 0.5)
    widest = min(fused.widest, 240, max(80, small))
    shown = [
        figure(draw(thumbnail, fused.depth, widest), str(name), percent(float(overlap)))
        for thumbnail, name, overlap in zip(thumbnails, a["views"], a["view_overlap"], strict=True)
    ]
    columns = columns_for(fused.aspect, max(len(shown), 4), small=True)
    if 4 < len(shown) <= 12:
        columns = min(columns, -(-len(shown) // 2))
    lead = "Each view reprojected into the reference camera, on the scale of the maps above; and the share it reaches."
    return section(
        "Views",
        gallery(*shown, columns=columns, small=True),
        element("div", bar(fused.depth), class_="shared"),
        _view_table(fused),
        lead=lead,
    )


def _view_table(fused: PicturedMap) -> Markup:
    a = fused.arrays
    rows, warn = [], dict[int, str]()
    columns = (a["views"], a["view_valid"], a["view_overlap"], aligned(a["view_residual"]))
    for index, (name, valid, overlap, residual) in enumerate(zip(*columns, strict=True)):
        little = not overlap >= LITTLE_OVERLAP
        warn |= {index: "little overlap with the reference"} if little else {}
        label = join(str(name), element("span", "little overlap", class_="aside") if little else "")
        rows.append((label, *(meter(share, percent(share)) for share in (float(valid), float(overlap))), residual))
    unit = f", {fused.unit}" if fused.unit else ""
    return table(("View", "Valid depth", "Overlap with the reference", f"Median residual{unit}"), rows, warn=warn)


def _solver(fused: PicturedMap) -> Markup:
    history = np.asarray(fused.arrays["history"])
    if not len(history):
        return section("Solver", lead="The solver left no history.")
    rounds, _, energy, gap, merit = history.T
    steps = unwrap(history[:, 1])
    last = np.flatnonzero(np.append(np.diff(rounds) != 0, True))  # the end of each round
    plots = [
        curves.plot(
            [curves.Series("gap", steps, gap)],
            "Restricted primal-dual gap",
            "iteration",
            "relative gap",
            log_y=True,
            width=SMALL[0],
            height=SMALL[1],
        ),
        curves.plot(
            [curves.Series("energy", steps, energy)],
            "Energy",
            "iteration",
            "energy",
            log_y=_spans(energy),
            width=SMALL[0],
            height=SMALL[1],
        ),
        curves.plot(
            [curves.Series("merit", rounds[last], merit[last], dots=True)],
            "Merit after each round",
            "round",
            "merit",
            log_y=_spans(merit),
            width=SMALL[0],
            height=SMALL[1],
        ),
    ]
    known = gap[np.isfinite(gap)]
    end = f", to a relative gap of {number(float(known[-1]), 2)}" if known.size else ""
    many = "one round" if len(last) == 1 else f"{len(last)} rounds"
    end += f", in the worst of the tiles of {int(fused.arrays['tile'])} px" if "tile" in fused.arrays else ""
    return section(
        "Solver", element("div", *plots, class_="plots"), lead=f"{int(steps[-1])} iterations in {many}{end}."
    )


def unwrap(iterations: np.ndarray) -> np.ndarray:
    """Iterations (n,) counted on from round to round when each round starts to count anew."""
    restarts = np.append(False, np.diff(iterations) < 0)
    return iterations + np.cumsum(np.where(restarts, np.append(0, iterations[:-1]), 0))


def _spans(values: np.ndarray) -> bool:
    """Whether values ask for a logarithmic axis: all positive and over a factor of 50 apart."""
    known = finite([values])
    return bool(known.size and known.min() > 0 and known.max() > 50 * known.min())


def _explanation(fused: PicturedMap) -> Markup:
    meaning = (
        "The confidence of a pixel is the precision Λ that its observations earn: high where many views agree with the "
        "fused depth, low where few reach or they scatter. It is relative to the noise scale, so that values compare "
        "between scenes and units, but it is no probability: by default the observations of a pixel deviate by about "
        "the noise scale divided by Λ."
    )
    cite = (
        "To cite: ipcli fuse-depth, after chapter 4 (confidence-driven depth fusion by total generalised variation) "
        "of the PhD thesis “Inverse Problem Theory in Shape and Action Modeling”, with the digest below."
    )
    return section("How to read and cite", element("div", element("p", meaning), element("p", cite), class_="prose"))
