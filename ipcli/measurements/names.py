"""Items by name: where one is in a sequence, and its neighbours."""

from __future__ import annotations

import re
from collections.abc import Sequence

from ipcli.errors import ParameterError, nearest


def natural(name: str) -> tuple[list[tuple[int, str]], str]:
    """The key of the order in which people number things: 2 before 10, whatever stands around the numbers."""
    parts = re.split(r"([0-9]+)", name)
    return [(int(part), "") if k % 2 else (0, part) for k, part in enumerate(parts)], name


def window(names: Sequence[str], reference: str, k: int) -> tuple[str, ...]:
    """The ``k`` consecutive names centred at ``reference``, moved inwards at the ends of the sequence.

    Fewer only if there are fewer in all. An even ``k`` takes the extra name after the reference. Raises ParameterError
    for an unknown reference or k < 1.
    """
    if k < 1:
        raise ParameterError(f"window of {k} views: give at least 1")
    start = position(names, reference) - (k - 1) // 2
    start = max(0, min(start, len(names) - k))
    return tuple(names[start : start + k])


def position(names: Sequence[str], name: str, what: str = "view") -> int:
    """Index of a view in the sequence; ParameterError naming the nearest one if it is not there."""
    try:
        return names.index(name)
    except ValueError:
        raise ParameterError(f"no {what} '{name}' among the {len(names)} there are{nearest(name, names)}") from None
