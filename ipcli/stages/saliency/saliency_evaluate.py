"""saliency-evaluate: how well recorded fixations are predicted: by what was learnt, by features, by baselines."""

from __future__ import annotations

import csv
import io
import logging
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ipcli.io.files import atomic, h5
from ipcli.measurements.fixations import FixationSet
from ipcli.models.saliency import image_model, validation, vertex_model
from ipcli.models.saliency.channels import shrunk
from ipcli.models.saliency.validation import Case, Row
from ipcli.params import Run
from ipcli.progress import Progress, portion, silent
from ipcli.stages.kit.artefact import Job, Outcome, make
from ipcli.stages.kit.pages import page
from ipcli.stages.kit.summary import Figure, of_result
from ipcli.stages.saliency import sets
from ipcli.stages.saliency.parameters import SaliencyEvaluate
from ipcli.stages.saliency.saliency_predict import predictor_of

KIND = "saliency-evaluation"
log = logging.getLogger(__name__)
WIDTH = 480  # pixels of the pictures that are kept to be shown


def run(
    paths: Sequence[Path],
    output: Path,
    model: Path | None,
    params: SaliencyEvaluate,
    run: Run,
    progress: Progress = silent,
) -> Outcome:
    """Write the figures and beside them a table (.csv) and a page (.html)."""
    places = tuple(paths)
    beside = {output.with_suffix(".csv"): write_csv} | page(output, KIND)
    files = (*sets.inputs(places), *([model] if model else []))
    job = Job(output, KIND, "saliency-evaluate", params, files, beside, partial(look, places, model))
    return make(job, lambda: evaluated(sets.read(places), model, params, run, progress), run)


def look(places: tuple[Path, ...], model: Path | None) -> None:
    """Open the sets and the model; raises what evaluating them raises there."""
    known = sets.read(places)
    predictor_of(model, "surfaces" if known.surfaces else "pictures")


def evaluated(
    known: FixationSet, model: Path | None, params: SaliencyEvaluate, run: Run, progress: Progress
) -> dict[str, np.ndarray]:
    """The arrays of the `saliency-evaluation` artefact."""
    if known.surfaces:
        return of_surfaces(known, model, params, run, progress)
    return of_pictures(known, model, params, run, progress)


def of_pictures(
    known: FixationSet, model: Path | None, params: SaliencyEvaluate, run: Run, progress: Progress
) -> dict[str, np.ndarray]:
    """The arrays of pictures."""
    cases = sets.cases(known.pictures, run.executor, portion(progress, 0.0, 0.4))
    learnt = _learnt(cases, model, params, run, portion(progress, 0.4, 0.7))
    found = validation.rows(cases, learnt, params.validation, portion(progress, 0.7, 1.0))
    names, counts = [c.name for c in cases], np.array([len(c.fixations) for c in cases], np.int64)
    told = protocol(model, len(cases), params.validation.folds, "picture")
    arrays = table(found, counts, names, "pictures", told, overlap(model, names))
    arrays |= {"measures": np.array(validation.MEASURES), "values": validation.totals(arrays["each"], counts)}
    chosen = np.linspace(0, len(cases) - 1, min(params.shown, len(cases))).round().astype(int)
    for index in chosen:
        arrays |= shown_picture(known.pictures[index].read(), cases[index], found, int(index))
    return arrays


def of_surfaces(
    known: FixationSet, model: Path | None, params: SaliencyEvaluate, run: Run, progress: Progress
) -> dict[str, np.ndarray]:
    """The arrays of surfaces."""
    cases = sets.surface_cases(known.surfaces, run.executor, portion(progress, 0.0, 0.3))
    names = [c.name for c in cases]
    if model is not None:
        predictor = predictor_of(model, "surfaces")
        learnt = {model.name: [vertex_model.predicted(predictor, c.features) for c in cases]} if predictor else {}
    elif len(cases) > 1:
        tell = portion(progress, 0.3, 0.9)
        learnt = vertex_model.cross_validated(cases, params.learning, params.validation, run.seed, tell)
    else:
        learnt = {}
    found = vertex_model.worth(cases, learnt, portion(progress, 0.9, 1.0))
    told = protocol(model, len(cases), params.validation.folds, "surface")
    counts = np.array([int(c.looked_at.sum()) for c in cases], np.int64)
    arrays = table(found, counts, names, "surfaces", told, overlap(model, names))
    arrays |= {"measures": np.array(vertex_model.MEASURES), "values": np.nanmean(arrays["each"], axis=1)}
    for index in np.linspace(0, len(cases) - 1, min(params.shown, len(cases))).round().astype(int):
        arrays |= shown_surface(known, cases[int(index)], found, int(index))
    return arrays


def _learnt(
    cases: Sequence[Case], model: Path | None, params: SaliencyEvaluate, run: Run, tell: Progress
) -> dict[str, list[np.ndarray]]:
    """Maps of learnt models by name."""
    predictor = predictor_of(model, "pictures")
    if model is not None and predictor is not None:
        return {model.name: [image_model.predicted(predictor, c.channels) for c in cases]}
    if len(cases) < 2:
        return {}
    return validation.cross_validated(cases, params.learning, params.validation, run.seed, tell)


def protocol(model: Path | None, count: int, folds: int, what: str) -> str:
    """How learnt models are kept from what they are judged by."""
    if model is not None:
        return f"learnt before: {model.name}"
    if count < 2:
        return f"nothing is learnt: one {what} alone cannot be learnt from and judged by"
    return f"{min(folds, count)} folds by {what}: none is judged by a model that was learnt from it"


def overlap(model: Path | None, names: Sequence[str]) -> list[str]:
    """A note where a model was learnt from what it is judged by."""
    if model is None:
        return []
    own = set(h5.read(model, "saliency-model", lambda name: name == "items").arrays["items"].tolist())
    both = len(own & set(names))
    if both:
        log.warning("%s: learnt from %d of the %d it is judged by: the figures are too good", model, both, len(names))
    return [f"The model was learnt from {both} of {len(names)}, by their names: too good there."] if both else []


def table(
    found: Sequence[Row], counts: np.ndarray, names: Sequence[str], subject: str, protocol: str, notes: Sequence[str]
) -> dict[str, np.ndarray]:
    """The figures of each item as arrays, and what there is to know about them."""
    return {
        "subject": np.array(subject),
        "protocol": np.array(protocol),
        "predictors": np.array([row.name for row in found]),
        "roles": np.array([row.role for row in found]),
        "items": np.array(names),
        "each": np.stack([row.each for row in found]),
        "looked_at": counts,
        "default": np.array(found[0].name),
        "notes": np.array(list(notes), dtype=np.str_) if notes else np.array([], "<U1"),
    }


def shown_picture(picture: np.ndarray, one: Case, found: Sequence[Row], index: int) -> dict[str, np.ndarray]:
    """A picture with its fixations and the maps of all but single features."""
    kept = [row for row in found if row.role != "feature"]
    size = np.array(one.shape[::-1])
    return {
        f"shown/{one.name}/picture": shrunk(picture, WIDTH),
        f"shown/{one.name}/fixations": ((one.fixations + 0.5) / size).astype(np.float32),
        f"shown/{one.name}/predictors": np.array([row.name for row in kept]),
        f"shown/{one.name}/maps": np.stack([image_model.relative(row.maps[index]) for row in kept]),
    }


def shown_surface(
    known: FixationSet, one: vertex_model.SurfaceCase, found: Sequence[Row], index: int
) -> dict[str, np.ndarray]:
    """A surface, how long it was looked at, and the maps of all but single features."""
    surface = known.surfaces[index]
    kept = [row for row in found if row.role != "feature"]
    return {
        f"shown/{one.name}/points": surface.vertices.astype(np.float32),
        f"shown/{one.name}/normals": surface.normals.astype(np.float32),
        f"shown/{one.name}/truth": surface.attention.astype(np.float32),
        f"shown/{one.name}/predictors": np.array([row.name for row in kept]),
        f"shown/{one.name}/maps": np.stack([image_model.relative(row.maps[index]) for row in kept])[..., None],
    }


def write_csv(path: Path, arrays: Mapping[str, np.ndarray], provenance: Mapping[str, Any]) -> None:
    """The table of all predictors, a line each."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["predictor", "role", *arrays["measures"].tolist()])
    for name, role, values in zip(arrays["predictors"], arrays["roles"], arrays["values"], strict=True):
        writer.writerow([name, role, *("" if np.isnan(v) else f"{v:.5f}" for v in values)])
    atomic.write_text(path, text.getvalue())


@of_result
def summary(output: Path) -> dict[str, Any]:
    """The figures of all but single features."""
    arrays = h5.read(output, KIND, lambda name: not name.startswith(("shown/", "each"))).arrays
    facts: dict[str, Any] = {}
    for name, role, values in zip(arrays["predictors"], arrays["roles"], arrays["values"], strict=True):
        if role != "feature":
            pairs = zip(arrays["measures"].tolist(), values.tolist(), strict=True)
            told = {measure: value for measure, value in pairs if value == value}
            facts[str(name)] = Figure(told, ", ".join(f"{measure} {value:.3f}" for measure, value in told.items()))
    return facts
