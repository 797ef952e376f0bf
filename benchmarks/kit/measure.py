"""Measuring and telling: a function in a process of its own, its peak memory, and tables as JSON and Markdown."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
OUTPUT = ROOT / "build" / "benchmarks"
THREAD_VARIABLES = ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def isolated(function: str, threads: int, /, **arguments: Any) -> Any:
    """What "module:function" returns for these arguments, all of it JSON, in a fresh process with so many threads.

    RuntimeError, with the last line of what it said, if it fails.
    """
    environment = os.environ | dict.fromkeys(THREAD_VARIABLES, str(threads)) | {"PYTHONPATH": _path()}
    command = [sys.executable, "-m", "benchmarks.kit.measure", function, json.dumps(arguments)]
    done = subprocess.run(command, env=environment, cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode:
        said = done.stderr.strip().splitlines() or [f"ended with {done.returncode}"]
        raise RuntimeError(f"{function}: {said[-1]}")
    return json.loads(done.stdout.splitlines()[-1])


def _path() -> str:
    return os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])


def peak_memory() -> float:
    """Peak resident set of this process so far, in MB (1e6 bytes).

    From /proc where there is one: getrusage on Linux includes the parent's memory at the moment of the fork.
    """
    status = Path("/proc/self/status")
    if status.exists():
        return _kilobytes(status.read_text(), "VmHWM") * 1024 / 1e6
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024) / 1e6


def forget_peak() -> float:
    """Make the peak start anew where the system allows it; the memory in use (failing that, the peak), in MB."""
    with suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")
    return peak_memory()


def _kilobytes(status: str, name: str) -> int:
    return next(int(line.split()[1]) for line in status.splitlines() if line.startswith(name + ":"))


class Clock:
    """Seconds spent inside `with clock:`, added up, and the last of them."""

    def __init__(self) -> None:
        self.total = self.last = 0.0

    def __enter__(self) -> None:
        self._started = time.perf_counter()

    def __exit__(self, *_: object) -> None:
        self.last = time.perf_counter() - self._started
        self.total += self.last


def say(text: str) -> None:
    """A line of progress on stderr."""
    print(text, file=sys.stderr, flush=True)


def table(rows: Sequence[Mapping[str, Any]]) -> str:
    """A Markdown table with the keys of the rows as columns."""
    columns = list(dict.fromkeys(key for row in rows for key in row))
    cells = [columns, ["---"] * len(columns), *([_cell(row.get(column)) for column in columns] for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in cells)


def _cell(value: Any) -> str:
    if value is None:
        return "-"
    return (
        f"{value:.3g}"
        if isinstance(value, float) and not 100 <= abs(value) < 1e6
        else f"{value:.0f}"
        if isinstance(value, float)
        else str(value)
    )


def publish(
    name: str, title: str, tables: Mapping[str, Sequence[Mapping[str, Any]]], facts: Mapping[str, Any], output: Path
) -> None:
    """Write NAME.json and NAME.md into the folder and print the latter; `facts` say how it was measured."""
    print(save(name, title, tables, facts, output))


def save(
    name: str, title: str, tables: Mapping[str, Sequence[Mapping[str, Any]]], facts: Mapping[str, Any], output: Path
) -> str:
    """The same without printing, for what is measured so far; the text of NAME.md."""
    from ipcli.io.files import atomic

    facts = machine() | dict(facts)
    lines = [f"# {title}", "", *(f"- {key}: {_cell(value)}" for key, value in facts.items())]
    for heading, rows in tables.items():
        lines += ["", f"## {heading}", "", table(rows)]
    text = "\n".join(lines)
    output.mkdir(parents=True, exist_ok=True)
    atomic.write_text(output / f"{name}.json", json.dumps({"facts": facts, "tables": tables}, indent=1) + "\n")
    atomic.write_text(output / f"{name}.md", text + "\n")
    return text


def machine() -> dict[str, Any]:
    """What the figures depend on: processor, load by others, versions."""
    import platform
    from importlib import metadata

    load = f"{os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "unknown"
    known = {item.metadata["Name"].lower(): item.version for item in metadata.distributions()}
    names = (
        "numpy",
        "numba",
        "pylops",
        "pyproximal",
        "odl",
        "scikit-image",
        "scikit-learn",
        "aeon",
        "open3d-cpu",
        "open3d",
    )
    return {
        "time": time.strftime("%Y-%m-%d %H:%M:%S"),
        "processor": f"{_processor()}, {os.cpu_count()} logical",
        "load at the end (1 min, our own included)": load,
        "python": platform.python_version(),
        "libraries": ", ".join(f"{name} {known[name]}" for name in names if name in known),
    }


def _processor() -> str:
    import platform

    info = Path("/proc/cpuinfo")
    models = (
        [line.split(":")[1].strip() for line in info.read_text().splitlines() if line.startswith("model name")]
        if info.exists()
        else []
    )
    return models[0] if models else platform.processor() or platform.machine()


def main() -> None:
    """Call a function for `isolated` and print what it returns."""
    module, _, name = sys.argv[1].partition(":")
    print(json.dumps(getattr(import_module(module), name)(**json.loads(sys.argv[2]))))


if __name__ == "__main__":
    main()
