"""Names of joints as files give them: told apart where a file gives one of them twice."""

from __future__ import annotations

from collections.abc import Sequence


def numbered(names: Sequence[str]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The names, a number behind each that was there before, and a note that says so (or none).

    `numbered(["a", "b", "a"])` has the names a, b, a_2.
    """
    taken, found, again = set(names), [], []
    seen: set[str] = set()
    for name in names:
        unique, count = name, 1
        while unique in seen or (unique != name and unique in taken):
            count += 1
            unique = f"{name}_{count}"
        seen.add(unique)
        found.append(unique)
        again += [name] if unique != name else []
    if not again:
        return tuple(found), ()
    shown = ", ".join(dict.fromkeys(again))[:80]
    return tuple(found), (f"several joints are named {shown}: told apart by numbers",)
