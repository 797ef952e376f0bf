"""One cloud of a whole sequence: `fuse-depth --all` and `merge-depth` against Open3D's TSDF, by distance to the true surface.

    python -m benchmarks.fusion_cloud --views FILE.views.h5

The views need a truth. Ours stands at its defaults; the TSDF gets all the views, and the one of its settings on the declared grid
that has the least mean distance is shown, as is the whole grid. Accuracy: from the cloud to the true points; completeness: back.
"""

from __future__ import annotations

import argparse
from pathlib import Path
import tempfile
import time
from typing import Any

import numpy as np

from benchmarks.measure import OUTPUT, isolated, publish, say

SAMPLE = 200_000  # points, evenly spaced in their order, that distances are taken of
NEAR = 0.01  # in the unit of the scene, metres: whose share is told of what lies nearer
VOXELS = (0.006, 0.008, 0.012, 0.016)  # side, in units of the scene
WEIGHTS = (1.0, 3.0, 6.0, 12.0)  # observations that a point must have
TRUNCATION = 8.0  # voxels


def ours(views: str, folder: str, window: int, step: int) -> list[float]:
    """Save the cloud of the two commands; the seconds of each."""
    from ipcli.io import ply
    from ipcli.params import Run
    from ipcli.stages import fuse_depth, merge_depth

    started = time.perf_counter()
    made = fuse_depth.run_all(Path(views), Path(folder), fuse_depth.Params(window=window, every=True, step=step), Run())
    between = time.perf_counter()
    cloud = Path(folder) / "cloud.ply"
    merge_depth.run(list(made), cloud, merge_depth.Params(), Run())
    seconds = [between - started, time.perf_counter() - between]
    np.save(Path(folder) / "ours.npy", ply.read(cloud).vertices)
    return seconds


def tsdf(views: str, folder: str, voxel: float) -> float:
    """Save the clouds that Open3D's VoxelBlockGrid of all views gives at each least weight; the seconds."""
    from ipcli.geometry import open3d
    from ipcli.io import sequences

    o3d = open3d.load()
    sequence = sequences.open(Path(views))
    loaded = [sequence.load(name) for name in sequence.names]
    started = time.perf_counter()
    kinds = (o3d.core.float32, o3d.core.float32)
    grid = o3d.t.geometry.VoxelBlockGrid(
        ("tsdf", "weight"), kinds, ((1,), (1,)), voxel, 16, 20_000, o3d.core.Device("CPU:0")
    )
    far = float(np.nanmax([np.nanpercentile(view.depth, 99.9) for view in loaded]))
    for view in loaded:
        image = o3d.t.geometry.Image(np.nan_to_num(view.depth))
        camera = (o3d.core.Tensor(view.intrinsics), o3d.core.Tensor(view.cam_from_world))
        blocks = grid.compute_unique_block_coordinates(image, *camera, 1.0, far, TRUNCATION)
        grid.integrate(blocks, image, *camera, 1.0, far, TRUNCATION)
    for weight in WEIGHTS:
        np.save(Path(folder) / f"tsdf {weight}.npy", grid.extract_point_cloud(weight).point.positions.numpy())
    return time.perf_counter() - started


def true_points(views: str) -> np.ndarray:
    """The back-projected truth of all views (n, 3) float32, in the world."""
    from ipcli.geometry.cameras import back_project, transform
    from ipcli.io import sequences

    sequence, parts = sequences.open(Path(views)), []
    for name in sequence.names:
        view = sequence.load(name)
        points = transform(np.linalg.inv(view.cam_from_world), back_project(view.truth, view.intrinsics).reshape(-1, 3))
        parts.append(points[np.isfinite(points[:, 2])].astype(np.float32))
    return np.concatenate(parts)


def judged(cloud: np.ndarray, truth: np.ndarray, tree: Any) -> dict[str, float]:
    """Distances of the cloud to the truth, in thousandths of the unit, and the share of each that is near the other."""
    from scipy.spatial import cKDTree

    if not len(cloud):
        return {"mean": float("inf")}
    distance = tree.query(cloud[:: -(-len(cloud) // SAMPLE)], workers=-1)[0]
    back = cKDTree(cloud).query(truth[:: -(-len(truth) // SAMPLE)], distance_upper_bound=NEAR, workers=-1)[0]
    return {
        "mean": 1e3 * float(distance.mean()),
        "median": 1e3 * float(np.median(distance)),
        "within 10 %": 100 * float((distance <= NEAR).mean()),
        "truth within 10 %": 100 * float(np.isfinite(back).mean()),
        "points": float(len(cloud)),
    }


def compare(views: str, window: int, step: int, threads: int) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Rows of both methods, and of the grid of the peer."""
    from scipy.spatial import cKDTree

    truth = true_points(views)
    tree = cKDTree(truth, balanced_tree=False, compact_nodes=False)
    grid = []
    with tempfile.TemporaryDirectory() as folder:
        say("ipcli")
        seconds = isolated(
            "benchmarks.fusion_cloud:ours", threads, views=views, folder=folder, window=window, step=step
        )
        own = {"method": f"ipcli, fusing {seconds[0]:.1f} s and merging {seconds[1]:.1f} s", "seconds": sum(seconds)}
        own |= judged(np.load(Path(folder) / "ours.npy"), truth, tree)
        for voxel in VOXELS:
            say(f"Open3D, voxels of {voxel}")
            took = isolated("benchmarks.fusion_cloud:tsdf", threads, views=views, folder=folder, voxel=voxel)
            for weight in WEIGHTS:
                row = {"method": f"Open3D VoxelBlockGrid, voxel {voxel:g}, weight {weight:g}", "seconds": took}
                grid.append(row | judged(np.load(Path(folder) / f"tsdf {weight}.npy"), truth, tree))
    return [own, min(grid, key=lambda row: row["mean"])], grid


def main() -> None:
    """The tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--views", required=True, help="views artefact with a truth")
    parser.add_argument("--window", type=int, default=7)
    parser.add_argument("--step", type=int, default=4)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--output", type=Path, default=OUTPUT)
    chosen = parser.parse_args()
    best, grid = compare(str(Path(chosen.views).resolve()), chosen.window, chosen.step, chosen.threads)
    facts = {"views": Path(chosen.views).name, "window": chosen.window, "step": chosen.step, "threads": chosen.threads}
    tables = {"Ours at its defaults, the TSDF at its best; distances in 1e-3 of the unit": best, "Grid of the TSDF": grid}
    publish("fusion_cloud", "One cloud of a sequence", tables, facts, chosen.output)


if __name__ == "__main__":
    main()
