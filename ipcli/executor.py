"""One function over many named items: in this process, in a pool of processes, or on a Dask cluster; the same result.

`executor` is "serial", "processes:N" (spawned, one inner thread each), "dask" (a local cluster) or "dask:ADDRESS".
Standard library only: a spawned worker must set its thread counts before it loads numpy.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future, as_completed
from concurrent.futures.process import BrokenProcessPool, ProcessPoolExecutor
from contextlib import ExitStack, contextmanager
from functools import partial
from typing import Any, NamedTuple

from ipcli.errors import IpcliError, ParameterError
from ipcli.progress import Progress, silent
from ipcli.threads import set_count


class ItemsFailed(IpcliError):
    """Some items failed; `failed` has the reason of each by name, `done` the results of all the others."""

    def __init__(self, failed: dict[str, str], done: dict[str, Any]):
        self.failed, self.done = failed, done
        reasons = "; ".join(f"{name}: {reason}" for name, reason in failed.items())
        super().__init__(
            f"{len(failed)} of {len(failed) + len(done)} items failed ({reasons}). Run again for only those"
        )


class Attempt(NamedTuple):
    """What became of one item. A reason is text because not every exception can travel between processes."""

    result: Any
    reason: str | None


def map_items(
    function: Callable[[str], Any], items: Sequence[str], executor: str = "serial", progress: Progress = silent
) -> dict[str, Any]:
    """`{name: function(name)}` in the order of `items`. One that fails does not stop the others; then ItemsFailed.

    `function` must be importable (a module's function, or a `partial` of one) unless serial. `progress` is told the
    share done and the name just finished. ParameterError for an unknown executor or names that repeat.
    """
    if len(set(items)) != len(items):
        raise ParameterError(f"items repeat: {', '.join(sorted({name for name in items if items.count(name) > 1}))}")
    attempt = partial(_attempt, function)
    attempts: dict[str, Attempt] = {}
    for name, outcome in _attempts(attempt, items, executor):
        attempts[name] = outcome
        progress(len(attempts) / len(items), name)
    done = {name: attempts[name].result for name in items if attempts[name].reason is None}
    failed = {name: reason for name in items if (reason := attempts[name].reason) is not None}
    if failed:
        raise ItemsFailed(failed, done)
    return done


def _attempt(function: Callable[[str], Any], name: str) -> Attempt:
    try:
        return Attempt(function(name), None)
    except Exception as error:
        return Attempt(None, _reason(error))


def _reason(error: BaseException) -> str:
    text = " ".join(str(error).split())
    return text if isinstance(error, IpcliError) else f"{type(error).__name__}: {text}"


def _attempts(attempt: Callable, items: Sequence[str], spec: str) -> Iterator[tuple[str, Attempt]]:
    scheme, _, place = spec.partition(":")
    if spec == "serial":
        return ((name, attempt(name)) for name in items)
    if scheme == "processes" and place.isdecimal() and len(place) < 5 and int(place) > 0:
        return _in_processes(attempt, items, int(place))
    if scheme == "dask":
        return _on_dask(attempt, items, place)
    raise ParameterError(f"unknown executor '{spec}' (expected serial, processes:N, dask or dask:ADDRESS)")


def _in_processes(attempt: Callable, items: Sequence[str], workers: int) -> Iterator[tuple[str, Attempt]]:
    """A worker that dies breaks its pool and all that waits in it: those items get a pool each, to find the culprit."""
    waiting = []
    with _pool(min(workers, max(len(items), 1))) as pool:
        for name, outcome in _submitted(pool, attempt, items):
            if outcome is None:
                waiting.append(name)
            else:
                yield name, outcome
    for item in waiting:
        with _pool(1) as pool:
            for name, outcome in _submitted(pool, attempt, [item]):
                yield name, outcome or Attempt(None, "worker process died; it may have run out of memory")


@contextmanager
def _pool(workers: int) -> Iterator[Executor]:
    from multiprocessing import active_children, get_context

    others = set(active_children())
    pool = ProcessPoolExecutor(workers, get_context("spawn"), initializer=_start_worker)
    try:
        yield pool
    except BaseException as error:
        if not isinstance(error, Exception):  # an interrupt or SIGTERM: do not wait for the items that are running
            for worker in set(active_children()) - others:
                worker.terminate()
        raise
    finally:
        pool.shutdown(cancel_futures=True)


def _start_worker() -> None:
    """One inner thread, and an end as soon as the parent is gone: a killed parent cannot tell its workers.

    Not by PR_SET_PDEATHSIG: Linux alone has it, it comes at the end of the thread that started the worker rather than
    of the process, and a parent that died before it was asked for is missed. The thread here waits for native code
    that keeps the interpreter to itself: such a worker ends when that returns.
    """
    set_count(1)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    from multiprocessing import parent_process
    from multiprocessing.connection import wait

    if parent := parent_process():
        wait([parent.sentinel])
        os._exit(1)


def _submitted(pool: Executor, attempt: Callable, items: Sequence[str]) -> Iterator[tuple[str, Attempt | None]]:
    """Items as they finish; None for one whose worker, or whose neighbour's, died."""
    names = {_submit(pool, attempt, name): name for name in items}
    for future in as_completed(names):
        error = future.exception()
        if isinstance(error, BrokenProcessPool):
            yield names[future], None
        else:
            yield names[future], future.result() if error is None else Attempt(None, _reason(error))


def _submit(pool: Executor, attempt: Callable, name: str) -> Future:
    """A pool that broke while it was still being filled refuses more: say so as it does for the items it holds."""
    try:
        return pool.submit(attempt, name)
    except BrokenProcessPool as error:
        refused: Future = Future()
        refused.set_exception(error)
        return refused


def _on_dask(attempt: Callable, items: Sequence[str], address: str) -> Iterator[tuple[str, Attempt]]:
    try:
        from distributed import Client, LocalCluster
    except ImportError as error:
        raise ParameterError("executor dask needs Dask: pip install 'ipcli[cluster]', or use processes:N") from error
    with ExitStack() as stack:
        cluster = address or stack.enter_context(LocalCluster(threads_per_worker=1, dashboard_address=None))
        client = stack.enter_context(Client(cluster, set_as_default=False))
        for name, outcome in _submitted(client.get_executor(pure=False), attempt, items):
            yield name, outcome or Attempt(None, "its worker died")
