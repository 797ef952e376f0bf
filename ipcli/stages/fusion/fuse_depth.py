"""fuse-depth: depth maps of several views -> one depth map of a reference camera with its confidence (thesis chapter
4).
"""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from ipcli import threads
from ipcli.errors import NoSolution, ParameterError
from ipcli.executor import map_items
from ipcli.io.files import h5
from ipcli.io.files.scratch import ScratchFiles
from ipcli.io.views import camera
from ipcli.measurements.names import window
from ipcli.measurements.views import View, Views
from ipcli.models.fusion.assessment import error_table, view_table
from ipcli.models.fusion.checks import convergence_warnings, geometry_warnings
from ipcli.models.fusion.fuse import Fused, fuse
from ipcli.models.fusion.parameters import METHODS, Fusion, Variant
from ipcli.models.fusion.tiles import fuse_in_tiles
from ipcli.params import Run
from ipcli.progress import Progress, silent
from ipcli.stages.fusion.exports import write_mesh, write_turnable
from ipcli.stages.fusion.memory_plan import MemoryPlan
from ipcli.stages.fusion.on_demand import ViewsOnDemand
from ipcli.stages.fusion.parameters import FuseDepth
from ipcli.stages.fusion.sources import middle, open_source, source_files
from ipcli.stages.kit import outputs
from ipcli.stages.kit.artefact import Beside, Job, Outcome, make
from ipcli.stages.kit.pages import page, turning_page
from ipcli.stages.kit.summary import Figure, of_items, of_result

log = logging.getLogger(__name__)
SUMMED_UP = (
    "fused_into", "views", "view_overlap", "observations", "filled", "noise_scale", "unit", "domain", "history",
    "warnings",
)  # fmt: skip
LEAST_OVERLAP = 1e-3  # share of the reference a view other than it must reach to count as overlapping


def run(
    source: Path,
    output: Path,
    params: FuseDepth,
    run: Run,
    progress: Progress = silent,
) -> Outcome:
    """Write the fused map and beside it a mesh (.ply) and a report (.html). NoSolution if no view overlaps the
    reference.
    """
    if params.every or params.step != 1:
        raise ParameterError("--step goes with --all, which fuses into a folder")
    beside = {output.with_suffix(".ply"): write_mesh} | page(output, "fused-depth")
    beside[turning_page(output)] = partial(write_turnable, f"fuse-depth: {output.name}")
    return _fuse(source, output, params, run, beside, progress)


@of_result
def summary(output: Path) -> dict[str, Any]:
    """The few figures a person wants of a fused map."""
    found = h5.read(output, "fused-depth", lambda name: name in SUMMED_UP).arrays
    history, domain = found["history"], str(found["domain"])
    unit = {"disparity": "px", "inverse depth": f"1/{found['unit']}"}.get(domain, str(found["unit"]))
    overlap, scale = found["view_overlap"], float(found["noise_scale"])
    observed, filled = float((found["observations"] > 0).mean()), float((found["filled"] > 0).mean())
    facts: dict[str, Any] = {
        "fused_into": str(found.get("fused_into", "")),
        "views": len(found["views"]),
        "noise": Figure({"scale": scale, "unit": unit, "domain": domain}, f"{scale:.3g} {unit} ({domain})"),
        "overlap": Figure(
            {"least": overlap.min(), "greatest": overlap.max()},
            f"{overlap.min():.0%} to {overlap.max():.0%} of the reference",
        ),
        "observed": Figure(observed, f"{observed:.1%} of the pixels"),
        "filled": Figure(filled, f"{filled:.1%} of the pixels, where no view supports the map"),
    }
    if len(history):
        facts["relative_gap"] = Figure(history[-1, 3], f"{history[-1, 3]:.2g} at the end")
    if "warnings" in found:
        told = found["warnings"].tolist()
        facts["warnings"] = Figure(told, f"{len(told)}, on the page {output.with_suffix('.html').name}")
    return facts


def summary_of_all(folder: Path, outcomes: Mapping[Path, Outcome]) -> dict[str, Any]:
    """The few figures a person wants of the fused maps of a sequence."""
    facts = of_items(folder, outcomes)
    there = [summary(path) for path in outcomes if path.is_file()]
    if not there:
        return facts
    noise = [one["noise"].value for one in there]
    mean = float(np.mean([one["scale"] for one in noise]))
    least, most = (pick(one["scale"] for one in noise) for pick in (min, max))
    unit, domain = noise[0]["unit"], noise[0]["domain"]
    facts["noise"] = Figure(
        {"scale": mean, "unit": unit, "domain": domain},
        f"{mean:.3g} {unit} ({domain}) on average, {least:.3g} to {most:.3g}",
    )
    for name in ("observed", "filled"):
        share = float(np.mean([one[name].value for one in there]))
        facts[name] = Figure(share, f"{share:.1%} of the pixels, on average")
    warned = sum("warnings" in one for one in there)
    return facts | ({"warnings": Figure(warned, f"of {warned} maps")} if warned else {})


def run_all(
    source: Path, folder: Path, params: FuseDepth, run: Run, progress: Progress = silent
) -> dict[Path, Outcome]:
    """Write FOLDER/NAME.fused.h5 for every view, or every `step`-th, each the same as `run` would for that reference.

    Those that are there already, made from the same, are left alone. Raises ItemsFailed at the end when some views
    failed.
    """
    outputs.check_place(folder, folder=True)
    if params.reference or params.camera:
        raise ParameterError("--all takes the views in turn as reference: leave out --reference and --camera")
    names = open_source(source, params.source).names[:: params.step]
    own = replace(params, every=False, step=1)  # which others are fused does not change this one
    one = partial(fuse_into, source=source, folder=folder, params=own, run=run)
    return {_path(folder, name): outcome for name, outcome in map_items(one, names, run.executor, progress).items()}


def fuse_into(reference: str, *, source: Path, folder: Path, params: FuseDepth, run: Run) -> Outcome:
    """Make the fused map of one view of a sequence, with no files beside it."""
    return _fuse(source, _path(folder, reference), replace(params, reference=reference), run)


def _path(folder: Path, name: str) -> Path:
    return folder / f"{name}.fused.h5"


def _fuse(
    source: Path,
    output: Path,
    params: FuseDepth,
    run: Run,
    beside: Mapping[Path, Beside] = MappingProxyType({}),
    progress: Progress = silent,
) -> Outcome:
    views = open_source(source, params.source)
    name = params.reference or middle(views.names)
    names = window(views.names, name, params.window or len(views.names))
    inputs = source_files(views, names) + ((Path(params.camera),) if params.camera else ())
    reference = reference_of(views, name, params)
    plan = MemoryPlan.of(reference, len(names), params.fusion)

    def build() -> dict[str, np.ndarray]:
        plan.say(reference.name)
        if not plan.side:
            return fused_arrays(views, names, reference, params, progress)
        with ScratchFiles(output.parent) as scratch:
            return fused_arrays(views, names, reference, params, progress, plan.side, scratch)

    outcome = make(Job(output, "fused-depth", "fuse-depth", params, inputs, beside), build, run)
    if outcome is Outcome.WOULD_RUN:
        plan.say(reference.name, logging.WARNING)
    return outcome


def reference_of(views: Views, name: str, params: FuseDepth) -> View:
    """The view to fuse into: the one of that name, or the camera that is given."""
    return camera.read(Path(params.camera)) if params.camera else views.load(name)


def fused_arrays(
    source: Views,
    names: Sequence[str],
    reference: View,
    params: FuseDepth,
    progress: Progress,
    side: int = 0,
    scratch: ScratchFiles | None = None,
) -> dict[str, np.ndarray]:
    """The arrays of the `fused-depth` artefact of the views of these names; in tiles of that side by scratch files."""
    domain = source.measured if params.domain == "auto" else params.domain
    inverse = domain == "disparity"
    on_demand = ViewsOnDemand(source, names, reference, scratch)
    views: Sequence[View] = on_demand if side else threads.each(on_demand.__getitem__, range(len(names)))
    warnings = _told(reference.name, geometry_warnings(views, reference))
    if side:
        fused = fuse_in_tiles(
            views, reference, params.fusion, side, inverse=inverse, progress=progress, part=on_demand.part
        )
    else:
        fused = fuse(views, reference, params.fusion, inverse=inverse, progress=progress)
    table = view_table(fused, names, views)
    others = [name != reference.name for name in names]
    if any(others) and not (table["view_overlap"][others] > LEAST_OVERLAP).any():
        raise NoSolution(no_overlap(reference.name, table, source.unit))
    progress(0.9, "writing")
    warnings += _told(reference.name, convergence_warnings(fused.history, params.fusion.solver.tolerance))
    warnings = [*source.notes, *warnings]  # the notes were said when the source was opened
    said = {"warnings": np.array(warnings)} if warnings else {}
    said |= {"tile": np.array(side)} if side else {}
    errors = error_table(fused, reference, source.baseline_focal)
    return map_arrays(fused, reference, source, domain, params.fusion) | table | errors | said


def _told(name: str, warnings: list[str]) -> list[str]:
    """The warnings, which it says on the console."""
    for warning in warnings:
        log.warning("%s: %s", name, warning)
    return warnings


def map_arrays(fused: Fused, reference: View, source: Views, domain: str, fusion: Fusion) -> dict[str, np.ndarray]:
    """The fused map, its camera and how it came to be, by their names in the artefact."""
    factor = source.baseline_focal if domain == "disparity" else None  # tells the noise of inverse depth in pixels
    algorithm = fusion.algorithm if METHODS[fusion.method].adaptive else None
    arrays = {
        "depth": fused.depth,
        "filled": fused.filled,
        "confidence": fused.confidence,
        "uncertainty": fused.uncertainty,
        "normals": fused.normals,
        "observations": fused.observations,
        "mean": fused.mean,
        "median": fused.median,
        "fused_into": np.array(reference.name),
        "reference": reference.depth,
        "intrinsics": reference.intrinsics,
        "cam_from_world": reference.cam_from_world,
        "noise_scale": np.array(fused.noise_scale * (1.0 if factor is None else factor)),
        "history": fused.history,
        "unit": np.array(source.unit),
        "domain": np.array("inverse depth" if domain == "disparity" and factor is None else domain),
        "method": np.array(Variant(fusion.method, algorithm).label),
        "lambda": np.array(fused.lam),
    }
    return arrays | ({} if reference.image is None else {"image": reference.image})


def no_overlap(reference: str, table: Mapping[str, np.ndarray], unit: str) -> str:
    """The message that says, view by view, why nothing could be fused."""
    views = zip(table["views"], table["view_valid"], table["view_overlap"], strict=True)
    each = "; ".join(
        f"{name}: {100 * valid:.0f} % valid, reaches {100 * overlap:.1f} %" for name, valid, overlap in views
    )
    return (
        f"no view overlaps the reference view {reference!r} ({each}). Check the direction of the poses and that depth "
        f"and translation are both in {unit}"
    )
