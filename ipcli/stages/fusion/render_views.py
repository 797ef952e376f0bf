"""render-views: a triangle mesh -> depth maps of cameras around or above it, with noise added if wanted
(thesis 4.5.2).
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np

from ipcli.errors import NoSolution
from ipcli.geometry.raycast import Mesh
from ipcli.geometry.sensor import parse_noise
from ipcli.io.meshes import mesh
from ipcli.io.views import artefact
from ipcli.measurements.views import View
from ipcli.models.fusion.synthetic import CameraPath, add_noise, orbit, render, strip
from ipcli.params import Run
from ipcli.progress import Progress, silent
from ipcli.rng import stream
from ipcli.stages.fusion.parameters import RenderViews
from ipcli.stages.kit.artefact import Job, Outcome, make


def run(
    source: Path,
    output: Path,
    params: RenderViews,
    run: Run,
    progress: Progress = silent,
) -> Outcome:
    """Write the `views` artefact of a mesh, each view with its truth. NoSolution if the middle view sees nothing."""
    noise = parse_noise(params.noise) if params.noise else ("gauss", 0.0)

    def build() -> dict[str, np.ndarray]:
        path = camera_path(Mesh(*mesh.read(source)), params)
        views: list[View] = []
        for view in render(path, (params.height, params.width), params.focal):
            views.append(add_noise(view, stream(run.seed, "render-views", view.name), noise))
            progress(len(views) / params.views, view.name)
        truth = views[(len(views) - 1) // 2].truth
        if truth is None or not np.isfinite(truth).any():
            raise NoSolution(
                f"{source}: the middle view sees nothing of the mesh. Check its axes (--up, --path) and the focal "
                "length"
            )
        baseline_focal = params.focal * path.baseline
        return artefact.views_arrays(views, unit="m.u.", measured="depth", baseline_focal=baseline_focal)

    return make(Job(output, "views", "render-views", params, (source,), look=partial(mesh.read, source)), build, run)


def camera_path(solid: Mesh, params: RenderViews) -> CameraPath:
    """The path asked for, with its own spacing if none is given."""
    if params.path == "orbit":
        return orbit(solid, params.views, params.spacing or 1.0, params.up)
    return strip(solid, params.views, params.spacing or 4.0)
