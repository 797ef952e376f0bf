"""What a user might take instead: median, ROF on the median, a TSDF volume; seconds and error of the depth map.

The parameter of each is the best one of a declared grid, by the error against the truth; ours stands at its defaults.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
import time
from typing import Any

import numpy as np

from benchmarks.fusion_problem import Scene, open_scene
from benchmarks.measure import isolated, say

REPEATS, ENOUGH = 3, 3.0  # times, unless they took so many seconds already
WARM = {"count": 3, "shape": (48, 64)}  # what is compiled or loaded on the first call is not counted


def ours(scene: Scene, method: str) -> np.ndarray:
    """`fuse-depth` at its defaults."""
    from ipcli.models.fusion.fuse import fuse
    from ipcli.models.fusion.parameters import Fusion

    return fuse(scene.views, scene.reference, Fusion(method=method), inverse=scene.inverse).depth


def median(scene: Scene, _: None) -> np.ndarray:
    """Of the reprojected observations."""
    from ipcli.models.fusion.reprojection import reproject_all

    layers = reproject_all(scene.views, scene.reference).depth
    known = np.isfinite(layers).any(axis=0)
    depth = np.full(known.shape, np.nan, np.float32)
    depth[known] = np.nanmedian(np.where(np.isfinite(layers), layers, np.nan)[:, known], axis=0)
    return depth


def rof(scene: Scene, weight: float) -> np.ndarray:
    """scikit-image's ROF on the median, in units of its range; gaps filled with the nearest value first."""
    from scipy.ndimage import distance_transform_edt
    from skimage.restoration import denoise_tv_chambolle

    depth = median(scene, None)
    depth = depth[tuple(distance_transform_edt(np.isnan(depth), return_distances=False, return_indices=True))]
    low, high = np.percentile(depth, (2, 98))
    return (denoise_tv_chambolle((depth - low) / (high - low), weight=weight) * (high - low) + low).astype(np.float32)


def tsdf(scene: Scene, setting: tuple[float, float, float]) -> np.ndarray:
    """Open3D's VoxelBlockGrid, ray cast into the reference.

    The setting is the size of a voxel in pixels at the median depth, the truncation in voxels, and the least weight.
    """
    from ipcli.geometry import open3d

    o3d = open3d.load()
    reference = scene.reference
    far = float(np.nanmax([np.nanpercentile(view.depth, 99.9) for view in scene.views]))
    voxels, truncation, weight = setting
    voxel = voxels * float(np.nanmedian(reference.depth)) / reference.intrinsics[0, 0]
    kinds = (o3d.core.float32, o3d.core.float32)
    grid = o3d.t.geometry.VoxelBlockGrid(
        ("tsdf", "weight"), kinds, ((1,), (1,)), voxel, 16, 50_000, o3d.core.Device("CPU:0")
    )
    for view in scene.views:
        image = o3d.t.geometry.Image(np.nan_to_num(view.depth))
        camera = (o3d.core.Tensor(view.intrinsics), o3d.core.Tensor(view.cam_from_world))
        blocks = grid.compute_unique_block_coordinates(image, *camera, 1.0, far, truncation)
        grid.integrate(blocks, image, *camera, 1.0, far, truncation)
    h, w = reference.depth.shape
    camera = (o3d.core.Tensor(reference.intrinsics), o3d.core.Tensor(reference.cam_from_world))
    near = 0.5 * float(np.nanmin(reference.depth))
    rendered = grid.ray_cast(grid.hashmap().key_tensor(), *camera, w, h, ["depth"], 1.0, near, far, weight, truncation)
    depth = rendered["depth"].numpy()[..., 0]
    return np.where(depth > 0, depth, np.nan).astype(np.float32)


METHODS: dict[str, tuple[Callable[[Scene, Any], np.ndarray], tuple, str]] = {  # function, grid, package
    "ipcli l1-adapt": (ours, ("l1-adapt",), "ipcli"),
    "ipcli tgv-l1": (ours, ("tgv-l1",), "ipcli"),
    "median": (median, (None,), "ipcli"),
    "scikit-image ROF on the median": (rof, (0.002, 0.005, 0.01, 0.02, 0.05, 0.1), "skimage"),
    "Open3D VoxelBlockGrid": (tsdf, ((1.0, 8.0, 1.0), (1.0, 8.0, 3.0), (1.0, 16.0, 1.0), (2.0, 8.0, 1.0)), "open3d"),
}


def fused(name: str, source: dict[str, Any], folder: str) -> list[float]:
    """Save the depth maps of a method, one a setting; the median of the seconds of each."""
    function, grid, _ = METHODS[name]
    scene, medians = open_scene(**source), []
    for index, setting in enumerate(grid):
        function(open_scene(**WARM), setting)
        seconds = []
        while len(seconds) < REPEATS and sum(seconds) < ENOUGH:
            started = time.perf_counter()
            depth = function(scene, setting)
            seconds.append(time.perf_counter() - started)
        np.save(Path(folder) / f"{name} {index}.npy", depth)
        medians.append(float(np.median(seconds)))
    return medians


def compare(source: dict[str, Any], threads: int, folder: Path) -> list[dict[str, Any]]:
    """A row for each method that is installed, errors taken where all of them have a value."""
    truth = open_scene(**source).reference.truth
    maps, runs = {}, {}
    for name, (_, grid, package) in METHODS.items():
        if find_spec(package) is None:
            say(f"{name}: {package} is not installed, skipped")
            continue
        say(name)
        seconds = isolated("benchmarks.fusion_baselines:fused", threads, name=name, source=source, folder=str(folder))
        for index, setting in enumerate(grid):
            runs[name, setting], maps[name, setting] = seconds[index], np.load(folder / f"{name} {index}.npy")
    return _rows(maps, runs, truth)


def _rows(maps: dict, runs: dict, truth: np.ndarray | None) -> list[dict[str, Any]]:
    if truth is None:
        return [{"method": name, "setting": setting, "seconds": seconds} for (name, setting), seconds in runs.items()]
    # A map that is nearly empty, such as of voxels finer than the data, must not decide where the others are judged.
    full = {key: depth for key, depth in maps.items() if np.isfinite(depth).mean() > 0.5}
    everywhere = np.isfinite(truth) & np.isfinite(np.stack(list(full.values()))).all(axis=0)
    error = {key: float(np.abs(depth - truth)[everywhere].mean()) for key, depth in full.items()}
    best = [
        min((key for key in error if key[0] == name), key=error.get)
        for name in dict.fromkeys(name for name, _ in error)
    ]
    return [
        {
            "method": name,
            "setting": setting if METHODS[name][1][1:] else None,
            "seconds": runs[name, setting],
            "MAE, 1e-3 of the unit": 1e3 * error[name, setting],
            "density %": 100 * float(np.isfinite(maps[name, setting])[np.isfinite(truth)].mean()),
        }
        for name, setting in best
    ]
