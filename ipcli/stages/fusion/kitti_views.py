"""kitti-views: scenes of KITTI stereo 2012 -> a `views` artefact each, with both cameras in every frame."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from ipcli.errors import FormatError, ParameterError
from ipcli.executor import map_items
from ipcli.geometry.stereo import semi_global
from ipcli.io.views import artefact, kitti
from ipcli.io.views.kitti import Calibration
from ipcli.measurements.names import position
from ipcli.measurements.views import View, check_view
from ipcli.params import Run, as_dict
from ipcli.progress import Progress, silent
from ipcli.stages.fusion.parameters import KittiViews
from ipcli.stages.kit import outputs
from ipcli.stages.kit.artefact import Job, Outcome, make


def run(
    folder: Path,
    poses: Path,
    output: Path,
    params: KittiViews,
    run: Run,
    progress: Progress = silent,
) -> dict[Path, Outcome]:
    """Write OUTPUT/SCENE.views.h5 for each scene; those that are there already, made from the same, are left alone.

    Raises ItemsFailed at the end when some scenes failed, and ParameterError for a scene that is not there.
    """
    outputs.check_place(output, folder=True)
    if params.sgbm.disparities % 16 or params.sgbm.block % 2 == 0:
        raise ParameterError("sgbm.disparities must be a multiple of 16, and sgbm.block odd")
    scene = partial(make_scene, folder=folder, poses=poses, output=output, params=params, run=run)
    outcomes = map_items(scene, select_scenes(folder, params.scenes), run.executor, progress)
    return {_path(output, name): outcome for name, outcome in outcomes.items()}


def select_scenes(folder: Path, wanted: str) -> tuple[str, ...]:
    """Names of the scenes asked for, ``27`` standing for ``000027``."""
    names = kitti.scenes(folder)
    if wanted == "all":
        return names
    return tuple(dict.fromkeys(names[position(names, text.strip().zfill(6), "scene")] for text in wanted.split(",")))


def make_scene(scene: str, *, folder: Path, poses: Path, output: Path, params: KittiViews, run: Run) -> Outcome:
    """Make one artefact. The left cameras are named ``10_left``, the right ones ``10_right``."""
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
    folder: Path, scene: str, frame: str, camera: Calibration, world_from_cam0: np.ndarray, params: KittiViews
) -> list[View]:
    """The left and the right view of one frame."""
    images = kitti.pair(folder, scene, frame)
    left, right = (image[..., 0] for image in images)
    disparities = semi_global(left, right, **as_dict(params.sgbm))
    cam0_from_world = np.linalg.inv(world_from_cam0)
    shifts = (camera.left_from_cam0, camera.right_from_cam0)
    views = []
    for side, image, disparity, shift in zip(("left", "right"), images, disparities, shifts, strict=True):
        truth = _truth(folder, scene, camera, params) if (side, frame) == ("left", kitti.TRUTH_FRAME) else None
        depth = (camera.baseline_focal / disparity).astype(np.float32)
        view = View(f"{frame}_{side}", depth, camera.intrinsics, shift @ cam0_from_world, image=image, truth=truth)
        views.append(check_view(view, folder))
    return views


def _truth(folder: Path, scene: str, camera: Calibration, params: KittiViews) -> np.ndarray | None:
    occluded = params.truth == "occ"
    if not kitti.truth_file(folder, scene, occluded).is_file():
        return None
    return (camera.baseline_focal / kitti.truth(folder, scene, occluded)).astype("float32")
