"""How time and memory of the fusion grow with pixels, observations and threads, beside the memory bandwidth.

    python -m benchmarks.fusion.scaling [--quick]

Every case runs in a process of its own; see README.md for what the tables say.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, overload

import numpy as np

from benchmarks.kit.arguments import parser_of
from benchmarks.kit.measure import Clock, attempted, best_of, exponent, forget_peak, isolated, peak_memory
from benchmarks.kit.publish import publish, save, say
from ipcli.measurements.views import View

NAME, TITLE = "fusion_scaling", "Fusion: growth of time and memory"
MIDDLE = (1.0, 11)  # Mpx and K that stay while the other one grows
PIXELS = (0.3, 1.0, 3.0, 12.0)  # Mpx
OBSERVATIONS = (3, 11, 21, 41)
THREADS = (1, 2)
ASPECT = 4 / 3
BLOCKS, TOGETHER = 7, 16  # timed blocks of iterations; the solver exchanges rows as often
STREAM = 20_000_000  # numbers in each of the three arrays of the triad: far more than any cache holds


def triad(threads: int) -> float:
    """STREAM triad a = b + 3 c in float64: the best of several runs, in GB/s of two reads and one write."""
    from concurrent.futures import ThreadPoolExecutor

    run = _compiled_triad()
    a, b, c = (np.full(STREAM, value) for value in (0.0, 1.0, 2.0))
    parts = [slice(STREAM * i // threads, STREAM * (i + 1) // threads) for i in range(threads)]
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(lambda part: run(a[part], b[part], c[part]), parts))  # compiles
        seconds, _ = best_of(7, lambda: list(pool.map(lambda part: run(a[part], b[part], c[part]), parts)))
    return 3 * a.nbytes / seconds / 1e9


def _compiled_triad():
    from numba import njit

    @njit(nogil=True)
    def run(a, b, c):
        for i in range(a.size):
            a[i] = b[i] + 3.0 * c[i]

    return run


def iteration(shape: tuple[int, int], count: int) -> dict[str, float]:
    """Milliseconds an iteration at full size, and peak memory of it, in MB above what the process had before.

    The observations are plain random numbers: the kernels do the same work on any.
    """
    from ipcli.inverse.regularize import tgv
    from ipcli.inverse.regularize.fidelity import AbsoluteDeviations, Observations
    from ipcli.inverse.regularize.parameters import Regulariser, Solver

    def prepare(shape):
        rng = np.random.default_rng(0)
        layers = np.stack([rng.standard_normal(shape, np.float32) for _ in range(count)])
        return AbsoluteDeviations(Observations.of(list(layers)), np.full(shape, 0.3, np.float32)), tgv.Iterate.at(
            layers[0]
        )

    def advance(fidelity, iterate):
        clock = Clock()
        with clock:
            iterate.advance(fidelity, Regulariser(), Solver(), [1.9] * TOGETHER)
        return 1e3 * clock.last / TOGETHER

    advance(*prepare((64, 64)))
    fidelity, iterate = prepare(tuple(shape))
    before = forget_peak()
    milliseconds = [advance(fidelity, iterate) for _ in range(BLOCKS)]
    return {"ms": float(np.median(milliseconds)), "memory": peak_memory() - before}


def fusion(shape: tuple[int, int], count: int) -> dict[str, float]:
    """Seconds of a whole fusion at the defaults, from views in memory to the fused map, and peak memory.

    The memory is that of the fusion above the views, in MB; the process has the peak of `all`.
    """
    from benchmarks.fusion import scene
    from ipcli.models.fusion.fuse import fuse
    from ipcli.models.fusion.parameters import Fusion

    warm = scene.views(count, (64, 64))
    fuse(warm, warm[count // 2], Fusion(), inverse=False)
    views = scene.views(count, as_shape(shape))
    before = forget_peak()
    started, started_cpu = time.perf_counter(), time.process_time()
    fused = fuse(views, views[count // 2], Fusion(), inverse=False)
    seconds, cpu = time.perf_counter() - started, time.process_time() - started_cpu
    return {
        "seconds": seconds,
        "cpu": cpu,
        "iterations": float(fused.history[-1, 1]),
        "memory": peak_memory() - before,
        "all": peak_memory(),
    }


def tiled(shape: tuple[int, int], count: int) -> dict[str, float]:
    """As `fusion`, tile by tile, of views that are read from disk whenever a tile asks for them; the memory counts the
    views too.
    """
    import tempfile

    from benchmarks.fusion import scene
    from ipcli.models.fusion import footprint, tiles
    from ipcli.models.fusion.fuse import fuse
    from ipcli.models.fusion.parameters import Fusion

    warm = scene.views(count, (64, 64))
    fuse(warm, warm[count // 2], Fusion(), inverse=False)
    with tempfile.TemporaryDirectory() as folder:
        views = ViewsOnDisk(Path(folder), shape, count)
        reference, before = views[count // 2], forget_peak()
        started, started_cpu = time.perf_counter(), time.process_time()
        fused = tiles.fuse_in_tiles(views, reference, Fusion(), footprint.SIDE, inverse=False)
        seconds, cpu = time.perf_counter() - started, time.process_time() - started_cpu
    error = float(
        np.nanmean(np.abs(fused.depth - scene.cast(as_shape(shape), reference.intrinsics, reference.cam_from_world)))
    )
    return {"seconds": seconds, "cpu": cpu, "memory": peak_memory() - before, "error": error}


class ViewsOnDisk(Sequence[View]):
    """Views of the generated scene in files, read when they are asked for."""

    def __init__(self, folder: Path, shape: tuple[int, int], count: int):
        from benchmarks.fusion import scene

        self.folder = folder
        self.cameras: list[View] = []
        for k in range(count):
            view = scene.view(k, count, as_shape(shape))
            np.save(folder / f"{k}.npy", view.depth)
            self.cameras.append(replace(view, depth=np.empty((0, 0), np.float32), truth=None))

    def __len__(self) -> int:
        return len(self.cameras)

    @overload
    def __getitem__(self, k: int) -> View: ...

    @overload
    def __getitem__(self, k: slice) -> Sequence[View]: ...

    def __getitem__(self, k: int | slice) -> View | Sequence[View]:
        if isinstance(k, slice):
            return [self[index] for index in range(*k.indices(len(self)))]
        return replace(self.cameras[k], depth=np.load(self.folder / f"{k}.npy"))


def in_tiles(cases: Sequence[tuple[float, int]], threads: int) -> list[dict[str, Any]]:
    """A row for each (Mpx, K)."""
    rows = []
    for megapixels, count in cases:
        say(f"{megapixels:g} Mpx, K = {count}, in tiles, threads: {threads}")
        row: dict[str, Any] = {"Mpx": megapixels, "K": count, "threads": threads}
        found = attempted("benchmarks.fusion.scaling:tiled", threads, shape=shape_of(megapixels), count=count)
        if "failed" in found:
            rows.append(row | found)
            continue
        row |= {"s": found["seconds"], "CPU s": found["cpu"], "MB": found["memory"]}
        row["one copy of the observations, MB"] = 4 * megapixels * count
        rows.append(row | {"mean error, 1e-3": 1e3 * found["error"]})
    return rows


def as_shape(shape: Sequence[int]) -> tuple[int, int]:
    """(h, w), whether it came as a tuple or, to another process, as a list."""
    h, w = shape
    return h, w


def shape_of(megapixels: float) -> tuple[int, int]:
    """(h, w) of an image of this size."""
    height = round((megapixels * 1e6 / ASPECT) ** 0.5)
    return height, round(height * ASPECT)


def cases(
    pixels: tuple[float, ...], observations: tuple[int, ...], middle: tuple[float, int]
) -> list[tuple[float, int]]:
    """(Mpx, K) along both axes through the middle."""
    return sorted({(size, middle[1]) for size in pixels} | {(middle[0], k) for k in observations})


def measured(megapixels: float, count: int, threads: int) -> dict[str, Any]:
    """A row of the table; a case that the machine cannot do says so."""
    say(f"{megapixels:g} Mpx, K = {count}, threads: {threads}")
    row: dict[str, Any] = {"Mpx": megapixels, "K": count, "threads": threads}
    arguments = {"shape": shape_of(megapixels), "count": count}
    one = attempted("benchmarks.fusion.scaling:iteration", threads, **arguments)
    if "failed" in one:
        return row | one
    whole = attempted("benchmarks.fusion.scaling:fusion", threads, **arguments)
    if "failed" in whole:
        return row | whole
    numbers = megapixels * 1e6 * count
    row |= {"ms / iteration": one["ms"], "ns / observation": 1e6 * one["ms"] / numbers, "iteration MB": one["memory"]}
    row |= {
        "fusion s": whole["seconds"],
        "fusion CPU s": whole["cpu"],
        "fine iterations": whole["iterations"],
        "fusion MB": whole["memory"],
    }
    return row | {"bytes / observation": 1e6 * whole["memory"] / numbers, "peak RSS MB": whole["all"]}


QUANTITIES = ("ms / iteration", "fusion s", "fusion MB", "peak RSS MB")


def exponents(rows: list[dict[str, Any]], middle: tuple[float, int]) -> list[dict[str, Any]]:
    """Slopes of log quantity against log size by least squares: against pixels x K, and along each axis."""
    done = [row for row in rows if "failed" not in row]
    axes = {
        "pixels x K": (lambda row: row["Mpx"] * row["K"], lambda row: True),
        f"pixels, K = {middle[1]}": (lambda row: row["Mpx"], lambda row: row["K"] == middle[1]),
        f"K, {middle[0]:g} Mpx": (lambda row: row["K"], lambda row: row["Mpx"] == middle[0]),
    }
    table = []
    for threads in sorted({row["threads"] for row in done}):
        for axis, (size, belongs) in axes.items():
            of_axis = [row for row in done if row["threads"] == threads and belongs(row)]
            slopes = {
                quantity: exponent([size(row) for row in of_axis], [row[quantity] for row in of_axis])
                for quantity in QUANTITIES
            }
            table.append({"threads": threads, "exponent against": axis} | slopes)
    return table


def bandwidth(rows: list[dict[str, Any]], speeds: dict[int, float]) -> list[dict[str, Any]]:
    """The triad beside what an iteration moves: x, v, p, q read and written, data and weights read, once a pass of
    iterations.
    """
    from ipcli.inverse.regularize.tgv import AT_ONCE

    table = []
    for threads, speed in speeds.items():
        own = [row for row in rows if row["threads"] == threads and "failed" not in row]
        moved = [
            4e6 * row["Mpx"] * (2 * 8 + 3 + row["K"]) / AT_ONCE / (1e-3 * row["ms / iteration"]) / 1e9 for row in own
        ]
        row = {"threads": threads, "STREAM triad GB/s": speed}
        table.append(
            row
            | {"iteration GB/s, median": float(np.median(moved)) if moved else None, "least": min(moved, default=None)}
        )
    return table


def main(arguments: list[str] | None = None) -> None:
    """Measure, write, print."""
    options = parse(arguments)
    middle = (
        min(options.pixels, key=lambda size: abs(size - MIDDLE[0])),
        min(options.observations, key=lambda k: abs(k - MIDDLE[1])),
    )
    say("STREAM triad")
    speeds = {threads: isolated("benchmarks.fusion.scaling:triad", threads, threads=threads) for threads in THREADS}
    rows, tables = [], {}
    for case in cases(options.pixels, options.observations, middle):
        rows += [measured(*case, threads) for threads in THREADS]
        tables = {"Cases": rows, "Growth": exponents(rows, middle), "Bandwidth": bandwidth(rows, speeds)}
        save(NAME, TITLE, tables, {}, options.output)
    largest = max(options.pixels)
    corners = sorted({(largest, middle[1]), (largest, max(options.observations))})
    tables["In tiles, views read from disk"] = in_tiles(corners, max(THREADS))
    publish(NAME, TITLE, tables, {}, options.output)


def parse(arguments: list[str] | None) -> argparse.Namespace:
    """The command line."""
    parser = parser_of(__doc__, "0.1 0.3 Mpx and 3 11 views unless given otherwise; about half a minute")
    parser.add_argument("--pixels", type=float, nargs="+", help="sizes in Mpx; 0.3 1 3 12")
    parser.add_argument("--observations", type=int, nargs="+", help="numbers of views; 3 11 21 41")
    options = parser.parse_args(arguments)
    options.pixels = tuple(options.pixels or ((0.1, 0.3) if options.quick else PIXELS))
    options.observations = tuple(options.observations or ((3, 11) if options.quick else OBSERVATIONS))
    return options


if __name__ == "__main__":
    main()
