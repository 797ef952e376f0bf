"""How far a map that is fused in tiles is from the one fused at once, what it costs, and how much is read for it.

    python -m benchmarks.fusion.tiles [--quick]

On the generated scene, from views in memory. Differences are in noise scales, over the pixels that somebody saw.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.fusion import scene
from benchmarks.kit.arguments import parser_of
from benchmarks.kit.publish import publish, say
from ipcli.measurements.views import View
from ipcli.models.fusion.fuse import Fused, fuse
from ipcli.models.fusion.parameters import Fusion
from ipcli.models.fusion.tiles import fuse_in_tiles
from ipcli.models.fusion.windows import Window

NAME, TITLE = "fusion_tiles", "Fusion: in tiles beside at once"
SHAPE, SIDES, VIEWS = (768, 1024), (512, 256), 3
QUICK_SHAPE, QUICK_SIDES = (192, 256), (128,)


def tiled(views: Sequence[View], side: int) -> tuple[Fused, float]:
    """The map in tiles of that side, and the pixels that were read of the views, by those that they have."""
    read = []

    def part(k: int, window: Window) -> View:
        found = window.camera(views[k])
        read.append(found.depth.size)
        return found

    fused = fuse_in_tiles(views, views[len(views) // 2], Fusion(), side, inverse=False, part=part)
    return fused, sum(read) / sum(view.depth.size for view in views)


def apart(fused: Fused, whole: Fused) -> dict[str, float]:
    """By how many noise scales two maps differ where something was observed."""
    both = (fused.observations > 0) & (whole.observations > 0)
    difference = np.abs(fused.depth - whole.depth)[both] / whole.noise_scale
    median, most = np.quantile(difference, [0.5, 0.99])
    return {"apart, median": float(median), "99 %": float(most), "greatest": float(difference.max())}


def rows_of(shape: tuple[int, int], sides: Sequence[int]) -> list[dict[str, Any]]:
    """A row of the fusion at once and one for each side."""
    views, rows = scene.views(VIEWS, shape), []
    reference = views[VIEWS // 2]
    small = scene.views(VIEWS, (64, 64))
    fuse(small, small[0], Fusion(), inverse=False)  # compiles
    started = time.process_time()
    whole = fuse(views, reference, Fusion(), inverse=False)
    rows.append({"side": 0, "CPU s": time.process_time() - started, "error": error(whole, reference, whole)})
    for side in sides:
        say(f"tiles of {side} px")
        started = time.process_time()
        fused, read = tiled(views, side)
        row = {"side": side, "CPU s": time.process_time() - started, "error": error(fused, reference, whole)}
        rows.append(row | apart(fused, whole) | {"views read, times": read})
    return rows


def error(fused: Fused, reference: View, whole: Fused) -> float:
    """The mean error of a map, in noise scales of that at once."""
    assert reference.truth is not None
    return float(np.nanmean(np.abs(fused.depth - reference.truth)) / whole.noise_scale)


def main(arguments: list[str] | None = None) -> None:
    """Measure, write, print."""
    options = parser_of(__doc__, "256 x 192").parse_args(arguments)
    shape, sides = (QUICK_SHAPE, QUICK_SIDES) if options.quick else (SHAPE, SIDES)
    publish(NAME, TITLE, {f"{shape[1]} x {shape[0]}, {VIEWS} views": rows_of(shape, sides)}, {}, options.output)


if __name__ == "__main__":
    main()
