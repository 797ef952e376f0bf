"""render-views: a triangle mesh -> depth maps of cameras around or above it, with noise added if wanted
(thesis 4.5.2).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ipcli.errors import NoSolution
from ipcli.params import Run, option
from ipcli.progress import Progress, silent

if TYPE_CHECKING:
    import numpy as np

    from ipcli.measurements.views import View
    from ipcli.stages.kit.artefact import Outcome


@dataclass(frozen=True)
class Params:
    """The path of the camera, the camera, and its noise; the defaults are those of the thesis."""

    path: str = option(
        "orbit",
        "orbit: around the mesh, scaled to radius 1, at distance 3; strip: 300 above it, looking down.",
        flag="--path",
        choices=("orbit", "strip"),
    )
    views: int = option(11, "Number of views; fuse-depth takes the middle one as reference.", flag="--views", low=1)
    spacing: float | None = option(
        None, "Between views: times 5 degrees on an orbit (1), in units along a strip (4).", flag="--spacing", low=1e-6
    )
    up: str = option(
        "y", "Axis of the mesh that points up, on an orbit; a strip takes z.", flag="--up", choices=("x", "y", "z")
    )
    noise: str | None = option(None, "Noise to add: laplace:SCALE or gauss:SCALE, in the unit.", flag="--noise")
    width: int = option(640, "Width of the images.", flag="--width", low=8, unit="px")
    height: int = option(480, "Height of the images.", flag="--height", low=8, unit="px")
    focal: float = option(
        576.0, "Focal length; the principal point is (width / 2, height / 2).", flag="--focal", low=1.0, unit="px"
    )


def run(
    source: Path,
    output: Path,
    params: Params,
    run: Run,
    progress: Progress = silent,
) -> Outcome:
    """Write the `views` artefact of a mesh, each view with its truth. NoSolution if the middle view sees nothing."""
    from ipcli.geometry.sensor import parse_noise
    from ipcli.stages.kit.artefact import Job, make

    noise = parse_noise(params.noise) if params.noise else ("gauss", 0.0)

    def build() -> dict[str, np.ndarray]:
        return rendered(source, params, noise, run.seed, progress)

    return make(Job(output, "views", "render-views", params, (source,)), build, run)


def rendered(
    source: Path, params: Params, noise: tuple[str, float], seed: int, progress: Progress
) -> dict[str, np.ndarray]:
    """The arrays of the artefact. The baseline that turns depth into disparity is the thesis': half of the chord
    between two views of the orbit, the whole step of the strip.
    """
    import numpy as np

    from ipcli.geometry import raycast
    from ipcli.io.meshes import mesh
    from ipcli.io.views import artefact

    solid = raycast.Mesh(*mesh.read(source))
    if params.path == "orbit":
        spacing = params.spacing or 1.0
        solid, poses = raycast.unit_sphere(solid, params.up), raycast.orbit(params.views, spacing)
        baseline = raycast.DISTANCE * np.sin(spacing * raycast.STEP / 2)
    else:
        baseline = params.spacing or 4.0
        solid, poses = raycast.on_ground(solid), raycast.strip(params.views, baseline)
    caster = raycast.Caster(solid)
    views = []
    for index, pose in enumerate(poses):
        views.append(_view(f"{index:0{len(str(len(poses) - 1))}d}", caster, pose, params, noise, seed))
        progress((index + 1) / len(poses), views[-1].name)
    if not np.isfinite(views[(len(views) - 1) // 2].truth).any():
        raise NoSolution(
            f"{source}: the middle view sees nothing of the mesh. Check its axes (--up, --path) and the focal length"
        )
    return artefact.views_arrays(views, unit="m.u.", measured="depth", baseline_focal=params.focal * baseline)


def _view(name: str, caster, pose: np.ndarray, params: Params, noise: tuple[str, float], seed: int) -> View:
    import numpy as np

    from ipcli.geometry.sensor import observe
    from ipcli.measurements.views import View
    from ipcli.rng import stream

    intrinsics = np.array([[params.focal, 0, params.width / 2], [0, params.focal, params.height / 2], [0, 0, 1]])
    truth, image = caster.view((params.height, params.width), intrinsics, pose)
    depth = observe(truth, stream(seed, "render-views", name), noise)
    return View(name, depth, intrinsics, pose, image=image, truth=truth)
