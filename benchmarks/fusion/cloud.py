"""One cloud of a whole sequence: `fuse-depth --all` and `merge-depth` against Open3D's TSDF, by distance to the true
surface.

    python -m benchmarks.fusion.cloud --tune DEVELOPMENT.h5 --views FILE.h5

The views need a truth. Ours stands at its defaults. The TSDF, of the views and of our fused maps, has the setting of
its grid with the highest F-score on the development sequence.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.fusion import tsdf
from benchmarks.kit.arguments import add_threads, parser_of
from benchmarks.kit.measure import Clock, isolated
from benchmarks.kit.publish import publish, say

if TYPE_CHECKING:
    from ipcli.measurements.views import View

SAMPLE = 100_000  # points, evenly spaced in their order, that distances are taken of
NEAR = 0.005  # in the unit of the scene, metres: precision, recall and F-score are about what lies nearer
VIEWS, MAPS = "Open3D VoxelBlockGrid of the views", "Open3D VoxelBlockGrid of our fused maps"
GRIDS = {  # sides of a voxel in the unit, truncations in voxels, least numbers of maps that have seen a point
    VIEWS: ((0.004, 0.006, 0.009, 0.014), (8.0, 16.0, 32.0), (1.0, 4.0, 8.0, 12.0, 16.0, 24.0)),
    MAPS: ((0.003, 0.004, 0.006, 0.009), (4.0, 8.0, 16.0), (1.0, 2.0, 4.0)),
}


def fused(views: str, folder: str, window: int, step: int) -> float:
    """Write the fused maps; the seconds."""
    from ipcli.params import Run
    from ipcli.stages.fusion import fuse_depth
    from ipcli.stages.fusion.parameters import FuseDepth

    clock = Clock()
    with clock:
        fuse_depth.run_all(Path(views), Path(folder), FuseDepth(window=window, every=True, step=step), Run())
    return clock.last


def merged(folder: str) -> float:
    """Save the cloud of the fused maps in a folder; the seconds."""
    from ipcli.io.files import ply
    from ipcli.params import Run
    from ipcli.stages.fusion import merge_depth
    from ipcli.stages.fusion.parameters import MergeDepth

    clock, cloud = Clock(), Path(folder) / "cloud.ply"
    with clock:
        merge_depth.run(list(Path(folder).glob("*.fused.h5")), cloud, MergeDepth(), Run())
    np.save(Path(folder) / "cloud.npy", ply.read(cloud).vertices)
    return clock.last


def volumes(views: str | None, folder: str, voxel: float, truncation: float, weights: Sequence[float]) -> list[float]:
    """Save the clouds of the TSDF of all the views, of the fused maps in the folder if there is none, at each least
    weight; the seconds of each, its share of the integration in them.
    """
    loaded = _views(Path(views)) if views else _maps(Path(folder))
    clock, seconds = Clock(), []
    with clock:
        grid = tsdf.volume(loaded, voxel, truncation)
    integrated = clock.last
    for weight in weights:
        with clock:
            cloud = tsdf.points(grid, weight, 0.6 * NEAR)
        seconds.append(integrated + clock.last)
        np.save(Path(folder) / f"cloud {weight}.npy", cloud)
    return seconds


def _views(path: Path) -> list[View]:
    from ipcli.io.views import layouts

    sequence = layouts.open_views(path)
    return [sequence.load(name) for name in sequence.names]


def _maps(folder: Path) -> list[View]:
    from ipcli.measurements.views import View
    from ipcli.stages.fusion.merge_depth import read_map

    maps = [read_map(path) for path in sorted(folder.glob("*.fused.h5"))]
    return [View("", own.surface, own.intrinsics, own.cam_from_world) for own in maps]


class TrueSurface:
    """The back-projected truth of all views, in the world, to measure clouds by."""

    def __init__(self, views: Sequence[View]):
        from scipy.spatial import cKDTree

        points = np.concatenate([_true_points(view) for view in views])
        self.sample = points[:: -(-len(points) // SAMPLE)]
        self.tree = cKDTree(points, balanced_tree=False, compact_nodes=False)

    def judge(self, cloud: np.ndarray) -> dict[str, float]:
        """Distances (in thousandths of the unit) of the cloud to the truth; precision, the share of the cloud that is
        `NEAR`, recall, the share of the truth that the cloud is near to, and their harmonic mean, in per cent.
        """
        from scipy.spatial import cKDTree

        if not len(cloud):
            return {
                "mean": np.nan,
                "median": np.nan,
                "precision %": np.nan,
                "recall %": 0.0,
                "F-score %": 0.0,
                "points": 0.0,
            }
        distance = np.asarray(self.tree.query(cloud[:: -(-len(cloud) // SAMPLE)], workers=-1)[0])
        tree = cKDTree(cloud, balanced_tree=False, compact_nodes=False)
        back = np.asarray(tree.query(self.sample, distance_upper_bound=NEAR, workers=-1)[0])
        precision, recall = float((distance <= NEAR).mean()), float(np.isfinite(back).mean())
        figures = {"mean": 1e3 * float(distance.mean()), "median": 1e3 * float(np.median(distance))}
        figures |= {"precision %": 100 * precision, "recall %": 100 * recall}
        both = 200 * precision * recall / (precision + recall) if precision + recall else 0.0
        return figures | {"F-score %": both, "points": float(len(cloud))}


def _true_points(view: View) -> np.ndarray:
    """The back-projected truth (n, 3) of a view in the world; ValueError where it has none."""
    from ipcli.geometry.cameras import back_project, transform

    if view.truth is None:
        raise ValueError(f"view {view.name}: no truth to judge by")
    points = back_project(view.truth, view.intrinsics).reshape(-1, 3)
    return transform(np.linalg.inv(view.cam_from_world), points[np.isfinite(view.truth).ravel()])


def tune(truth: TrueSurface, method: str, views: str | None, folder: str, threads: int) -> list[dict[str, Any]]:
    """A row for each setting of the TSDF of the views, or of the fused maps in the folder."""
    rows, (voxels, truncations, weights) = [], GRIDS[method]
    for voxel, truncation in product(voxels, truncations):
        say(f"{method}, voxels of {voxel}, truncation {truncation}")
        arguments = {"views": views, "folder": folder, "voxel": voxel, "truncation": truncation, "weights": weights}
        isolated("benchmarks.fusion.cloud:volumes", threads, **arguments)
        for weight in weights:
            figures = truth.judge(np.load(Path(folder) / f"cloud {weight}.npy"))
            rows.append({"voxel": voxel, "truncation": truncation, "weight": weight} | figures)
    return rows


def best(rows: Sequence[dict[str, Any]]) -> dict[str, float]:
    """The setting with the highest F-score."""
    row = max(rows, key=lambda row: row["F-score %"])
    return {name: row[name] for name in ("voxel", "truncation", "weight")}


def report(
    views: str, settings: dict[str, dict[str, float]], window: int, step: int, threads: int
) -> list[dict[str, Any]]:
    """Rows of ours and of the TSDFs at their settings."""
    truth = TrueSurface(_views(Path(views)))
    with tempfile.TemporaryDirectory() as folder:
        say("ipcli")
        fusing = isolated(
            "benchmarks.fusion.cloud:fused", threads, views=views, folder=folder, window=window, step=step
        )
        merging = isolated("benchmarks.fusion.cloud:merged", threads, folder=folder)
        rows = [{"method": "ipcli", "setting": None, "seconds": fusing + merging}]
        rows[0] |= truth.judge(np.load(Path(folder) / "cloud.npy"))
        for method, setting in settings.items():
            say(method)
            voxel, truncation, weight = setting.values()
            arguments = {"folder": folder, "voxel": voxel, "truncation": truncation, "weights": [weight]}
            of = views if method == VIEWS else None
            (seconds,) = isolated("benchmarks.fusion.cloud:volumes", threads, views=of, **arguments)
            told = ", ".join(f"{name} {value:g}" for name, value in setting.items())
            row = {"method": method, "setting": told, "seconds": seconds + (0 if of else fusing)}
            rows.append(row | truth.judge(np.load(Path(folder) / f"cloud {weight}.npy")))
    return rows


def main(arguments: list[str] | None = None) -> None:
    """The tables."""
    parser = parser_of(__doc__)
    parser.add_argument(
        "--tune", type=Path, required=True, help="views artefact with a truth to choose the settings on"
    )
    parser.add_argument("--views", type=Path, required=True, help="views artefact with a truth to report on")
    parser.add_argument("--window", type=int, default=7)
    parser.add_argument("--step", type=int, default=4)
    add_threads(parser)
    chosen = parser.parse_args(arguments)
    development, views = str(chosen.tune.resolve()), str(chosen.views.resolve())
    same = {"window": chosen.window, "step": chosen.step, "threads": chosen.threads}
    truth, tables = TrueSurface(_views(Path(development))), {}
    with tempfile.TemporaryDirectory() as folder:
        isolated(
            "benchmarks.fusion.cloud:fused",
            chosen.threads,
            views=development,
            folder=folder,
            window=chosen.window,
            step=chosen.step,
        )
        for method, of in ((VIEWS, development), (MAPS, None)):
            tables[f"Tuning: {method}"] = tune(truth, method, of, folder, chosen.threads)
    settings = {method: best(tables[f"Tuning: {method}"]) for method in (VIEWS, MAPS)}
    heading = "Ours at its defaults, the TSDF as tuned; distances in 1e-3 of the unit"
    facts = {"tuned on": chosen.tune.name, "reported on": chosen.views.name, "near, in the unit": NEAR} | same
    publish(
        "fusion_cloud",
        "One cloud of a sequence",
        {heading: report(views, settings, **same)} | tables,
        facts,
        chosen.output,
    )


if __name__ == "__main__":
    main()
