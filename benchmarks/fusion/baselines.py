"""What a user might take instead: median, ROF on the median, a TSDF volume; seconds and error of the depth map.

    python -m benchmarks.fusion.baselines [--tune DEVELOPMENT.h5 --views FILE.h5 ...] [--quick]

The setting of each is the best of a declared grid on the development scene, and the others are reported; ours stands at
its defaults. Without files the scenes are generated, of one seed for the development and of others for the report.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.fusion import tsdf
from benchmarks.fusion.problem import FusionScene, open_scene
from benchmarks.kit.arguments import add_generated, add_threads, parser_of, size_of
from benchmarks.kit.measure import Clock, installed, isolated
from benchmarks.kit.publish import publish, save, say

WARM: dict[str, Any] = {"count": 3, "shape": (48, 64)}  # what is compiled or loaded on the first call is not counted
# share of the fullest map of its method that a map must have: empty ones must not decide where others are judged
FULL = 0.95
SEEDS = (1, (2, 3))  # generated scenes for the development and for the report


def ours(scene: FusionScene, method: str) -> np.ndarray:
    """`fuse-depth` at its defaults."""
    from ipcli.models.fusion.fuse import fuse
    from ipcli.models.fusion.parameters import Fusion

    return fuse(scene.views, scene.reference, Fusion(method=method), inverse=scene.inverse).depth


def median(scene: FusionScene) -> np.ndarray:
    """Of the reprojected observations."""
    from ipcli.models.fusion.reprojection import reproject_all

    layers = reproject_all(scene.views, scene.reference).depth
    known = np.isfinite(layers).any(axis=0)
    depth = np.full(known.shape, np.nan, np.float32)
    depth[known] = np.nanmedian(np.where(np.isfinite(layers), layers, np.nan)[:, known], axis=0)
    return depth


def rof(scene: FusionScene, weight: float) -> np.ndarray:
    """scikit-image's ROF on the median, in units of its range; gaps filled with the nearest value first."""
    from scipy.ndimage import distance_transform_edt
    from skimage.restoration import denoise_tv_chambolle

    depth = median(scene)
    depth = depth[tuple(distance_transform_edt(np.isnan(depth), return_distances=False, return_indices=True))]
    low, high = np.percentile(depth, (2, 98))
    return (denoise_tv_chambolle((depth - low) / (high - low), weight=weight) * (high - low) + low).astype(np.float32)


def voxels(scene: FusionScene, voxel: float, truncation: float) -> np.ndarray:
    """Open3D's VoxelBlockGrid: side of a voxel in pixels at the median depth, truncation in voxels. A surface needs one
    observation: where more are asked for there are holes, and elsewhere the same depth.
    """
    side = voxel * float(np.nanmedian(scene.reference.depth)) / scene.reference.intrinsics[0, 0]
    return tsdf.depth(tsdf.volume(scene.views, side, truncation), scene.reference, 1.0)


@dataclass(frozen=True)
class BaselineMethod:
    """A way from a scene to a depth map, and the values that each of its parameters may take."""

    run: Callable[..., np.ndarray]
    grid: Mapping[str, tuple] = field(default_factory=dict)
    package: str = "ipcli"

    def settings(self) -> list[dict[str, Any]]:
        """All combinations, the last parameter fastest."""
        return [dict(zip(self.grid, values, strict=True)) for values in product(*self.grid.values())]

    def at_edge(self, setting: Mapping[str, Any]) -> list[str]:
        """The parameters of several values that stand at the first or last of them."""
        return [name for name, values in self.grid.items() if values[1:] and setting[name] in (values[0], values[-1])]


METHODS = {
    "ipcli l1-adapt": BaselineMethod(partial(ours, method="l1-adapt")),
    "ipcli tgv-l1": BaselineMethod(partial(ours, method="tgv-l1")),
    "median": BaselineMethod(median),
    "scikit-image ROF on the median": BaselineMethod(
        rof, {"weight": (0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2)}, "skimage"
    ),
    "Open3D VoxelBlockGrid": BaselineMethod(
        voxels, {"voxel": (1.0, 1.5, 2.0, 3.0, 4.0, 6.0), "truncation": (8.0, 16.0, 32.0, 64.0)}, "open3d"
    ),
}


def fused(name: str, source: dict[str, Any], settings: Sequence[dict[str, Any]], folder: str) -> list[float]:
    """Save the depth maps of a method, one a setting; the seconds of each."""
    method, scene, clock, seconds = METHODS[name], open_scene(**source), Clock(), []
    method.run(open_scene(**WARM), **settings[0])
    for index, setting in enumerate(settings):
        with clock:
            depth = method.run(scene, **setting)
        seconds.append(clock.last)
        np.save(Path(folder) / f"{index}.npy", depth)
    return seconds


def maps(
    source: dict[str, Any], settings: Mapping[str, Sequence[dict[str, Any]]], threads: int
) -> dict[str, list[tuple[float, np.ndarray]]]:
    """Seconds and depth map of each setting of each method."""
    found = {}
    for name, tried in settings.items():
        say(f"{name}, settings: {len(tried)}")
        with tempfile.TemporaryDirectory() as folder:
            arguments = {"name": name, "source": source, "settings": tried, "folder": folder}
            seconds = isolated("benchmarks.fusion.baselines:fused", threads, **arguments)
            found[name] = [(took, np.load(Path(folder) / f"{index}.npy")) for index, took in enumerate(seconds)]
    return found


def errors(found: Mapping[str, list[tuple[float, np.ndarray]]], truth: np.ndarray) -> dict[str, list[dict[str, float]]]:
    """Of each map, where all that are `FULL` have a value, in thousandths of the unit; those that are not have none."""
    known = np.isfinite(truth)
    density = {name: [float(np.isfinite(depth)[known].mean()) for _, depth in runs] for name, runs in found.items()}
    full = {name: [share >= FULL * max(shares) for share in shares] for name, shares in density.items()}
    everywhere = known.copy()
    for name, runs in found.items():
        for (_, depth), counts in zip(runs, full[name], strict=True):
            everywhere &= np.isfinite(depth) | (not counts)

    def row(run, share, counts):
        seconds, depth = run
        error = 1e3 * (depth - truth)[everywhere].astype(np.float64) if counts else np.array([np.nan])
        figures = {"MAE": np.abs(error).mean(), "RMSE": np.sqrt(np.square(error).mean()), "mean": error.mean()}
        return {"seconds": seconds} | {key: float(value) for key, value in figures.items()} | {"density %": 100 * share}

    return {
        name: [row(*of) for of in zip(runs, density[name], full[name], strict=True)] for name, runs in found.items()
    }


def truth_of(source: dict[str, Any]) -> np.ndarray:
    """The true depth (h, w) of the reference; ValueError where it has none."""
    scene = open_scene(**source)
    if scene.reference.truth is None:
        raise ValueError(f"{scene.name}: no truth to judge by")
    return scene.reference.truth


def tune(source: dict[str, Any], threads: int) -> tuple[dict[str, dict[str, Any]], list[dict[str, Any]]]:
    """The setting of each installed method with the least mean absolute error on a scene, and the rows of all
    settings.
    """
    settings = {name: method.settings() for name, method in METHODS.items() if installed(name, method.package)}
    judged = errors(maps(source, settings, threads), truth_of(source))
    best = {name: settings[name][int(np.nanargmin([row["MAE"] for row in rows]))] for name, rows in judged.items()}
    rows = [
        {
            "method": name,
            **setting,
            "MAE": row["MAE"],
            "density %": row["density %"],
            "taken": "x" if setting == best[name] else "",
        }
        for name in settings
        for setting, row in zip(settings[name], judged[name], strict=True)
    ]
    return best, [{key: row.get(key) for key in dict.fromkeys(key for row in rows for key in row)} for row in rows]


def report(
    best: Mapping[str, dict[str, Any]], judged: Sequence[Mapping[str, dict[str, float]]]
) -> list[dict[str, Any]]:
    """A row for each method: means over the scenes, and the standard deviation between scenes of the MAE."""
    rows = []
    for name, setting in best.items():
        scenes = [figures[name] for figures in judged]
        means = {key: float(np.mean([scene[key] for scene in scenes])) for key in scenes[0]}
        spread: dict[str, Any] = {
            "MAE, deviation": float(np.std([scene["MAE"] for scene in scenes], ddof=1)) if scenes[1:] else None
        }
        edge = ", ".join(METHODS[name].at_edge(setting)) or None
        chosen = ", ".join(f"{key} {value:g}" for key, value in setting.items())
        about = {"method": name, "setting": chosen or None, "at the edge of the grid": edge}
        rows.append({**about, **means, **spread})
    return rows


def main(arguments: list[str] | None = None) -> None:
    """Measure, write, print."""
    options = parse(arguments)
    development, tests = sources(options)
    best, grid = tune(development, options.threads)
    facts = {"tuned on": open_scene(**development).name, "threads": options.threads}
    judged, title, heading = (
        [],
        "Fusion: what one might take instead",
        "Errors in 1e-3 of the unit, means over the scenes",
    )
    for source in tests:
        say(open_scene(**source).name)
        found = maps(source, {name: [setting] for name, setting in best.items()}, options.threads)
        figures = errors(found, truth_of(source))
        judged.append({name: rows[0] for name, rows in figures.items()})
        facts["reported on"] = "; ".join(open_scene(**source).name for source in tests[: len(judged)])
        tables = {heading: report(best, judged), "Tuning": grid}
        save("fusion_baselines", title, tables, facts, options.output)
    publish("fusion_baselines", title, tables, facts, options.output)


def sources(options: argparse.Namespace) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """Arguments of `open_scene`, for the development scene and the reported ones."""
    if options.views:
        development, *tests = [
            {"views": str(path.resolve()), "count": options.count} for path in (options.tune, *options.views)
        ]
        return development, tests
    shape = {"count": options.count, "shape": [options.size[1], options.size[0]]}
    return shape | {"seed": SEEDS[0]}, [shape | {"seed": seed} for seed in SEEDS[1]]


def parse(arguments: list[str] | None) -> argparse.Namespace:
    """The command line; --quick is a quarter of the pixels."""
    parser = parser_of(__doc__, "320 240 unless given otherwise")
    parser.add_argument("--tune", type=Path, help="a views artefact with a truth to choose the settings on")
    parser.add_argument(
        "--views", type=Path, nargs="+", help="views artefacts with a truth to report on; the middle view of each"
    )
    add_generated(parser)
    add_threads(parser)
    options = parser.parse_args(arguments)
    if bool(options.tune) != bool(options.views):
        parser.error("--tune and --views go together: no method is reported on the scene that it is tuned on")
    options.size = size_of(options)
    return options


if __name__ == "__main__":
    main()
