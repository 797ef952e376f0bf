"""merge-depth: the fused maps of a sequence -> one coloured cloud of what they agree on."""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping, Sequence
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from ipcli.errors import FormatError, ParameterError
from ipcli.io.files import h5, ply
from ipcli.models.fusion.checks import merge_warnings
from ipcli.models.fusion.holes import SEEN
from ipcli.models.fusion.merge import Cloud, FusedMap, depth_noise, merge
from ipcli.params import Run
from ipcli.stages.fusion.exports import write_turnable_cloud
from ipcli.stages.fusion.memory_plan import MergePlan
from ipcli.stages.fusion.parameters import MergeDepth
from ipcli.stages.kit.artefact import Job, Outcome, make
from ipcli.stages.kit.pages import page, turning_page
from ipcli.stages.kit.summary import Figure, of_result

log = logging.getLogger(__name__)
NEEDED = {
    "depth",
    "confidence",
    "normals",
    "observations",
    "filled",
    "intrinsics",
    "cam_from_world",
    "image",
    "view_residual",
    "domain",
}


def run(files: Sequence[Path], output: Path, params: MergeDepth, run: Run) -> Outcome:
    """Write the artefact X.h5, the cloud X.ply and the page X.html for an output X.ply or X.h5; files count in order of
    their paths.

    Raises ParameterError for another suffix, FormatError when files differ in unit, NoSolution when no point is
    confirmed.
    """
    if output.suffix not in (".ply", ".h5"):
        raise ParameterError(
            f"{output}: a cloud is written as X.ply (with X.h5 beside it); got the suffix '{output.suffix}'"
        )
    inputs = tuple(sorted(set(files)))
    beside = {output.with_suffix(".ply"): write_cloud} | page(output, "fusion-cloud")
    beside[turning_page(output)] = partial(write_turnable_cloud, f"merge-depth: {output.with_suffix('.h5').name}")
    job = Job(output.with_suffix(".h5"), "fusion-cloud", "merge-depth", params, inputs, beside)

    plan = MergePlan.of([pixels_of(path) for path in inputs], params.merge)

    def build() -> dict[str, np.ndarray]:
        plan.say(output.name)
        unit, maps = read_unit(inputs), MapsOnDemand(inputs, held=plan.size.held)
        return cloud_arrays(merge(maps, params.merge, plan.most_points), inputs, unit)

    outcome = make(job, build, run)
    if outcome is Outcome.WOULD_RUN:
        plan.say(output.name, logging.WARNING)
    return outcome


@of_result
def summary(output: Path) -> dict[str, Any]:
    """The few figures a person wants of a merged cloud."""
    counted = ("views", "spacing", "unit", "map_points", "map_confirmed", "warnings")
    found = h5.read(output.with_suffix(".h5"), "fusion-cloud", only=lambda name: name in counted).arrays
    spacing, unit, views = float(found["spacing"]), str(found["unit"]), found["views"]
    share = float(found["map_confirmed"].sum() / max(found["map_points"].sum(), 1))
    warnings = found["warnings"].tolist() if "warnings" in found else []
    return {
        "points": len(views),
        "spacing": Figure({"value": spacing, "unit": unit}, f"{spacing:.3g} {unit}"),
        "confirmed": Figure(share, f"{share:.1%} of the pixels of {len(found['map_points'])} maps"),
        "maps_a_point": Figure(float(np.median(views)) if len(views) else None, f"{np.median(views):.0f} (median)"),
        **({"warnings": Figure(warnings, "; ".join(warnings))} if warnings else {}),
    }


class MapsOnDemand(Sequence[FusedMap]):
    """The fused maps of files, read when they are asked for; so many of them are held."""

    def __init__(self, files: Sequence[Path], held: int):
        self._files, self._read = files, lru_cache(maxsize=held)(read_map)

    def __len__(self) -> int:
        return len(self._files)

    def __getitem__(self, index: Any) -> Any:
        return self._read(self._files[index])


def pixels_of(path: Path) -> int:
    """The pixels of the fused map in a file, whose data are left unread."""
    header = h5.peek(path)
    if header.kind != "fused-depth":
        fix = "Give the files of fuse-depth --all"
        raise FormatError(path, "wrong kind of artefact", expected="fused-depth", got=header.kind, fix=fix)
    return math.prod(header.datasets["depth"].shape)


def read_unit(files: Sequence[Path]) -> str:
    """The unit of all files; FormatError is raised for a second one."""
    first, *others = files
    unit = str(h5.read(first, "fused-depth", only=lambda name: name == "unit").arrays["unit"])
    for path in others:
        got = str(h5.read(path, "fused-depth", only=lambda name: name == "unit").arrays["unit"])
        if got != unit:
            raise FormatError(
                path, f"has another unit than {first}", expected=unit, got=got, fix="Fuse all in one unit"
            )
    return unit


def read_map(path: Path) -> FusedMap:
    """The fused map in a `fused-depth` artefact, where observations support it, with the noise of these."""
    arrays = h5.read(path, "fused-depth", only=lambda name: name in NEEDED).arrays
    observed = (arrays["observations"] > 0) & (arrays.get("filled", SEEN) == SEEN)
    depth = np.where(observed, arrays["depth"], np.float32(np.nan))
    noise = depth_noise(depth, arrays["view_residual"], inverse=str(arrays["domain"]) != "depth")
    same = ("confidence", "observations", "normals", "intrinsics", "cam_from_world")
    return FusedMap(depth, noise=noise, image=arrays.get("image"), **{name: arrays[name] for name in same})


def cloud_arrays(cloud: Cloud, files: Sequence[Path], unit: str) -> dict[str, np.ndarray]:
    """The arrays of the `fusion-cloud` artefact: the cloud, and what each map gave to it."""
    points, counts = cloud.points, cloud.counts
    arrays: dict[str, np.ndarray] = {
        "points": points.position.astype(np.float32),
        "normals": points.normal.astype(np.float32),
        "confidence": points.confidence.astype(np.float32),
        "views": points.views.astype(np.uint16),
        "spacing": np.array(cloud.spacing, np.float64),
        "maps": np.array([path.name for path in files]),
        "cam_from_world": cloud.cam_from_world,
        "map_points": counts[:, 0],
        "map_confirmed": counts[:, 1],
        "map_contradicted": counts[:, 2],
        "unit": np.array(unit),
    }
    if warnings := merge_warnings([path.name for path in files], cloud.cam_from_world, cloud.depths, counts):
        arrays["warnings"] = np.array(warnings)
    for warning in warnings:
        log.warning("%s", warning)
    return arrays | ({} if points.color is None else {"colors": points.color})


def write_cloud(path: Path, arrays: Mapping[str, np.ndarray], provenance: Mapping[str, Any]) -> None:
    """Write the cloud as PLY, for other programs."""
    ply.write(
        path,
        arrays["points"],
        normals=arrays["normals"],
        colors=arrays.get("colors"),
        extra={name: arrays[name] for name in ("confidence", "views")},
        comments=(f"ipcli merge-depth, unit {arrays['unit']}, digest {provenance['digest']}",),
    )
