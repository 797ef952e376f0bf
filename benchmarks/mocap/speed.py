"""How long it takes to learn and to recognise actions, and the memory that it takes, by the commands themselves.

    python -m benchmarks.mocap.speed --clips build/experiments/mocap-hdm05/all.clips.h5
    python -m benchmarks.mocap.speed --clips sample_data/motions --quick

Each row is a process of its own; see README.md for what the tables say.
"""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.kit.arguments import parser_of
from benchmarks.kit.measure import best_of, exponent, forget_peak, isolated, peak_memory
from benchmarks.kit.publish import publish, say

MODELS = {  # 6, 7 and 8 mixtures an action
    "groups alone": ("--set", "learning.features.body=false", "--motion", "0"),
    "and the body": ("--motion", "0"),
    "and motion, the default": (),
}
EXECUTORS = ("serial", "processes:2")
FRAMES = (12_500, 25_000, 50_000, 100_000)
QUICK = ("--frames", "60", "--set", "learning.mixture.sweeps=10", "--set", "learning.mixture.burn_in=5")


def trained(clips: str, output: str, options: list[str]) -> dict[str, Any]:
    """mocap-train once: seconds of the clock and of the processor, its workers' included."""
    from ipcli.cli.main import main

    before, started = os.times(), time.perf_counter()
    if main(["mocap-train", clips, "-o", output, "--quiet", *options]):
        raise RuntimeError("mocap-train failed")
    after = os.times()
    mixtures, actions, frames = _learnt(output)
    spent = sum(after[:4]) - sum(before[:4])
    return {
        "actions": actions,
        "mixtures": mixtures,
        "frames of an action": frames,
        "seconds": time.perf_counter() - started,
        "CPU s": spent,
    }


def _learnt(output: str) -> tuple[int, int, str]:
    from ipcli.io.files import h5

    artefact = h5.read(Path(output), "behaviours")
    most = artefact.provenance["params"]["learning"]["frames"]
    counts = np.minimum(artefact.arrays["frames"], most)
    return artefact.arrays["alpha"].size, len(artefact.arrays["actions"]), f"{counts.min()} to {counts.max()}"


def recognised(model: str, clips: str, output: str) -> dict[str, float]:
    """Whole clips named by mocap-classify: seconds of everything, reading and writing included, and the peak above the
    start.
    """
    from ipcli.cli.main import main

    start, started = forget_peak(), time.perf_counter()
    if main(["mocap-classify", model, clips, "-o", output, "--quiet"]):
        raise RuntimeError("mocap-classify failed")
    return {"seconds": time.perf_counter() - started, "MB": peak_memory() - start}


def answered(model: str, clips: str) -> list[dict[str, Any]]:
    """Seconds of the steps of recognition in memory, best of three."""
    from ipcli.io.files import h5
    from ipcli.models.mocap import behaviours, recognition
    from ipcli.models.mocap.parameters import Decision, Features
    from ipcli.stages.mocap.parameters import ClipReading
    from ipcli.stages.mocap.reading import read

    arrays, decision = h5.read(Path(model), "behaviours").arrays, Decision()
    learnt, body = behaviours.of_arrays(arrays), behaviours.body_of_arrays(arrays, "model")
    known = read([Path(clips)], ClipReading(), body.groups, body.skeleton)
    count = int(known.lengths.sum())
    measured, features = best_of(3, lambda: known.features(body.lengths, Features()))
    dense, density = best_of(3, lambda: recognition.log_densities(learnt, features))
    joined, _ = best_of(3, lambda: recognition.frame_posteriors(learnt, density, decision))
    steps = {"features": measured, "densities": dense, "answers": joined, "all": measured + dense + joined}
    return [
        {"step": step, "frames": count, "seconds": seconds, "million frames a minute": 60e-6 * count / seconds}
        for step, seconds in steps.items()
    ]


def repeated(clips: Path, frames: int, output: Path) -> Path:
    """A clips artefact of so many frames: those of `clips` again and again under new names."""
    from ipcli.io.files import h5
    from ipcli.io.motion import artefact
    from ipcli.stages.mocap.parameters import ClipSource
    from ipcli.stages.mocap.reading import open_source

    source = open_source(clips, ClipSource())
    arrays = artefact.clips_arrays([source.load(name) for name in source.names], {})
    total = int(arrays["frames"].sum())
    times, rest = divmod(frames, total)
    ends = np.cumsum(arrays["frames"])
    last = int(np.searchsorted(ends, rest))  # whole clips, and a part of the next
    counts = np.concatenate(
        [np.tile(arrays["frames"], times), arrays["frames"][:last], [rest - (ends[last - 1] if last else 0)]]
    )
    index = np.concatenate([np.tile(np.arange(len(ends)), times), np.arange(last + 1)])[counts > 0]
    tiled = {
        name: np.concatenate([np.tile(arrays[name], (times, *[1] * (arrays[name].ndim - 1))), arrays[name][:rest]])
        for name in _framed(arrays)
    }
    each = {name: arrays[name][index] for name in ("labels", "actors", "rates")}
    names = np.array([f"{arrays['clips'][clip]} {number}" for number, clip in enumerate(index)])
    h5.write(output, "clips", arrays | tiled | each | {"clips": names, "frames": counts[counts > 0]}, {})
    return output


def _framed(arrays: dict[str, np.ndarray]) -> list[str]:
    return [name for name in ("positions", "rotations", "frame_labels") if name in arrays]


def learning(clips: Path, folder: Path, more: Sequence[str]) -> list[dict[str, Any]]:
    """A row a set of mixtures and executor."""
    rows: list[dict[str, Any]] = []
    warm = {"clips": str(clips), "output": str(folder / "warm.h5"), "options": list(QUICK)}
    isolated("benchmarks.mocap.speed:trained", 1, **warm)  # compiles, fills caches
    for models, options in MODELS.items():
        for executor in EXECUTORS:
            say(f"{models}, {executor}")
            output = folder / f"{len(rows)}.model.h5"
            row = isolated(
                "benchmarks.mocap.speed:trained",
                1,
                clips=str(clips),
                output=str(output),
                options=[*options, *more, "--executor", executor],
            )
            rows.append({"what": models, "executor": executor} | row)
    return rows


def growth(model: Path, clips: Path, folder: Path, counts: Sequence[int]) -> list[dict[str, Any]]:
    """A row a number of frames."""
    rows = []
    for count in counts:
        say(f"{count} frames")
        take = repeated(clips, count, folder / f"{count}.clips.h5")
        found = isolated(
            "benchmarks.mocap.speed:recognised",
            1,
            model=str(model),
            clips=str(take),
            output=str(folder / f"{count}.recognition.h5"),
        )
        rows.append(
            {"frames": count}
            | found
            | {"million frames a minute": 60e-6 * count / found["seconds"], "kB a frame": 1e3 * found["MB"] / count}
        )
    return rows


def growth_of(rows: Sequence[dict[str, Any]], quantity: str) -> str:
    """The exponent of a quantity's growth with the number of frames, to two decimals."""
    found = exponent([row["frames"] for row in rows], [row[quantity] for row in rows])
    return "unknown" if found is None else f"{found:.2f}"


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, write and print."""
    parser = parser_of(__doc__, "short chains, few frames")
    parser.add_argument("--clips", type=Path, required=True, help="what import-clips or mocap-train read")
    given = parser.parse_args(arguments)
    clips = given.clips.resolve()
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        tables = {"Learning": learning(clips, folder, QUICK if given.quick else ())}
        model, counts = folder / "4.model.h5", (2_000, 4_000) if given.quick else FRAMES  # the defaults
        take = repeated(clips, counts[0], folder / "steps.clips.h5")
        tables["Recognition, in memory, one thread"] = isolated(
            "benchmarks.mocap.speed:answered", 1, model=str(model), clips=str(take)
        )
        tables["mocap-classify"] = growth(model, clips, folder, counts)
    facts = {f"exponent of {of}": growth_of(tables["mocap-classify"], of) for of in ("seconds", "MB")}
    publish(
        "mocap_speed", "Learning and recognising actions", tables, facts | {"clips": given.clips.name}, given.output
    )


if __name__ == "__main__":
    main()
