"""The page of a `brdf-object`: picture, normals, the relief to look at from all sides, light and material, errors."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ipcli.report.brdf import relief
from ipcli.report.kit import pictures
from ipcli.report.kit.numbers import number, percent
from ipcli.report.kit.page import Markup, element, figure, gallery, meter, notice, section, table
from ipcli.report.kit.page import page as document
from ipcli.report.kit.provenance import origin

TIED = 0.1  # difference of the two energies over their mean below which one picture does not tell
OPEN = (0.1, 0.9)  # probabilities of a cut edge between which both answers are shown
FLAT = 0.01  # of the mean brightness: a picture that varies less says nothing
BURNT = 0.3  # share of saturated pixels from which on little of the shading is left
BRIGHT = 0.02  # share of saturated pixels that is worth a word
POORLY = 0.12  # mean residual, in bright values of the picture, from which the light explains the picture poorly


def page(arrays: Mapping[str, np.ndarray], provenance: Mapping[str, object], *, widest: int = pictures.WIDEST) -> str:
    """The HTML of a `brdf-object` artefact."""
    box = _box(arrays["mask"] > 0)
    shown = {name: array[box] if array.shape[:2] == arrays["mask"].shape else array for name, array in arrays.items()}
    return document(
        "The surface in one photograph",
        "ipcli brdf-model",
        _verdict(arrays),
        relief.style(),
        *map(notice, warnings(arrays)),
        _pictures(shown, widest),
        _relief(shown),
        _both(shown),
        _light(arrays),
        *([_errors(shown, widest)] if "metrics" in arrays else []),
        origin(provenance),
    )


def _box(mask: np.ndarray) -> tuple[slice, slice]:
    rows, columns = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
    pad = 4
    return slice(max(rows[0] - pad, 0), rows[-1] + 1 + pad), slice(max(columns[0] - pad, 0), columns[-1] + 1 + pad)


def _verdict(arrays: Mapping[str, np.ndarray]) -> str:
    unit, height = str(arrays["unit"]), arrays["height"]
    rise = float(np.nanpercentile(height, 99) - np.nanpercentile(height, 1)) * float(arrays["pixel_size"])
    text = f"{outline(arrays)}. The relief is {number(rise)} {unit} deep"
    if "metrics" in arrays:
        mean = float(arrays["metrics"][0, 0])
        text += f"; its normals err by {number(np.degrees(mean))}° on average"
    return text + ". Orthographic view is assumed."


def outline(arrays: Mapping[str, np.ndarray]) -> str:
    """What the outline was taken for, with the probability of a cut edge."""
    sheet = float(arrays["sheet"])
    if is_open(arrays):
        kind = "may be an occluding rim or a cut edge: a solid and a sheet, averaged"
    else:
        kind = "is taken for " + ("an occluding rim: a solid" if sheet < 0.5 else "a cut edge: a sheet")
    return f"The outline {kind} (probability of a cut edge {number(sheet, 2)})"


def is_open(arrays: Mapping[str, np.ndarray]) -> bool:
    """Whether picture and outline leave open what the outline is."""
    return OPEN[0] < float(arrays["sheet"]) < OPEN[1]


def is_tied(arrays: Mapping[str, np.ndarray]) -> bool:
    """Whether a bump and a dent explain the picture equally well."""
    return abs(float(arrays["tie"])) < TIED


def is_poor(arrays: Mapping[str, np.ndarray]) -> bool:
    """Whether the best surface, light and material leave much of the picture unexplained."""
    return float(arrays["residual"]) > POORLY


def doubts(arrays: Mapping[str, np.ndarray]) -> list[str]:
    """What is unusual about this picture and makes its surface doubtful: for the console and for the page."""
    mask, found = arrays["mask"] > 0, []
    along = int(mask[[0, -1]].sum() + mask[1:-1, [0, -1]].sum())
    if along:
        found.append(
            f"the mask runs along {along} pixels of the picture's border: that cut is taken for an outline, and the "
            "surface bends away there"
        )
    light = arrays["intensity"][np.isfinite(arrays["intensity"])]
    if float(np.std(light)) < FLAT * float(np.mean(light)):
        found.append("the object has one brightness all over: nothing in the picture tells its shape or material")
    elif float(arrays["saturated"]) > BURNT:
        found.append(
            f"{percent(float(arrays['saturated']))} of the object is saturated, so that the picture hardly tells its "
            "shape and material: a shorter exposure does"
        )
    if is_poor(arrays):
        found.append(
            f"one material under one light explains the picture poorly (residual "
            f"{number(float(arrays['residual']), 2)}): it may be painted, translucent or lit from near, and the "
            f"material is but the likeliest of the {len(arrays['materials'])} of the library"
        )
    if is_open(arrays):
        found.append("it is open whether the outline is a rim or a cut edge; --rim solid or --rim sheet decides")
    return found


def warnings(arrays: Mapping[str, np.ndarray]) -> list[str]:
    """What a user of this surface should know before trusting it."""
    found = []
    if is_tied(arrays):
        found.append(
            "this picture does not tell convex from concave: both explain it equally well "
            f"(energies differ by {percent(abs(float(arrays['tie'])))}). --relief convex, concave or light-above (what "
            "is lit from above stands out) decides"
        )
    found += doubts(arrays)
    if BRIGHT < float(arrays["saturated"]) <= BURNT:
        found.append(
            f"{percent(float(arrays['saturated']))} of the object is saturated; a shorter exposure would tell more"
        )
    return found


def _pictures(shown: Mapping[str, np.ndarray], widest: int) -> Markup:
    bright = pictures.Scale(0.0, 1.4, "clay", "")
    figures = [
        figure(pictures.photograph(shown["picture"], widest), "Photograph"),
        figure(
            pictures.draw(shown["intensity"], bright, widest),
            "Brightness",
            "linear, 1 is its 95th percentile",
            scale=bright,
        ),
        figure(
            pictures.draw(shown["shading"], bright, widest),
            "Brightness explained",
            "surface under the light found",
            scale=bright,
        ),
        figure(
            pictures.photograph(relief.as_colours(shown["normals"]), widest),
            "Normals",
            "red right, green up, blue to the viewer",
        ),
        figure(
            pictures.photograph(relief.as_colours(_normals_of(shown)), widest),
            "Normals it set out from",
            "the balloon of the outline",
        ),
        _confidence(shown, widest),
    ]
    return section("Picture and normals", gallery(*figures, columns=3))


def _normals_of(shown: Mapping[str, np.ndarray]) -> np.ndarray:
    return normals(shown["initial_height"])


def normals(height: np.ndarray) -> np.ndarray:
    """Unit normals (h, w, 3) by central differences of a height (h, w), y up; NaN where neighbours are missing."""
    q, p = np.gradient(height.astype(np.float64))
    m = np.stack([-p, q, np.ones_like(p)], axis=-1)
    return m / np.linalg.norm(m, axis=-1, keepdims=True)


def _confidence(shown: Mapping[str, np.ndarray], widest: int) -> Markup:
    scale = pictures.Scale(0.5, 1.0, "viridis", "")
    return figure(
        pictures.draw(shown["confidence"], scale, widest), "Confidence", "agreement of the explanations", scale=scale
    )


def _relief(shown: Mapping[str, np.ndarray]) -> Markup:
    height, normal = shown["height"].astype(np.float64), shown["normals"].astype(np.float64)
    unit = str(shown["unit"])
    scale = pictures.robust([height * float(shown["pixel_size"])], "turbo", unit)
    films = [
        relief.film(relief.going_round(normal), "Under a lamp that goes round"),
        relief.film(relief.swinging(height, normal), "Turned from side to side"),
        relief.film(relief.swinging(height, normal, shown["picture"]), "The same in its own colours"),
        figure(pictures.draw(height * float(shown["pixel_size"]), scale), "Height", "towards the viewer", scale=scale),
        figure(pictures.photograph(relief.seen(height, normal, -60.0)), "From the left"),
        figure(pictures.photograph(relief.seen(height, normal, 60.0)), "From the right"),
    ]
    lead = "The mesh (.ply), the printable relief (.stl) and the normal map (.normals.png) lie beside this page."
    return section("Relief", gallery(*films, columns=3), lead=lead)


def _both(shown: Mapping[str, np.ndarray]) -> Markup:
    """The two answers, where both were worked out."""
    if "solid_height" not in shown or "sheet_height" not in shown:
        return Markup("")
    parts = []
    share = float(shown["sheet"])
    for key, name, weight in (("solid_height", "As a solid", 1 - share), ("sheet_height", "As a sheet", share)):
        height = shown[key].astype(np.float64)
        parts += [
            figure(
                pictures.photograph(relief.as_colours(normals(height))),
                f"{name}: normals",
                f"weight {number(weight, 2)}",
            ),
            figure(pictures.photograph(relief.seen(height, normals(height), -35.0)), f"{name}: relief"),
        ]
    return section(
        "Two answers",
        gallery(*parts, columns=4),
        lead="One picture leaves open what the outline is; these were averaged.",
    )


def _light(arrays: Mapping[str, np.ndarray]) -> Markup:
    above = "from above" if arrays["light_above"] else "from below"
    sphere = figure(
        pictures.photograph(relief.ball(arrays["reflectance"].astype(np.float64))),
        "Light and material",
        f"a ball under it; light {above}",
    )
    rim = [
        (str(name), number(float(value)))
        for name, value in zip(arrays["rim_features"], arrays["rim_values"], strict=True)
    ]
    parts = [
        element("div", sphere, class_="half"),
        _posterior("Material, of those in the library", arrays["materials"], arrays["material_posterior"]),
    ]
    if np.isfinite(arrays["probe_posterior"]).all():
        parts.append(_posterior("Light probe", arrays["probes"], arrays["probe_posterior"]))
    parts.append(table(("What the judge of rims saw", "value"), rim))
    return section("Light, material, outline", element("div", *parts, class_="beside"))


def _posterior(title: str, names: np.ndarray, shares: np.ndarray, most: int = 8) -> Markup:
    order = np.argsort(-shares, kind="stable")[:most]
    return table(
        (title, "probability"), [(str(names[i]), meter(float(shares[i]), percent(float(shares[i])))) for i in order]
    )


def _errors(shown: Mapping[str, np.ndarray], widest: int) -> Markup:
    rows = [
        (str(name), *(number(float(v)) for v in line))
        for name, line in zip(shown["metric_rows"], shown["metrics"], strict=True)
    ]
    best = {
        (int(np.nanargmin(column)), k + 1) for k, column in enumerate(shown["metrics"].T) if np.isfinite(column).any()
    }
    parts = [table(("Surface", *map(str, shown["metric_columns"])), rows, bold=best)]
    truth = shown.get("truth_normals", _true_normals(shown))
    with np.errstate(invalid="ignore"):
        off = np.degrees(np.arccos(np.clip((truth * shown["normals"]).sum(axis=-1), -1, 1)))
    scale = pictures.Scale(0.0, 60.0, "magma", "°")
    figures = [
        figure(pictures.photograph(relief.as_colours(truth)), "True normals"),
        figure(pictures.photograph(relief.as_colours(shown["normals"])), "Normals found"),
        figure(pictures.draw(off, scale, widest), "Angle between them", scale=scale),
    ]
    lead = (
        "N-MAE is the mean angle between normals, Z-MAE the mean distance of heights from their median "
        "difference; flat and inflation need no picture."
    )
    return section("Errors", *parts, gallery(*figures, columns=3), lead=lead)


def _true_normals(shown: Mapping[str, np.ndarray]) -> np.ndarray:
    return normals(shown["truth_height"]) if "truth_height" in shown else shown["normals"]
