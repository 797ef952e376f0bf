"""saliency: a posed recording, with gaze or a learnt function -> saliency of points, maps, proto-objects (3.3, 3.4)."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ipcli.errors import FormatError
from ipcli.io.files import atomic, h5, ply
from ipcli.io.meshes import turntable
from ipcli.io.saliency.posed import open_posed, read_cloud
from ipcli.measurements.subsequences import over_cloud
from ipcli.models.saliency import scene
from ipcli.models.saliency.classifier import Learnt
from ipcli.params import Run
from ipcli.progress import Progress, silent
from ipcli.report.kit.pictures import palette
from ipcli.report.saliency.membranes import turnable
from ipcli.report.saliency.saliency import SALIENCY
from ipcli.stages.kit.artefact import Job, Outcome, make
from ipcli.stages.kit.pages import page, turning_page
from ipcli.stages.kit.summary import Figure, of_result
from ipcli.stages.saliency.parameters import Saliency as Params

log = logging.getLogger(__name__)
KIND = "saliency"
TURNED = 40_000  # points of the cloud that is turned
GREEN = (60, 190, 90)


def run(source: Path, output: Path, params: Params, run: Run, progress: Progress = silent) -> Outcome:
    """Write the artefact; beside it a PLY, a table of proto-objects, a page, and cloud and membranes to be turned.

    NoSolution when no part of the recording has a surface.
    """
    sequence = open_posed(source, params.format)
    if params.cloud:
        sequence = over_cloud(sequence, read_cloud(Path(params.cloud)), (Path(params.cloud),))
    models = tuple(Path(name.strip()) for name in params.model.split(",") if name.strip())
    given = [_model(path) for path in models]

    def build() -> dict[str, np.ndarray]:
        found = scene.saliency(sequence, params.scene, given, run.seed, progress)
        for note in found["notes"]:
            log.warning("%s: %s", source, note)
        return found

    beside = {output.with_suffix(".ply"): write_ply, output.with_suffix(".objects.csv"): write_objects}
    beside |= {
        output.with_suffix(".membranes.html"): write_membranes,
        turning_page(output): partial(write_turnable, f"saliency: {output.name}"),
    }
    job = Job(output, KIND, "saliency", params, (*sequence.files, *models), beside | page(output, KIND))
    return make(job, build, run)


def _model(path: Path) -> Learnt:
    found = scene.model_of(h5.read(path, KIND, only=lambda name: name.startswith("model/")).arrays)
    if found is None:
        raise FormatError(path, "nothing was learnt there", fix="Give a result of saliency on a recording with gaze")
    return found


def write_ply(path: Path, a: Mapping[str, np.ndarray], provenance: Mapping[str, Any]) -> None:
    """Points coloured by their saliency, which is a property too, as are energy, curvature and who looked."""
    names = ("saliency", "energy", "attended", "curvature")
    ply.write(
        path,
        a["points/places"],
        colors=_coloured(a["points/saliency"]),
        extra={name: a[f"points/{name}"] for name in names},
        comments=(f"ipcli saliency, unit m, digest {provenance['digest']}",),
    )


def write_membranes(path: Path, a: Mapping[str, np.ndarray], provenance: Mapping[str, Any]) -> None:
    """The membranes of the strongest proto-objects, to be turned and run in time."""
    atomic.write_text(path, turnable(a))


def write_turnable(title: str, path: Path, a: Mapping[str, np.ndarray], provenance: Mapping[str, Any]) -> None:
    """The cloud coloured by saliency, to be turned, with proto-objects as green spheres of dots."""
    import trimesh

    chosen = slice(None, None, max(1, len(a["points/places"]) // TURNED))
    parts = [(a["points/places"][chosen], _coloured(a["points/saliency"][chosen]))]
    ball = trimesh.creation.icosphere(3, float(a["radius"])).vertices
    for track in np.unique(a["objects/track"]):
        place = a["objects/places"][a["objects/track"] == track].mean(axis=0)
        parts.append((place + ball, np.tile(np.array(GREEN, np.uint8), (len(ball), 1))))
    places = np.concatenate([p for p, _ in parts]) @ turntable.UPRIGHT
    scene = turntable.cloud_scene(places, np.concatenate([c for _, c in parts]))
    low, high = (tuple(_coloured(np.array([value]))[0].tolist()) for value in (SALIENCY.low, SALIENCY.high))
    legend = {"hardly salient": low, "salient": high, "proto-objects": GREEN}
    start = turntable.looking_from(places, np.array([0.0, 0.35, 1.0]))
    about = "The points of the scene by their saliency, first seen from behind the first picture."
    atomic.write_text(path, turntable.turning_page(scene, title, about, legend, from_camera=start))


def _coloured(saliency: np.ndarray) -> np.ndarray:
    """RGB (n, 3) uint8 of values (n,), as the page has them."""
    return palette(SALIENCY.palette)[SALIENCY.indices(saliency[None])[0]]


def write_objects(path: Path, a: Mapping[str, np.ndarray], provenance: Mapping[str, Any]) -> None:
    """A line a proto-object: where, when, how strong, of which track, and whether somebody looked."""
    lines = ["x [m],y [m],z [m],radius [m],from [s],to [s],subsequence,track,energy,saliency,looked at"]
    for n, place in enumerate(a["objects/places"]):
        looked = {2: "yes", 1: "at another time", 0: "no"}.get(int(a["objects/hit"][n]), "")
        cells = [*(f"{value:.4f}" for value in (*place, float(a["radius"]), *a["objects/times"][n]))]
        cells += [str(a["objects/subsequence"][n]), str(a["objects/track"][n])]
        cells += [f"{a['objects/energy'][n]:.6g}", f"{a['objects/saliency'][n]:.4f}", looked]
        lines.append(",".join(cells))
    atomic.write_text(path, "\n".join(lines) + "\n")


@of_result
def summary(output: Path) -> dict[str, object]:
    """The figures that a person wants to see at once."""
    wanted = ("objects/track", "hits", "folds/rates", "subsequences/regards")
    a = h5.read(output, KIND, only=lambda name: name in wanted).arrays
    facts: dict[str, object] = {"subsequences": len(a["subsequences/regards"])}
    facts |= {"proto-objects": len(a["objects/track"]), "places": len(np.unique(a["objects/track"]))}
    if "folds/rates" in a:
        facts["balanced error rate"] = round(float(np.nanmean(a["folds/rates"][:, 4])), 4)
    if np.isfinite(a["hits"]).all():
        share, chance = a["hits"][1].tolist()
        facts["looked at"] = Figure(
            {"share": share, "by_chance": chance}, f"{share:.0%} of proto-objects, {chance:.0%} by chance"
        )
    else:
        facts["looked at"] = Figure(None, "not known, as there are no points of regard")
    return facts
