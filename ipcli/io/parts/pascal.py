"""PASCAL-Part annotations (.mat; Chen et al., CVPR 2014), parsed in a process of its own: a damaged file can crash the
parser or make it ask for all memory.
"""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from ipcli.errors import FormatError

SECONDS = 60.0
MOST_NAMED = 20  # objects that a message names
MOST_BYTES = 200_000_000  # of the file
MOST_MEMORY = 4_000_000_000  # of the process that reads it


def read(path: Path, which: int = 0) -> tuple[tuple[str, ...], np.ndarray]:
    """Names of the parts of object number `which` and its labels (h, w) int16; smaller parts lie on larger ones, and
    what no part covers of the object is "rest". Raises FormatError.
    """
    if not path.is_file() or path.stat().st_size > MOST_BYTES:
        raise FormatError(path, "no file, or too large", expected=f"at most {MOST_BYTES} bytes")
    pool = ProcessPoolExecutor(1, mp_context=get_context("spawn"), initializer=_limit)
    try:
        found = pool.submit(_parse, str(path), which).result(timeout=SECONDS)
    except (BrokenProcessPool, TimeoutError, MemoryError) as error:
        raise FormatError(path, "cannot be read: its parser crashed or took too long", fix="Copy it again") from error
    finally:
        for process in list((pool._processes or {}).values()):
            process.terminate()
        pool.shutdown(wait=False, cancel_futures=True)
    if isinstance(found, str):
        raise FormatError(path, f"not PASCAL-Part annotations ({found})")
    return found


def _limit() -> None:
    try:
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))
    except (ImportError, ValueError, OSError):
        pass  # a system without limits


def _parse(path: str, which: int) -> tuple[tuple[str, ...], np.ndarray] | str:
    """Names and labels, or what is wrong in words."""
    from scipy.io import loadmat

    try:
        content = loadmat(path, struct_as_record=False, squeeze_me=True)
        objects = np.atleast_1d(content["anno"].objects)
        if not 0 <= which < len(objects):
            held = ", ".join(
                f"{number} {getattr(thing, 'class', '?')}" for number, thing in enumerate(objects[:MOST_NAMED])
            )
            return f"it holds {len(objects)} objects ({held}), number {which} is asked for"
        return _labels(objects[which])
    except Exception as error:  # the parser lets out whatever it stumbles over
        return f"{type(error).__name__}: {' '.join(str(error).split())}"


def _labels(thing) -> tuple[tuple[str, ...], np.ndarray]:
    whole = np.asarray(thing.mask) > 0
    masks = {str(part.part_name): np.asarray(part.mask) > 0 for part in np.atleast_1d(thing.parts)}
    order = sorted(masks, key=lambda name: -int(masks[name].sum()))
    labels = np.where(whole, np.int16(len(order) + 1), np.int16(0))
    for number, name in enumerate(order, start=1):
        labels[masks[name]] = number
    return (*order, "rest"), labels
