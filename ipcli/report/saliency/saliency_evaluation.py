"""The page of a `saliency-evaluation`: models beside baselines and ceiling, the worth of each feature, and maps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ipcli.report.kit import pictures
from ipcli.report.kit.numbers import DASH
from ipcli.report.kit.page import Markup, figure, gallery, join, meter, notice, section, table
from ipcli.report.kit.page import page as document
from ipcli.report.kit.provenance import origin
from ipcli.report.saliency.overlay import around, dotted, items

TURN = 30.0  # degrees from which surfaces are shown
SUBJECTS = {"pictures": ("fixations", "pixels"), "surfaces": ("vertices that were looked at", "vertices")}


def page(arrays: Mapping[str, np.ndarray], provenance: Mapping[str, object], *, widest: int = pictures.WIDEST) -> str:
    """The HTML of a `saliency-evaluation` artefact; no picture is stored wider than `widest` pixels."""
    points, places = SUBJECTS[str(arrays["subject"])]
    values = dict(
        zip(arrays["measures"].tolist(), arrays["values"][_index(arrays, str(arrays["default"]))], strict=True)
    )
    verdict = (
        f"{len(arrays['items'])} {arrays['subject']}, {int(arrays['looked_at'].sum())} {points}. {arrays['default']} "
        f"ranks what was looked at above {100 * values['AUC']:.1f} % of all {places}; 50 % is chance. "
        f"Protocol: {arrays['protocol']}."
    )
    return document(
        "How well looking is predicted",
        "ipcli saliency-evaluate",
        verdict,
        join(*map(notice, arrays["notes"].tolist())),
        models_table(arrays),
        features_table(arrays),
        *shown_items(arrays, widest),
        origin(provenance),
    )


def _index(arrays: Mapping[str, np.ndarray], name: str) -> int:
    return arrays["predictors"].tolist().index(name)


def _cells(values: np.ndarray) -> list[str]:
    return [DASH if np.isnan(v) else f"{v:.3f}".replace("-", "\N{MINUS SIGN}") for v in values]


def models_table(arrays: Mapping[str, np.ndarray]) -> Markup:
    """All predictors but single features."""
    kept = [k for k, role in enumerate(arrays["roles"]) if role != "feature"]
    rows = [(arrays["predictors"][k], arrays["roles"][k], *_cells(arrays["values"][k])) for k in kept]
    lead = (
        "AUC: share of all places that rank below what was looked at. sAUC: below it among what was looked at "
        "elsewhere, so that a prior of place gains nothing; by area: every vertex counts by its share of the surface. "
        "NSS: standard deviations above the mean. Information gain: bits a fixation over fixations on other pictures. "
        "KL: small is good. The ceiling is what half of the observers say of the others."
    )
    return section("Models, baselines and ceiling", table(("", "role", *arrays["measures"]), rows), lead=lead)


def features_table(arrays: Mapping[str, np.ndarray]) -> Markup:
    """Each feature by itself, the best first."""
    kept = [k for k, role in enumerate(arrays["roles"]) if role == "feature"]
    kept.sort(key=lambda k: -arrays["values"][k, 0])
    rows = [
        (
            arrays["predictors"][k],
            meter(float(arrays["values"][k, 0]), f"{arrays['values'][k, 0]:.3f}"),
            *_cells(arrays["values"][k])[1:],
        )
        for k in kept
    ]
    lead = "Each feature by itself, with the sign that it has: below .500 the places where it is low are looked at."
    return section("What each feature is worth", table(("", *arrays["measures"]), rows), lead=lead)


def shown_items(arrays: Mapping[str, np.ndarray], widest: int) -> list[Markup]:
    """The items that are kept to be shown, each with its fixations and maps."""
    return [_shown(arrays, name, widest) for name in items(arrays, "shown")]


def _shown(arrays: Mapping[str, np.ndarray], name: str, widest: int) -> Markup:
    of, number = f"shown/{name}", arrays["items"].tolist().index(name)
    is_picture = f"{of}/picture" in arrays
    if is_picture:
        truth = pictures.photograph(dotted(arrays[f"{of}/picture"], arrays[f"{of}/fixations"]), widest)
    else:
        truth = _turned(arrays, of, arrays[f"{of}/truth"])
    points = SUBJECTS[str(arrays["subject"])][0]
    figures = [figure(truth, "what was looked at", f"{int(arrays['looked_at'][number])} {points}")]
    for predictor, saliency in zip(arrays[f"{of}/predictors"].tolist(), arrays[f"{of}/maps"], strict=True):
        value = arrays["each"][_index(arrays, predictor), number, 0]
        drawn = pictures.draw(saliency, _scale([saliency])) if is_picture else _turned(arrays, of, saliency[:, 0])
        figures.append(figure(drawn, predictor, f"AUC {value:.3f} here"))
    return section(name, gallery(*figures, columns=4, small=True))


def _turned(arrays: Mapping[str, np.ndarray], of: str, values: np.ndarray) -> pictures.Picture:
    view = around(arrays[f"{of}/points"], arrays[f"{of}/normals"], values, _scale([values]), TURN)
    return pictures.photograph(view)


def _scale(maps: Sequence[np.ndarray]) -> pictures.Scale:
    return pictures.from_zero(maps, "magma")
