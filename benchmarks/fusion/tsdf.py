"""Open3D's VoxelBlockGrid, set up so that it does its best.

It takes the pixel that a voxel falls into to begin, not to be centred, at whole numbers, so its principal point is half
a pixel on. Depth is that of the extracted mesh: the grid's own ray casting puts surfaces half a voxel back.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ipcli.measurements.views import View

BLOCKS = 20_000  # of 16 x 16 x 16 voxels to make room for at first; it grows by itself


def volume(views: Sequence[View], voxel: float, truncation: float) -> Any:
    """The grid of the views; `voxel` in their unit, truncation in voxels."""
    from ipcli.geometry import open3d

    o3d = open3d.load()
    kinds = (o3d.core.float32, o3d.core.float32)
    grid = o3d.t.geometry.VoxelBlockGrid(
        ("tsdf", "weight"), kinds, ((1,), (1,)), voxel, 16, BLOCKS, o3d.core.Device("CPU:0")
    )
    far = float(np.nanmax([np.nanpercentile(view.depth, 99.9) for view in views]))
    for view in views:
        image = o3d.t.geometry.Image(np.nan_to_num(view.depth))
        camera = (o3d.core.Tensor(_at_corners(view.intrinsics)), o3d.core.Tensor(view.cam_from_world))
        blocks = grid.compute_unique_block_coordinates(image, *camera, 1.0, far, truncation)
        grid.integrate(blocks, image, *camera, 1.0, far, truncation)
    return grid


def points(grid: Any, weight: float, spacing: float) -> np.ndarray:
    """Points (n, 3) at random on the mesh of the surface where at least so many observations are, one in each square of
    this side.

    The grid's own points are as far apart as its voxels, which would make coarse ones seem to miss what they reach.
    """
    from ipcli.geometry import open3d

    o3d, mesh = open3d.load(), _surface(grid.extract_triangle_mesh, weight)
    if mesh is None:
        return np.empty((0, 3))
    surface = mesh.to_legacy()
    o3d.utility.random.seed(0)
    return np.asarray(surface.sample_points_uniformly(max(1, int(surface.get_surface_area() / spacing**2))).points)


def depth(grid: Any, camera: View, weight: float) -> np.ndarray:
    """Depth (h, w) float32 of that surface as a mesh in a camera, NaN where there is none."""
    from ipcli.geometry import open3d

    mesh, (h, w) = _surface(grid.extract_triangle_mesh, weight), camera.depth.shape
    if mesh is None:
        return np.full((h, w), np.nan, np.float32)
    scene = open3d.load().t.geometry.RaycastingScene()
    scene.add_triangles(mesh)
    rays = scene.create_rays_pinhole(_at_corners(camera.intrinsics), camera.cam_from_world, w, h)
    along = scene.cast_rays(rays)["t_hit"].numpy() * (rays.numpy()[..., 3:] @ camera.cam_from_world[2, :3])
    return np.where(np.isfinite(along), along, np.nan).astype(np.float32)


def _surface(extract: Callable[[float], Any], weight: float) -> Any:
    """None if it is empty: for that Open3D raises an error about the shape of its colours."""
    try:
        return extract(weight)
    except RuntimeError as error:
        if "shape {0}" not in str(error):
            raise
        return None


def _at_corners(intrinsics: np.ndarray) -> np.ndarray:
    """Intrinsics for pixels that begin, not are centred, at whole numbers."""
    return intrinsics + np.array([[0, 0, 0.5], [0, 0, 0.5], [0, 0, 0]])
