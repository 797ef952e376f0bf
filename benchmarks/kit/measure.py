"""Measuring: a function in a process of its own, its peak memory, its seconds, the law of their growth."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from benchmarks.kit.publish import say

T = TypeVar("T")
ROOT = Path(__file__).resolve().parents[2]
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


def attempted(function: str, threads: int, /, **arguments: Any) -> dict[str, Any]:
    """The row that `isolated` returns, or one that says why it failed, for tables that go on with the next case."""
    try:
        return isolated(function, threads, **arguments)
    except RuntimeError as error:
        return {"failed": str(error)}


def installed(name: str, package: str) -> bool:
    """Whether a peer's package is there; says that the peer is left out if it is not."""
    there = find_spec(package) is not None
    if not there:
        say(f"{name}: {package} is not installed, skipped")
    return there


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
    """Seconds spent inside `with clock:`, added up, and the last of them; and the processor's in the last."""

    def __init__(self) -> None:
        self.total = self.last = self.processor = 0.0

    def __enter__(self) -> None:
        self._started, self._worked = time.perf_counter(), time.process_time()

    def __exit__(self, *_: object) -> None:
        self.last, self.processor = time.perf_counter() - self._started, time.process_time() - self._worked
        self.total += self.last


def best_of(runs: int, work: Callable[[], T]) -> tuple[float, T]:
    """The least seconds of several runs, and what the last one returned."""
    clock, seconds = Clock(), []
    for _ in range(runs):
        with clock:
            found = work()
        seconds.append(clock.last)
    return min(seconds), found


def exponent(sizes: Sequence[float], values: Sequence[float]) -> float | None:
    """The exponent of the law of growth by least squares on logarithms, 1 if linear; None where it cannot be told."""
    if len(set(sizes)) < 2 or min(values) <= 0:
        return None
    return float(np.polyfit(np.log(sizes), np.log(values), 1)[0])


def main() -> None:
    """Call a function for `isolated` and print what it returns."""
    module, _, name = sys.argv[1].partition(":")
    print(json.dumps(getattr(import_module(module), name)(**json.loads(sys.argv[2]))))


if __name__ == "__main__":
    main()
