"""The files beside a fused map and a merged cloud: the mesh for other programs, and pages to turn them in."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ipcli.geometry.cameras import back_project, transform
from ipcli.geometry.surface import PixelGrid, triangulate
from ipcli.io.files import atomic, ply
from ipcli.io.meshes import turntable
from ipcli.measurements.accuracy import thinned_camera, thinning
from ipcli.models.fusion.holes import SEEN
from ipcli.report.kit import surface
from ipcli.report.kit.pictures import palette

VERTICES, POINTS = 20_000, 60_000  # of a surface, and of a cloud, on the page to be turned


def write_mesh(path: Path, arrays: Mapping[str, np.ndarray], provenance: Mapping[str, Any]) -> None:
    """Write the surface in world coordinates with normals, colours, confidence and observations, only where
    observations support it.
    """
    world_from_cam = np.linalg.inv(arrays["cam_from_world"])
    keep = (arrays["filled"] == SEEN) & np.isfinite(arrays["depth"]) & np.isfinite(arrays["normals"]).all(axis=-1)
    grid = PixelGrid.of(arrays["depth"], keep)

    def vertices(rows: slice) -> np.ndarray:
        own = keep[rows]
        points = transform(world_from_cam, back_project(arrays["depth"][rows], arrays["intrinsics"], rows.start)[own])
        normals = arrays["normals"][rows][own] @ world_from_cam[:3, :3].T
        colors = arrays["image"][rows][own] if "image" in arrays else None
        extra = {name: arrays[name][rows][own] for name in ("confidence", "observations")}
        return ply.vertex_table(path, points.astype(np.float32), normals.astype(np.float32), colors, extra)

    comments = (f"ipcli fuse-depth, unit {arrays['unit']}, digest {provenance['digest']}",)
    counts = (int(keep.sum()), grid.count())
    ply.write_bands(path, map(vertices, grid.bands()), counts, grid.faces(), comments)


def write_turnable(title: str, path: Path, arrays: Mapping[str, np.ndarray], provenance: Mapping[str, Any]) -> None:
    """A page with the surface to be turned, by some pixels of the map, first seen from the reference camera."""
    step = thinning(arrays["depth"].size, VERTICES)
    names = ("depth", "filled", "normals", "image")
    thin = {name: np.ascontiguousarray(arrays[name][::step, ::step]) for name in names if name in arrays}
    depth, normals = thin["depth"], thin["normals"]
    camera = thinned_camera(arrays["intrinsics"], step)
    keep = (thin["filled"] == SEEN) & np.isfinite(depth) & np.isfinite(normals).all(axis=-1)
    pixels, faces = triangulate(depth, keep)
    points = back_project(depth, camera).reshape(-1, 3)[pixels] @ turntable.UPRIGHT
    colours = (
        thin["image"].reshape(-1, 3)[pixels]
        if "image" in thin
        else _clay(surface.shade(normals, camera).ravel()[pixels])
    )
    field = float(2 * np.degrees(np.arctan(depth.shape[0] / (2 * camera[1, 1]))))
    about = f"The fused surface by {len(pixels)} of its pixels, first seen from the reference camera."
    scene = turntable.surface_scene(points.astype(np.float32), faces, colours)
    atomic.write_text(path, _from_the_camera(scene, title, about, points, field))


def write_turnable_cloud(
    title: str, path: Path, arrays: Mapping[str, np.ndarray], provenance: Mapping[str, Any]
) -> None:
    """A page with some points of a cloud to be turned, first seen from the camera of the map in the middle."""
    chosen = slice(None, None, -(-max(len(arrays["points"]), 1) // POINTS))
    camera = arrays["cam_from_world"][len(arrays["cam_from_world"]) // 2]
    points = transform(camera, arrays["points"][chosen].astype(np.float64))
    if "colors" in arrays:
        colours = arrays["colors"][chosen]
    else:
        normals = arrays["normals"][chosen] @ camera[:3, :3].T
        colours = _clay(np.abs((normals * points).sum(axis=1)) / np.linalg.norm(points, axis=1))
    about = f"{len(points)} of {len(arrays['points'])} points, first seen from the camera of the map in the middle."
    points = points @ turntable.UPRIGHT
    scene = turntable.cloud_scene(points.astype(np.float32), colours)
    atomic.write_text(path, _from_the_camera(scene, title, about, points, turntable.FIELD))


def _from_the_camera(scene: Any, title: str, about: str, points: np.ndarray, field: float) -> str:
    """The page of a scene seen from the camera that its points (n, 3) are in the upright frame of; it turns about what
    that sees in the middle distance.
    """
    pivot = np.array([0.0, 0.0, np.median(points[:, 2]) if len(points) else -1.0])
    return turntable.turning_page(scene, title, about, from_camera=np.eye(4), field=field, pivot=pivot)


def _clay(light: np.ndarray) -> np.ndarray:
    """RGB (n, 3) uint8 of brightness (n,)."""
    return palette("clay")[surface.SHADE.indices(light[None])[0]]
