"""The one limit on memory. Readers ask it before they ask for memory; a large fusion goes in tiles that keep it.

It is that of --max-memory or IPCLI_MAX_MEMORY, else SHARE of what the machine has, or of what a container (cgroup) may
have where that is less. Workers are told by the environment. Standard library only, since every command loads it.
"""

from __future__ import annotations

import os
import re
from functools import cache
from pathlib import Path

from ipcli.errors import FormatError, ParameterError

VARIABLE = "IPCLI_MAX_MEMORY"
SHARE = 0.75
LEAST = 1 << 26  # bytes, less than which no command can work in
AMOUNT = re.compile(r"(\d{1,12}(?:\.\d{1,6})?)\s*(%|[kmgt]?(?:i?b)?)", re.IGNORECASE)
GROUPS, MEMBERSHIP = Path("/sys/fs/cgroup"), Path("/proc/self/cgroup")
FILES = ("memory.max", "memory.limit_in_bytes")  # of version 2 and of version 1
RAISE = "Raise --max-memory if the machine has more"


def set_budget(text: str | None) -> None:
    """Set the limit, such as "2GB", "512MiB" or "50%" of the machine, for this process and those it starts."""
    if text:
        parse(text)
        os.environ[VARIABLE] = text


def budget() -> int:
    """The limit in bytes. Raises ParameterError for an environment that names none."""
    text = os.environ.get(VARIABLE, "")
    return parse(text) if text else int(SHARE * machine())


def parse(text: str) -> int:
    """Bytes of an amount; a share is one of the machine's memory, kB are 1000 and KiB 1024 bytes."""
    found = AMOUNT.fullmatch(text.strip())
    if found is None:
        raise ParameterError(f"--max-memory: no amount of memory: '{text}' (expected such as 2GB, 512MiB or 50%)")
    number, unit = float(found[1]), found[2].lower()
    if unit == "%":
        amount = number / 100 * machine()
    else:
        power = "kmgt".find(unit[:1]) + 1 if unit and unit[0] in "kmgt" else 0
        amount = number * (1024 if "i" in unit else 1000) ** power
    if not LEAST <= amount < 1 << 62:
        raise ParameterError(f"--max-memory: {text} (expected {told(LEAST)} or more)")
    return int(amount)


@cache
def machine() -> int:
    """Bytes of memory that this process could have at the most."""
    return min([_physical(), *_groups()])


def _physical() -> int:
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):  # Windows
        return 8 << 30


def _groups() -> list[int]:
    """Limits of the control groups that this process is in, and of those above them."""
    try:
        lines = MEMBERSHIP.read_text().splitlines()
    except OSError:
        return []
    limits = []
    for _, controllers, place in (line.split(":", 2) for line in lines if line.count(":") > 1):
        if controllers and "memory" not in controllers.split(","):
            continue
        top = GROUPS / "memory" if controllers else GROUPS
        own = top / place.lstrip("/")
        folders = [own, *own.parents]
        limits += [_limit(folder) for folder in folders if folder.is_relative_to(top)]
    return [limit for limit in limits if limit]


def _limit(folder: Path) -> int:
    """The limit of one control group in bytes, 0 for none."""
    for name in FILES:
        try:
            text = (folder / name).read_text().strip()
        except OSError:
            continue
        return int(text) if text.isdecimal() else 0  # "max"
    return 0


def check(path: Path | str, need: int, what: str, fix: str = RAISE) -> None:
    """FormatError if what a file holds would take `need` bytes and more than the limit."""
    if need > budget():
        got = f"{what}, which take{'' if what.endswith('s') else 's'} {told(need)}"
        raise FormatError(path, "too large for the memory", expected=f"at most {told(budget())}", got=got, fix=fix)


def told(amount: float) -> str:
    """Bytes in words, as `1.9 GB`."""
    for unit, power in (("GB", 9), ("MB", 6)):
        if amount >= 10**power:
            return f"{amount / 10**power:.3g} {unit}"
    return f"{amount / 1e3:.3g} kB"
