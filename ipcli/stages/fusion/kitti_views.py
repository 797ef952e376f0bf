"""kitti-views: scenes of KITTI stereo 2012 -> a `views` artefact each, with both cameras in every frame."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from ipcli.errors import FormatError, ParameterError
from ipcli.params import Run, as_dict, option
from ipcli.progress import Progress, silent

if TYPE_CHECKING:
    import numpy as np

    from ipcli.io.views.kitti import Calibration
    from ipcli.measurements.views import View
    from ipcli.stages.kit.artefact import Outcome


@dataclass(frozen=True)
class Sgbm:
    """Semi-global matching."""

    disparities: int = option(160, "Length of the search, a multiple of 16.", low=16, high=1024, unit="px")
    block: int = option(5, "Side of the matched block, odd.", low=1, high=21, unit="px")
    small_step: int = option(4, "Penalty of a change by one disparity.", low=0)
    large_step: int = option(32, "Penalty of a larger change.", low=1)
    uniqueness: int = option(5, "Lead of the best match over the second, in per cent.", low=0, high=100)
    speckle_size: int = option(100, "Smallest patch kept; 0 keeps all.", low=0, unit="px^2")
    speckle_range: int = option(2, "Change of disparity that ends a patch.", low=0, unit="px")
    mode: str = option(
        "hh",
        "Paths of the matching: five (sgbm; low by 0.4 px on KITTI), eight (hh) or three.",
        choices=("sgbm", "hh", "3way"),
    )
    consistency: float | None = option(
        1.0, "Largest disagreement of left and right; none keeps all.", low=0.0, unit="px"
    )


@dataclass(frozen=True)
class Params:
    """Which scenes, with which poses, truth and matching."""

    scenes: str = option("all", "Scenes: all, or numbers with commas.", flag="--scenes")
    method: str = option("viso", "Set of poses in the NPZ.", flag="--method")
    truth: str = option(
        "noc",
        "Truth without (noc) or with (occ) pixels the right camera does not see.",
        flag="--truth",
        choices=("noc", "occ"),
    )
    sgbm: Sgbm = field(default_factory=Sgbm)


def run(
    folder: Path,
    poses: Path,
    output: Path,
    params: Params,
    run: Run,
    progress: Progress = silent,
) -> dict[Path, Outcome]:
    """Write OUTPUT/SCENE.views.h5 for each scene; those that are there already, made from the same, are left alone.

    Raises ItemsFailed at the end when some scenes failed, and ParameterError for a scene that is not there.
    """
    from ipcli.executor import map_items
    from ipcli.stages.kit import outputs

    outputs.check_place(output, folder=True)
    if params.sgbm.disparities % 16 or params.sgbm.block % 2 == 0:
        raise ParameterError("sgbm.disparities must be a multiple of 16, and sgbm.block odd")
    scene = partial(make_scene, folder=folder, poses=poses, output=output, params=params, run=run)
    outcomes = map_items(scene, chosen(folder, params.scenes), run.executor, progress)
    return {_path(output, name): outcome for name, outcome in outcomes.items()}


def chosen(folder: Path, wanted: str) -> tuple[str, ...]:
    """Names of the scenes asked for, ``27`` standing for ``000027``."""
    from ipcli.io.views import kitti
    from ipcli.measurements.names import position

    names = kitti.scenes(folder)
    if wanted == "all":
        return names
    return tuple(dict.fromkeys(names[position(names, text.strip().zfill(6), "scene")] for text in wanted.split(",")))


def make_scene(scene: str, *, folder: Path, poses: Path, output: Path, params: Params, run: Run) -> Outcome:
    """Make one artefact. The left cameras are named ``10_left``, the right ones ``10_right``."""
    from ipcli.io.views import artefact, kitti
    from ipcli.stages.kit.artefact import Job, make

    known = kitti.poses(poses, scene, params.method)
    frames = [frame for frame in kitti.frames(folder, scene) if frame in known]
    if not frames:
        raise FormatError(
            poses,
            f"no pose of any frame of scene {scene}",
            expected=f"frames {', '.join(kitti.frames(folder, scene))}",
            got=", ".join(known) or "none",
            fix="Give the poses of these frames, or leave the scene out",
        )
    truth = kitti.truth_file(folder, scene, params.truth == "occ")
    images = (path for frame in frames for path in kitti.pair_files(folder, scene, frame))
    tables = (kitti.calibration_file(folder, scene), kitti.poses_file(poses, scene))
    inputs = (*images, *tables, *([truth] if truth.is_file() else []))

    def build() -> dict[str, np.ndarray]:
        camera = kitti.calibration(folder, scene)
        views = [view for frame in frames for view in _views(folder, scene, frame, camera, known[frame], params)]
        return artefact.views_arrays(views, unit="m", measured="disparity", baseline_focal=camera.baseline_focal)

    own = replace(params, scenes=scene)  # which others were asked for does not change this one
    return make(Job(_path(output, scene), "views", "kitti-views", own, inputs), build, run)


def _path(output: Path, scene: str) -> Path:
    return output / f"{scene}.views.h5"


def _views(
    folder: Path, scene: str, frame: str, camera: Calibration, world_from_cam0: np.ndarray, params: Params
) -> list[View]:
    """The left and the right view of one frame."""
    import numpy as np

    from ipcli.geometry.stereo import semi_global
    from ipcli.io.views import kitti
    from ipcli.measurements.views import View, check_view

    images = kitti.pair(folder, scene, frame)
    disparities = semi_global(*(image[..., 0] for image in images), **as_dict(params.sgbm))
    cam0_from_world = np.linalg.inv(world_from_cam0)
    shifts = (camera.left_from_cam0, camera.right_from_cam0)
    views = []
    for side, image, disparity, shift in zip(("left", "right"), images, disparities, shifts, strict=True):
        truth = _truth(folder, scene, camera, params) if (side, frame) == ("left", kitti.TRUTH_FRAME) else None
        depth = (camera.baseline_focal / disparity).astype(np.float32)
        view = View(f"{frame}_{side}", depth, camera.intrinsics, shift @ cam0_from_world, image=image, truth=truth)
        views.append(check_view(view, folder))
    return views


def _truth(folder: Path, scene: str, camera: Calibration, params: Params) -> np.ndarray | None:
    from ipcli.io.views import kitti

    occluded = params.truth == "occ"
    if not kitti.truth_file(folder, scene, occluded).is_file():
        return None
    return (camera.baseline_focal / kitti.truth(folder, scene, occluded)).astype("float32")
