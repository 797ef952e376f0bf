"""The peak memory of fuse-depth beside its limit and what it said before it started.

    python -m benchmarks.fusion.memory [--quick]

Views of a wavy ground are rendered by `ipcli render-views` and fused by `ipcli fuse-depth --max-memory`, each in a
process of its own. Few iterations do: memory does not grow with them.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.kit.arguments import parser_of
from benchmarks.kit.publish import publish, say
from ipcli.io.files import ply

NAME, TITLE = "fusion_memory", "Fusion: peak memory against the limit"
CASES = ((5480, 3650, 3, "2GB"),)  # width, height, views, limit
QUICK_CASES = ((1600, 1000, 3, "820MB"), (1600, 1000, 3, "8GB"))
SETTINGS = ("--set", "fusion.solver.iterations=2", "--rounds", "1")
SAID = re.compile(r"(at once|in tiles of \d+ px): about ([\d.]+) (MB|GB)")


def ground(path: Path, side: int = 300) -> None:
    """A mesh 600 wide with waves and steps, seen whole from 300 above."""
    x, y = np.meshgrid(*2 * [np.linspace(-300, 300, side)])
    z = 12 * np.sin(x / 23) * np.cos(y / 17) + 8 * (np.sin(x / 7 + y / 9) > 0.7)
    number = np.arange(side * side, dtype=np.int32).reshape(side, side)
    a, b, c, d = (part.ravel() for part in (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]))
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    ply.write(path, np.stack([x, y, z], axis=-1).reshape(-1, 3).astype(np.float32), faces=faces)


def ipcli(*words: object) -> tuple[str, float, float]:
    """What a command said on stderr, the peak of its resident set in MB and its CPU seconds; RuntimeError if it
    fails.
    """
    with tempfile.TemporaryFile("w+") as said:
        child = subprocess.Popen(
            [sys.executable, "-m", "ipcli", *map(str, words)], stderr=said, stdout=subprocess.DEVNULL
        )
        _, status, used = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        said.seek(0)
        text = said.read()
    if child.returncode:
        raise RuntimeError(text.strip().splitlines()[-1])
    return text, used.ru_maxrss * (1 if sys.platform == "darwin" else 1024) / 1e6, used.ru_utime + used.ru_stime


def measured(folder: Path, width: int, height: int, views: int, limit: str) -> dict[str, Any]:
    """A row of the table."""
    say(f"{width} x {height}, {views} views, --max-memory {limit}")
    source, mesh = folder / f"{width}-{views}.views.h5", folder / "ground.ply"
    if not source.exists():
        ground(mesh)
        camera = ("--width", width, "--height", height, "--focal", round(0.9 * width))
        ipcli(
            "render-views", mesh, "-o", source, "--path", "strip", "--views", views, "--noise", "laplace:0.6", *camera
        )
    output = folder / f"{limit}.fused.h5"
    text, peak, cpu = ipcli("fuse-depth", source, "-o", output, "--max-memory", limit, "-v", *SETTINGS)
    found = SAID.search(text)
    way, amount = (found[1], float(found[2]) * (1000 if found[3] == "GB" else 1)) if found else ("not said", None)
    row = {"Mpx": width * height / 1e6, "K": views, "limit": limit, "way": way, "said MB": amount, "peak MB": peak}
    return row | {"peak / said": peak / amount if amount else None, "CPU s": cpu}


def main(arguments: list[str] | None = None) -> None:
    """Measure, write, print."""
    options = parser_of(__doc__, "1.6 Mpx; about a minute").parse_args(arguments)
    with tempfile.TemporaryDirectory() as folder:
        rows = [measured(Path(folder), *case) for case in (QUICK_CASES if options.quick else CASES)]
    publish(NAME, TITLE, {"Cases": rows}, {}, options.output)


if __name__ == "__main__":
    main()
