"""Seconds of saliency: membranes of a surface, a picture, and a recording from its files to proto-objects.

python -m benchmarks.saliency.speed --recording FOLDER      its first half, then all, and what a long one would take
python -m benchmarks.saliency.speed --quick                 a generated walk of a few frames
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.kit.arguments import add_threads, parser_of
from benchmarks.kit.measure import Clock, attempted, exponent, forget_peak, peak_memory
from benchmarks.kit.publish import publish

NODES, STEPS, WINDOW = 12_000, 30, 1.0
RUNS = 7
LONG = 1500  # frames of a long recording
QUICK_FRAMES = 40


def membranes(nodes: int) -> dict[str, Any]:
    """The energy of so many membranes: over a window, and at single times; milliseconds, the least of some runs."""
    from ipcli.models.saliency.membranes import energies, energies_in_time, modes
    from ipcli.models.saliency.scene_parameters import Membranes

    rng = np.random.default_rng(0)
    sigma, z, radius = rng.uniform(0.2, 1, nodes), rng.uniform(0.3, 3, nodes), rng.uniform(0.05, 0.3, nodes)
    p, times = Membranes(), np.linspace(0, WINDOW, STEPS)
    once, _ = _least(lambda: energies_in_time(sigma, z, radius, times, p), 1)
    window, steps = (_least(work) for work in (
        lambda: energies(sigma, z, radius, WINDOW, p), lambda: energies_in_time(sigma, z, radius, times, p)
    ))  # fmt: skip
    orders, roots = modes().roots.shape
    row: dict[str, Any] = {"nodes": nodes, "modes": f"{orders} x {roots}", "steps": STEPS}
    for name, pair in (("over a window", window), ("all steps", steps)):
        row |= {f"{name} [ms]": 1e3 * pair[0], f"{name}, CPU [ms]": 1e3 * pair[1]}
    return row | {"first time [ms]": 1e3 * once}


def picture(width: int, height: int) -> dict[str, Any]:
    """A picture's map by what needs no learning, seconds."""
    import cv2

    from ipcli.models.saliency.image_model import saliency

    rng = np.random.default_rng(0)
    rgb = np.clip(rng.normal(120, 40, (height, width, 3)), 0, 255).astype(np.uint8)
    rgb = cv2.GaussianBlur(rgb, (0, 0), 2).astype(np.uint8)
    first, _ = _least(lambda: saliency(rgb), 1)
    seconds, spent = _least(lambda: saliency(rgb))
    return {"size": f"{width} x {height}", "seconds": seconds, "CPU s": spent, "first time": first}


def _least(work: Callable[[], object], runs: int = RUNS) -> tuple[float, float]:
    """The least seconds of some runs, and the least CPU seconds: what others do on the machine does not count there."""
    clock, rows = Clock(), []
    for _ in range(runs):
        with clock:
            work()
        rows.append((clock.last, clock.processor))
    return min(row[0] for row in rows), min(row[1] for row in rows)


def recording(folder: str, frames: int) -> dict[str, Any]:
    """gaze-sfm and then saliency on the first frames of a recording, files read and written, pages included."""
    from ipcli.params import Run
    from ipcli.stages.gaze import gaze_sfm
    from ipcli.stages.gaze.parameters import GazeSfm, RecordingSource
    from ipcli.stages.saliency import saliency
    from ipcli.stages.saliency.parameters import Saliency

    row: dict[str, Any] = {"frames": frames}
    with tempfile.TemporaryDirectory() as place:
        run, scene = Path(place) / "run.gaze.h5", Path(place) / "run.saliency.h5"
        _step(
            row,
            "gaze-sfm",
            lambda: gaze_sfm.run(Path(folder), run, GazeSfm(source=RecordingSource(stop=frames)), Run()),
        )
        _step(row, "saliency", lambda: saliency.run(run, scene, Saliency(), Run()))
    row["seconds in all"] = row["gaze-sfm [s]"] + row["saliency [s]"]
    row["CPU s in all"] = row["gaze-sfm CPU [s]"] + row["saliency CPU [s]"]
    return row


def _step(row: dict[str, Any], name: str, work: Callable[[], object]) -> None:
    """Seconds, CPU seconds and the peak of memory of a step."""
    start, clock = forget_peak(), Clock()
    with clock:
        work()
    row[f"{name} [s]"], row[f"{name} CPU [s]"] = clock.last, clock.processor
    row[f"{name} [MB]"] = peak_memory() - start


def foretold(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """What a long recording would take by the law of growth between the rows, never taken for less than linear."""
    if len(rows) < 2 or any("failed" in row for row in rows):
        return {"frames": LONG, "failed": "no two rows to go by"}
    sizes = [row["frames"] for row in rows]
    found: dict[str, float] = {}
    for name in ("seconds in all", "CPU s in all"):
        law = max(1.0, exponent(sizes, [row[name] for row in rows]) or 1.0)
        found |= {name: rows[-1][name] * (LONG / sizes[-1]) ** law, f"exponent of {name}": law}
    return {"frames": LONG, "foretold": "yes"} | found


def generated(folder: Path, frames: int) -> Path:
    """A walk through a room, as a folder."""
    from experiments.gaze import room

    room.write_euroc(room.walk(room.Course(frames=frames, width=200, height=150, rate=10.0), 1), folder)
    return folder


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, write and print."""
    parser = parser_of(__doc__, "a generated walk of a few frames")
    parser.add_argument("--recording", type=Path, help="folder of any layout that gaze-sfm reads, with gaze")
    parser.add_argument("--frames", type=int, default=180, help="of it; 180")
    add_threads(parser)
    given = parser.parse_args(arguments)
    frames = QUICK_FRAMES if given.quick else given.frames
    tables = {
        "Membranes": [attempted("benchmarks.saliency.speed:membranes", 1, nodes=NODES)],
        "A picture": [attempted("benchmarks.saliency.speed:picture", 1, width=800, height=600)],
    }
    with tempfile.TemporaryDirectory() as place:
        if given.quick or given.recording is not None:
            folder = generated(Path(place), frames) if given.recording is None else given.recording.resolve()
            case = {"folder": str(folder)}
            rows = [
                attempted("benchmarks.saliency.speed:recording", given.threads, **case, frames=part)
                for part in (frames // 2, frames)
            ]
            tables["From a recording to proto-objects"] = [*rows, foretold(rows)]
    publish("saliency_speed", "Saliency", tables, {"threads": given.threads}, given.output)


if __name__ == "__main__":
    main()
