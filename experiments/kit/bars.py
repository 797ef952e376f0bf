"""What an experiment is held to: bars.csv beside a chapter's code, and the section of the page that compares.

The head of the file is `experiment`, one or more columns that name the measure, `bar`, `goal`, `why`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from experiments.kit.tables import read_rows
from ipcli.report.kit.numbers import DASH, number
from ipcli.report.kit.page import Markup, section, table

AROUND = ("experiment", "bar", "goal", "why")  # columns that do not name the measure


@dataclass(frozen=True)
class Bar:
    """What one measure is held to: a number, or the name of a peer whose figure in the same run is to be surpassed."""

    measure: tuple[str, ...]
    bar: float | str
    goal: float | None
    why: str


@dataclass(frozen=True)
class Standing:
    """A bar, its measure in words (a cell each), the figure that it asks for, and what each method reached.

    The figure asked for is NaN where the peer was not run; methods that were not run are left out.
    """

    bar: Bar
    words: tuple[str, ...]
    asked: float
    reached: Mapping[str, float]


def read_bars(path: Path, experiment: str) -> list[Bar]:
    """The bars of one experiment, in the order of the file."""
    return [
        Bar(
            tuple(text for column, text in row.items() if column not in AROUND),
            _number_or_name(row["bar"]),
            float(row["goal"]) if row["goal"] else None,
            row["why"],
        )
        for row in read_rows(path)
        if row["experiment"] == experiment
    ]


def _number_or_name(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text


def bars_section(
    standings: Sequence[Standing], default: str, heads: Sequence[str], *, least: bool, unit: str = "", lead: str
) -> Markup | None:
    """What was to be reached and what was, by the default and by the best method; None without bars.

    `heads` are those of the measure's words; `least`: small figures are good ones.
    """
    best = "least" if least else "most"
    of = f", {unit}" if unit else ""
    columns = (*heads, f"bar{of}", f"goal{of}", f"{default}, the default{of}", "met", f"{best}{of}", "met")
    rows = [_row(one, default, least) for one in standings]
    return section("What it is held to", table((*columns, "the bar is"), rows), lead=lead) if rows else None


def _row(one: Standing, default: str, least: bool) -> tuple[str, ...]:
    bar, reached = one.bar, one.reached
    goal = DASH if bar.goal is None else number(bar.goal)
    asked = f"{bar.bar}: {number(one.asked)}" if isinstance(bar.bar, str) else number(one.asked)
    own = reached.get(default, float("nan"))
    cells = (*one.words, asked, goal, number(own), met(own, one.asked, bar.goal, least=least))
    if not reached:
        return (*cells, DASH, DASH, bar.why)
    first = min(reached, key=lambda method: reached[method] * (1 if least else -1))
    told = f"{number(reached[first])} by {first}"
    return (*cells, told, met(reached[first], one.asked, bar.goal, least=least), bar.why)


def met(reached: float, asked: float, goal: float | None, *, least: bool) -> str:
    """`no`, `yes` or `the goal too`; a dash where either figure is not known."""
    if np.isnan(reached) or np.isnan(asked):
        return DASH
    sign = 1 if least else -1
    if sign * reached > sign * asked:
        return "no"
    return "the goal too" if goal is not None and sign * reached <= sign * goal else "yes"
