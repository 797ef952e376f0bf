"""How many threads, and blocks of image rows on them.

Kernels release the interpreter lock, so plain threads run them side by side.

A parallel loop of numba would meet at a barrier in every kernel, some thousand times a second; on a machine that does
other work too, each such meeting can cost a time slice. Blocks that run on their own for a while meet seldom.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from functools import cache
from typing import TypeVar

VARIABLES = ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")
Item = TypeVar("Item")
Result = TypeVar("Result")


def set_count(count: int) -> None:
    """Threads of ours and of numba, OpenMP and OpenBLAS, before these are loaded; 0 leaves the choice to them."""
    if count:
        os.environ.update(dict.fromkeys(VARIABLES, str(count)))


def count() -> int:
    """Threads to use: those that were set, or the processors this process may run on."""
    return int(os.environ.get(VARIABLES[0]) or available())


def available() -> int:
    """Processors that this process may run on."""
    return (len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()) or 1


def blocks(height: int, least: int = 1) -> list[tuple[int, int]]:
    """(top, bottom) of blocks of rows, one a thread, of at least `least` rows each."""
    number = max(min(count(), height // least), 1)
    edges = [height * i // number for i in range(number + 1)]
    return list(zip(edges[:-1], edges[1:], strict=True))


def each(function: Callable[[Item], Result], items: Sequence[Item]) -> list[Result]:
    """The function of every item, side by side, in their order. Within such a function, `each` goes one by one."""
    if len(items) == 1 or getattr(_thread, "is_worker", False):
        return [function(item) for item in items]
    return list(_pool(count()).map(function, items))


def ahead(function: Callable[[Item], Result], items: Iterable[Item]) -> Iterator[Result]:
    """The function of every item in order, one worked out while the one before is used; one by one with one thread."""
    if count() == 1 or getattr(_thread, "is_worker", False):
        yield from map(function, items)
        return
    with ThreadPoolExecutor(1) as pool:
        coming: Future[Result] | None = None
        for item in items:
            following = pool.submit(function, item)
            if coming is not None:
                yield coming.result()
            coming = following
        if coming is not None:
            yield coming.result()


_thread = threading.local()


@cache
def _pool(workers: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(workers, initializer=lambda: setattr(_thread, "is_worker", True))
