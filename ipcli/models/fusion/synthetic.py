"""Views whose truth is known: of a mesh, rendered along a camera path (thesis 4.5.2), or of given views, made noisy."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ipcli.geometry import raycast
from ipcli.geometry.sensor import observe
from ipcli.measurements.views import View


@dataclass(frozen=True, eq=False)
class CameraPath:
    """Poses of a camera before a mesh that was moved to suit the path."""

    mesh: raycast.Mesh
    poses: np.ndarray  # (n, 4, 4) cam_from_world
    baseline: float  # turns depth into disparity, with the focal length


def orbit(mesh: raycast.Mesh, views: int, spacing: float, up: str) -> CameraPath:
    """Around the mesh, scaled to radius 1; ``spacing`` in steps of 5 degrees between views.

    The baseline is the thesis': half of the chord between two views.
    """
    baseline = raycast.DISTANCE * np.sin(spacing * raycast.STEP / 2)
    return CameraPath(raycast.unit_sphere(mesh, up), raycast.orbit(views, spacing), baseline)


def strip(mesh: raycast.Mesh, views: int, spacing: float) -> CameraPath:
    """High above the mesh, looking down; ``spacing`` in its units between views, which is the baseline."""
    return CameraPath(raycast.on_ground(mesh), raycast.strip(views, spacing), spacing)


def camera_matrix(shape: tuple[int, int], focal: float) -> np.ndarray:
    """Intrinsics (3, 3) of a camera of (height, width) pixels whose axis goes through (width / 2, height / 2)."""
    return np.array([[focal, 0, shape[1] / 2], [0, focal, shape[0] / 2], [0, 0, 1]])


def render(path: CameraPath, shape: tuple[int, int], focal: float) -> Iterator[View]:
    """One view after another of the path without noise, its depth also its truth; named by numbers of equal length."""
    caster, intrinsics = raycast.Caster(path.mesh), camera_matrix(shape, focal)
    digits = len(str(len(path.poses) - 1))
    for index, pose in enumerate(path.poses):
        depth, image = caster.view(shape, intrinsics, pose)
        yield View(f"{index:0{digits}d}", depth, intrinsics, pose, image=image, truth=depth)


def add_noise(
    view: View,
    rng: np.random.Generator,
    noise: tuple[str, float],
    outliers: float = 0.0,
    baseline_focal: float | None = None,
) -> View:
    """The view as a poor sensor gives it; what it was before stays as its truth, unless it has one.

    ``noise`` and the share of ``outliers`` are those of `observe`; with ``baseline_focal`` they are put on the
    disparity, else on the depth.
    """
    truth = view.depth if view.truth is None else view.truth
    if baseline_focal is None:
        depth = observe(view.depth, rng, noise, outliers)
    else:  # the same formula both ways
        disparity = (baseline_focal / view.depth).astype(view.depth.dtype)
        measured = observe(disparity, rng, noise, outliers)
        depth = (baseline_focal / measured).astype(measured.dtype)
    return replace(view, depth=depth, truth=truth)
