"""All executors give the same; failures are told at the end, and cost no other item."""

import os
import signal
import subprocess
import sys
import threading
import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from ipcli.errors import IpcliError, NoSolution, ParameterError
from ipcli.executor import ItemsFailed, map_items
from ipcli.rng import stream
from ipcli.threads import set_count

NAMES = [f"scene{index}" for index in range(6)]


def draw(name, seed=0):
    return stream(seed, "test", name).standard_normal(1000).tobytes()


def fail_some(name):
    if name == "scene1":
        raise NoSolution("no overlap")
    if name == "scene2":
        raise ZeroDivisionError("two\nlines")
    return name.upper()


class Untransportable(IpcliError):
    """Cannot be pickled back: its constructor takes two arguments."""

    def __init__(self, one, two):
        super().__init__(f"{one} {two}")


def fail_untransportably(name):
    raise Untransportable("a", "b")


def unpicklable_result(name):
    return threading.Lock() if name == "scene1" else name


def die(name):
    if name == "scene1":
        os.kill(os.getpid(), signal.SIGKILL)
    return name


def inner_threads(name):
    return [os.environ[variable] for variable in ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")]


def test_processes_give_the_bytes_of_the_serial_run_in_its_order():
    serial = map_items(partial(draw, seed=5), NAMES)
    pooled = map_items(partial(draw, seed=5), NAMES[::-1], "processes:2")
    assert pooled == serial
    assert list(serial) == NAMES
    assert list(pooled) == NAMES[::-1]


def test_dask_gives_the_bytes_of_the_serial_run():
    pytest.importorskip("distributed")
    assert map_items(draw, NAMES, "dask") == map_items(draw, NAMES)
    with pytest.raises(ItemsFailed) as caught:
        map_items(fail_some, NAMES, "dask")
    assert caught.value.failed == {"scene1": "no overlap", "scene2": "ZeroDivisionError: two lines"}


def test_dask_missing_says_what_to_install(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "distributed", None)
    with pytest.raises(ParameterError, match=r"pip install 'ipcli\[cluster\]'"):
        map_items(draw, NAMES, "dask:tcp://localhost:1")


@pytest.mark.parametrize("executor", ["serial", "processes:2"])
def test_failures_are_listed_and_the_others_done(executor):
    with pytest.raises(ItemsFailed) as caught:
        map_items(fail_some, NAMES, executor)
    assert caught.value.failed == {"scene1": "no overlap", "scene2": "ZeroDivisionError: two lines"}
    assert caught.value.done == {name: name.upper() for name in NAMES if name not in ("scene1", "scene2")}
    assert str(caught.value).startswith(
        "2 of 6 items failed (scene1: no overlap; scene2: ZeroDivisionError: two lines)"
    )
    assert caught.value.exit_code == 1


def test_failures_that_cannot_travel_between_processes_stay_failures_of_their_item():
    with pytest.raises(ItemsFailed) as caught:
        map_items(fail_untransportably, NAMES[:2], "processes:1")
    assert caught.value.failed == dict.fromkeys(NAMES[:2], "a b")
    with pytest.raises(ItemsFailed) as caught:
        map_items(unpicklable_result, NAMES[:3], "processes:1")
    assert caught.value.failed.keys() == {"scene1"}
    assert caught.value.done == {"scene0": "scene0", "scene2": "scene2"}


def test_a_worker_that_is_killed_takes_only_its_item_with_it():
    with pytest.raises(ItemsFailed) as caught:
        map_items(die, NAMES[:4], "processes:2")
    assert caught.value.failed == {"scene1": "worker process died; it may have run out of memory"}
    assert caught.value.done.keys() == {"scene0", "scene2", "scene3"}


def test_workers_run_one_inner_thread_each():
    assert map_items(inner_threads, ["a"], "processes:1") == {"a": ["1", "1", "1"]}


def test_set_count_leaves_the_choice_to_the_libraries_at_zero(monkeypatch):
    monkeypatch.setattr(os, "environ", {})
    set_count(0)
    assert os.environ == {}
    set_count(3)
    assert set(os.environ.values()) == {"3"}


@pytest.mark.parametrize("executor", ["serial", "processes:2"])
def test_progress_rises_to_one_and_tells_every_name(executor):
    told = []
    map_items(str.upper, NAMES[:4], executor, lambda fraction, name: told.append((fraction, name)))
    np.testing.assert_allclose([fraction for fraction, _ in told], [0.25, 0.5, 0.75, 1.0])
    assert {name for _, name in told} == set(NAMES[:4])


UNKNOWN = "|parallel|processes|processes:0|processes:-1|processes:two|processes:²|serial:2|processes:"


@pytest.mark.parametrize("executor", [*UNKNOWN.split("|"), "processes:" + "9" * 5000], ids=lambda text: text[:12])
def test_an_unknown_executor_is_a_usage_error(executor):
    with pytest.raises(ParameterError, match="expected serial, processes:N, dask or dask:ADDRESS"):
        map_items(str.upper, ["a"], executor)


def test_repeated_names_are_refused_since_results_go_by_name():
    with pytest.raises(ParameterError, match="items repeat: a"):
        map_items(str.upper, ["a", "b", "a"])


def test_no_items_is_no_work():
    assert map_items(fail_some, [], "processes:2") == {}


def test_an_interrupt_is_not_an_item_that_failed():
    def interrupt(name):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        map_items(interrupt, NAMES)


def sleep_long(folder, name):
    (Path(folder) / f"{name}.tmp").write_text(str(os.getpid()))
    (Path(folder) / f"{name}.tmp").rename(Path(folder) / name)
    time.sleep(60)


def is_running(pid):
    """Whether the process still runs: one that ended but was not yet waited for does not."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="needs /proc")
@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGINT])
def test_workers_end_with_their_parent(tmp_path, how):
    code = "import signal; from functools import partial; from ipcli.executor import map_items; "
    code += "from tests.test_executor import sleep_long; signal.signal(2, signal.default_int_handler); "
    code += f"map_items(partial(sleep_long, {str(tmp_path)!r}), ['a'], 'processes:1')"
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    with subprocess.Popen([sys.executable, "-c", code], env=environment, stderr=subprocess.DEVNULL) as parent:
        until(lambda: (tmp_path / "a").exists(), 30)
        parent.send_signal(how)
        until(lambda: not is_running((tmp_path / "a").read_text()), 5)


def until(condition, seconds):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.05)
