"""fuse-depth: depth maps of several views -> one depth map of a reference camera with its confidence (thesis chapter
4).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from ipcli.errors import NoSolution, ParameterError
from ipcli.models.fusion.parameters import Fusion
from ipcli.params import Run, option
from ipcli.progress import Progress, silent
from ipcli.stages.fusion.sources import Source, open_source, source_files

if TYPE_CHECKING:
    import numpy as np

    from ipcli.measurements.views import View
    from ipcli.measurements.views import Views as Views
    from ipcli.models.fusion.fuse import Fused
    from ipcli.stages.kit.artefact import Beside, Outcome

THUMBNAIL = 160  # pixels along the longer side
LEAST_OVERLAP = 1e-3  # share of the reference a view other than it must reach to count as overlapping


@dataclass(frozen=True)
class Params:
    """Which views to fuse into which, and how."""

    reference: str | None = option(None, "View to fuse into; the middle one if not given.", flag="--reference")
    camera: str | None = option(
        None,
        "TOML file of a camera to fuse into instead; the reference is then but the middle of the window.",
        flag="--camera",
    )
    window: int = option(0, "Views to fuse around the reference; 0: all.", flag="--window", low=0)
    every: bool = option(False, "Fuse into every view in turn; the output is a folder.", flag="--all")
    step: int = option(1, "With --all: only every so many-th view.", flag="--step", low=1)
    domain: str = option(
        "auto",
        "Quantity to regularise; auto: the one whose noise is homogeneous. Planes are affine in disparity.",
        flag="--domain",
        choices=("auto", "depth", "disparity"),
    )
    fusion: Fusion = field(default_factory=Fusion)
    source: Source = field(default_factory=Source)


def run(
    source: Path,
    output: Path,
    params: Params,
    run: Run,
    progress: Progress = silent,
) -> Outcome:
    """Write the fused map and beside it a mesh (.ply) and a report (.html). NoSolution if no view overlaps the
    reference.
    """
    if params.every or params.step != 1:
        raise ParameterError("--step goes with --all, which fuses into a folder")
    from ipcli.stages.kit.pages import page

    beside = {output.with_suffix(".ply"): write_mesh} | page(output, "fused-depth")
    return _fuse(source, output, params, run, beside, progress)


def run_all(source: Path, folder: Path, params: Params, run: Run, progress: Progress = silent) -> dict[Path, Outcome]:
    """Write FOLDER/NAME.fused.h5 for every view, or every `step`-th, each the same as `run` would for that reference.

    Those that are there already, made from the same, are left alone. Raises ItemsFailed at the end when some views
    failed.
    """
    from ipcli.executor import map_items
    from ipcli.stages.kit import outputs

    outputs.check_place(folder, folder=True)
    if params.reference or params.camera:
        raise ParameterError("--all takes the views in turn as reference: leave out --reference and --camera")
    names = open_source(source, params.source).names[:: params.step]
    own = replace(params, every=False, step=1)  # which others are fused does not change this one
    one = partial(fuse_into, source=source, folder=folder, params=own, run=run)
    return {_path(folder, name): outcome for name, outcome in map_items(one, names, run.executor, progress).items()}


def fuse_into(reference: str, *, source: Path, folder: Path, params: Params, run: Run) -> Outcome:
    """Make the fused map of one view of a sequence, with no files beside it."""
    return _fuse(source, _path(folder, reference), replace(params, reference=reference), run)


def _path(folder: Path, name: str) -> Path:
    return folder / f"{name}.fused.h5"


def _fuse(
    source: Path,
    output: Path,
    params: Params,
    run: Run,
    beside: Mapping[Path, Beside] = MappingProxyType({}),
    progress: Progress = silent,
) -> Outcome:
    from ipcli.measurements.names import window
    from ipcli.stages.kit.artefact import Job, make

    sequence = open_source(source, params.source)
    reference = params.reference or sequence.names[(len(sequence.names) - 1) // 2]
    names = window(sequence.names, reference, params.window or len(sequence.names))
    inputs = source_files(sequence, names) + ((Path(params.camera),) if params.camera else ())

    def build() -> dict[str, np.ndarray]:
        return fused_artefact(sequence, names, reference, params, progress)

    return make(Job(output, "fused-depth", "fuse-depth", params, inputs, beside), build, run)


def fused_artefact(
    sequence: Views,
    names: Sequence[str],
    reference_name: str,
    params: Params,
    progress: Progress,
) -> dict[str, np.ndarray]:
    """The arrays of the `fused-depth` artefact."""
    from ipcli import threads
    from ipcli.io.views import camera
    from ipcli.models.fusion.fuse import fuse
    from ipcli.models.fusion.tiles import fuse_in_tiles, side_of_tiles

    reference = camera.read(Path(params.camera)) if params.camera else sequence.load(reference_name)
    domain = sequence.measured if params.domain == "auto" else params.domain
    views, inverse = Loading(sequence, names, reference), domain == "disparity"
    side = side_of_tiles(params.fusion, reference.depth.shape, len(names))
    if side:
        fused = fuse_in_tiles(views, reference, params.fusion, side, inverse=inverse, progress=progress)
    else:
        views = threads.each(lambda k: views[k], range(len(names)))
        fused = fuse(views, reference, params.fusion, inverse=inverse, progress=progress)
    table = view_table(fused, names, views)
    others = [name != reference.name for name in names]
    if any(others) and not (table["view_overlap"][others] > LEAST_OVERLAP).any():
        raise NoSolution(no_overlap(reference.name, table, sequence.unit))
    progress(0.9, "writing")
    return (
        described(fused, reference, sequence, domain, params)
        | table
        | judged(fused, reference, sequence.baseline_focal)
    )


class Loading(Sequence):
    """The views of these names (K), each read when it is asked for; without pictures, but for the reference, which is
    at hand.
    """

    def __init__(self, sequence: Views, names: Sequence[str], reference: View):
        self.sequence, self.names, self.reference = sequence, names, reference

    def __len__(self) -> int:
        return len(self.names)

    def __getitem__(self, k: int) -> View:
        if not 0 <= k < len(self.names):
            raise IndexError(k)
        name = self.names[k]
        return self.reference if name == self.reference.name else self.sequence.load(name, pictures=False)


def described(fused: Fused, reference: View, sequence: Views, domain: str, params: Params) -> dict[str, np.ndarray]:
    """The fused map, its camera and how it came to be."""
    import numpy as np

    in_pixels = domain == "disparity" and sequence.baseline_focal is not None
    adaptive = f" ({params.fusion.algorithm})" if "adapt" in params.fusion.method else ""
    arrays = {
        "depth": fused.depth,
        "confidence": fused.confidence,
        "uncertainty": fused.uncertainty,
        "normals": fused.normals,
        "observations": fused.observations,
        "mean": fused.mean,
        "median": fused.median,
        "reference": reference.depth,
        "intrinsics": reference.intrinsics,
        "cam_from_world": reference.cam_from_world,
        "noise_scale": np.float64(fused.noise_scale * (sequence.baseline_focal if in_pixels else 1.0)),
        "history": fused.history,
        "unit": np.array(sequence.unit),
        "domain": np.array("inverse depth" if domain == "disparity" and not in_pixels else domain),
        "method": np.array(params.fusion.method + adaptive),
        "lambda": np.float64(fused.lam),
    }
    return arrays | ({} if reference.image is None else {"image": reference.image})


def view_table(fused: Fused, names: Sequence[str], views: Sequence[View]) -> dict[str, np.ndarray]:
    """What each view gave: its valid share, the share of the reference it reached and how far it is from the
    fused map.
    """
    import numpy as np

    from ipcli import threads

    depth = fused.depth[:: fused.every, :: fused.every]

    def residual(layer: np.ndarray) -> float:
        hit = np.isfinite(layer) & np.isfinite(depth)
        return float(np.median(np.abs(layer[hit] - depth[hit]))) if hit.any() else np.nan

    step = -(-max(depth.shape) // THUMBNAIL)
    return {
        "views": np.array(list(names)),
        "view_valid": np.array(threads.each(lambda k: np.isfinite(views[k].depth).mean(), range(len(names)))),
        "view_overlap": np.isfinite(fused.layers).mean(axis=(1, 2)),
        "view_residual": np.array(threads.each(residual, list(fused.layers))),
        "thumbnails": np.ascontiguousarray(fused.layers[:, step // 2 :: step, step // 2 :: step]),
    }


def judged(fused: Fused, reference: View, baseline_focal: float | None) -> dict[str, np.ndarray]:
    """Errors of the reference view, mean, median and fused map, if the truth is known.

    The fused map counts where something was observed, as the others do, and once more with what it in-painted. Whether
    its confidence knows where it errs is told beside what the mere angle of view (4.35) would know.
    """
    if reference.truth is None:
        return {}
    import numpy as np

    from ipcli.models.fusion.confidence import view_angle
    from ipcli.models.fusion.metrics import ause, compare

    observed = fused.observations > 0
    maps = {"reference": reference.depth, "mean": fused.mean, "median": fused.median}
    maps["fused"] = np.where(observed, fused.depth, np.nan).astype(np.float32)
    if not observed.all():
        maps["fused, in-painted"] = fused.depth
    own = {name: fused.normals for name in maps if name.startswith("fused")}
    columns, rows = compare(maps, reference.truth, reference.intrinsics, baseline_focal, own)
    error = maps["fused"] - reference.truth
    angle = view_angle(fused.depth, reference.intrinsics)
    return {
        "truth": reference.truth,
        "metrics": rows,
        "metric_rows": np.array(list(maps)),
        "metric_columns": np.array(columns),
        "ause": np.float64(ause(fused.confidence, error)),
        "ause_uncertainty": np.float64(ause(-fused.uncertainty, error)),
        "ause_angle": np.float64(ause(angle, error)),
    }


def no_overlap(reference: str, table: Mapping[str, np.ndarray], unit: str) -> str:
    """Why nothing could be fused, view by view."""
    views = zip(table["views"], table["view_valid"], table["view_overlap"], strict=True)
    each = "; ".join(
        f"{name}: {100 * valid:.0f} % valid, reaches {100 * overlap:.1f} %" for name, valid, overlap in views
    )
    return (
        f"no view overlaps the reference view {reference!r} ({each}). Check the direction of the poses and that depth "
        "and "
        f"translation are both in {unit}"
    )


def write_mesh(path: Path, arrays: Mapping[str, np.ndarray], provenance: Mapping[str, Any]) -> None:
    """The surface in world coordinates with normals, colours, confidence and observations; only where there were
    observations.
    """
    import numpy as np

    from ipcli.geometry.cameras import back_project, transform
    from ipcli.geometry.surface import triangulate
    from ipcli.io.files import ply

    world_from_cam = np.linalg.inv(arrays["cam_from_world"])
    keep = (arrays["observations"] > 0) & np.isfinite(arrays["depth"]) & np.isfinite(arrays["normals"]).all(axis=-1)
    pixels, faces = triangulate(arrays["depth"], keep)
    points = transform(world_from_cam, back_project(arrays["depth"], arrays["intrinsics"]).reshape(-1, 3)[pixels])
    normals = arrays["normals"].reshape(-1, 3)[pixels] @ world_from_cam[:3, :3].T
    ply.write(
        path,
        points.astype(np.float32),
        faces=faces,
        normals=normals.astype(np.float32),
        colors=arrays["image"].reshape(-1, 3)[pixels] if "image" in arrays else None,
        extra={name: arrays[name].ravel()[pixels] for name in ("confidence", "observations")},
        comments=(f"ipcli fuse-depth, unit {arrays['unit']}, digest {provenance['digest']}",),
    )
