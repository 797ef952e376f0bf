"""Native parsers that a damaged file can crash, or send into a loop or a hunger for memory, run in a child process.

    content = guarded(parse, str(path), seconds=60, memory=2 << 30)

`parse` is a function of a module, its arguments and its result can be pickled. The child has a limit on time and, where
the system knows its size, on memory. It lives on for the next file, so that a folder of many costs one start.
"""

from __future__ import annotations

import atexit
import os
import pickle
import signal
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from threading import Lock
from typing import Any

SECONDS = 60.0
MEMORY = 2 << 30  # bytes beyond those of the child at rest
SERVE = "from ipcli.io.files.guarded import serve; serve()"
STATM = Path("/proc/self/statm")


class ParserFailed(Exception):
    """The parser raised something, crashed, or went beyond a limit; the message says which."""


_lock = Lock()
_children: list[subprocess.Popen[bytes]] = []


def guarded(parse: Callable[..., Any], *args: Any, seconds: float = SECONDS, memory: int = MEMORY) -> Any:
    """What `parse(*args)` returns, computed in a child process. Raises ParserFailed for all that can go wrong there."""
    request = pickle.dumps((parse.__module__, parse.__name__, args, seconds, memory))
    with _lock:
        child = _child()
        try:
            assert child.stdin is not None
            assert child.stdout is not None
            child.stdin.write(request)
            child.stdin.flush()
            is_done, value = pickle.load(child.stdout)
        except (EOFError, OSError, pickle.UnpicklingError):
            raise ParserFailed(_cause(_ended(child), seconds)) from None
        except BaseException:  # interrupted: the answer to this question must not be taken for that to the next
            _ended(child)
            raise
    if not is_done:
        raise ParserFailed(value)
    return value


def _child() -> subprocess.Popen[bytes]:
    """The child that waits for work, started if there is none, or only that of the process this one is a fork of."""
    if not _children or _children[0].poll() is not None or getattr(_children[0], "owner", None) != os.getpid():
        _children.clear()
        single = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
        env = os.environ | single | {"PYTHONPATH": os.pathsep.join(path or os.getcwd() for path in sys.path)}
        pipes: dict[str, Any] = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
        child = subprocess.Popen([sys.executable, "-c", SERVE], env=env, **pipes)
        child.owner = os.getpid()  # type: ignore[attr-defined]
        _children.append(child)
    return _children[0]


def _ended(child: subprocess.Popen[bytes]) -> int:
    """End the child, if it has not ended yet; its exit code."""
    _children.clear()
    with suppress(subprocess.TimeoutExpired):
        child.wait(0.5)
    child.kill()
    code = child.wait()
    for pipe in (child.stdin, child.stdout):
        with suppress(OSError):
            if pipe is not None:
                pipe.close()
    return code


def _cause(code: int, seconds: float) -> str:
    if code == -signal.SIGALRM:
        return f"its parser took longer than {seconds:g} s"
    return f"its parser crashed ({signal.Signals(-code).name})" if code < 0 else f"its parser ended with code {code}"


@atexit.register
def _end_all() -> None:
    for child in list(_children):
        if getattr(child, "owner", None) == os.getpid():
            child.kill()
            child.wait()


def serve() -> None:
    """Answer requests from stdin until it ends: the life of the child. What a parser prints goes nowhere."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    while True:
        try:
            module, name, args, seconds, memory = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        try:
            parse = getattr(import_module(module), name)
            _limit_memory(memory)
            signal.setitimer(signal.ITIMER_REAL, seconds)
            answer = pickle.dumps((True, parse(*args)))
        except MemoryError:
            answer = pickle.dumps((False, f"its parser asked for more than {memory / 2**30:.3g} GiB of memory"))
        except Exception as error:
            answer = pickle.dumps((False, " ".join(str(error).split()) or type(error).__name__))
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0)
        answers.write(answer)
        answers.flush()


def _limit_memory(memory: int) -> None:
    if STATM.exists():
        import resource

        now = int(STATM.read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (now + memory, resource.getrlimit(resource.RLIMIT_AS)[1]))
