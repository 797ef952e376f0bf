"""Search tasks: table 3.1 by both splits, extents (figure 3.14), what was seen and predicted (3.15), proto-objects in
coherent regions in the limited and the free domain (3.16), and what membranes add.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from experiments.kit.arguments import Arguments
from experiments.kit.bars import Standing, bars_section, read_bars
from experiments.kit.run import Findings, page_of, quick_lead
from ipcli.io.files import h5
from ipcli.report.kit.curves import Series, plot
from ipcli.report.kit.numbers import number
from ipcli.report.kit.page import element, figure, gallery, section, table
from ipcli.report.kit.pictures import photograph
from ipcli.report.saliency.saliency import marked

BARS = Path(__file__).with_name("bars.csv")
OURS = "saliency"
HIGH = ("accuracy", "times chance", "extents of 1 to 10 %")  # large is good
Row = dict[str, object]
Runs = dict[str, dict[str, dict[str, np.ndarray]]]  # by way, by task


def findings(arguments: Arguments) -> Findings:
    """Page and rows."""
    runs: Runs = {}
    for path in arguments.files:
        way, task = path.name.split(".")[:2]
        runs.setdefault(way, {})[task] = h5.read(path, "saliency").arrays
    rows = [row for way, found in runs.items() for row in measures(way, found)] + membranes(runs["sequence"])
    by_key = {(row["data"], row["measure"]): float(row["value"]) for row in rows}  # type: ignore[arg-type]
    parts = []
    for least in (True, False):
        held = [
            Standing(bar, bar.measure, float(bar.bar), {OURS: by_key[bar.measure]} if bar.measure in by_key else {})
            for bar in read_bars(BARS, "tasks")
            if bar.measure[1].startswith(HIGH) != least
        ]
        parts.append(
            bars_section(
                held, OURS, ("way", "measure"), least=least, lead="Small is good." if least else "Large is good."
            )
        )
    first = next(iter(runs["sequence"].values()))
    parts += [_rates(runs), _extents(runs["sequence"]), _seen(first), _objects(runs), _worth(runs["sequence"])]
    cells = [(row["data"], row["measure"], number(float(row["value"]), 4)) for row in rows]  # type: ignore[arg-type]
    parts.append(section("All measures", table(("way", "measure", "value"), cells)))
    lead = quick_lead("two short tasks") if arguments.quick else ""
    return Findings(
        page_of("saliency", "Search tasks: what was looked for, and what was predicted", lead, *parts), rows
    )


def measures(way: str, found: Mapping[str, Mapping[str, np.ndarray]]) -> list[Row]:
    """Means over tasks of error rates, hits and rankings."""
    values: dict[str, float] = {"tasks": len(found)}
    rates = [a["folds/rates"] for a in found.values() if len(a.get("folds/rates", ()))]
    if rates:
        mean = np.nanmean(np.concatenate(rates), axis=0)
        values |= {"balanced error rate": mean[4], "accuracy": mean[3], "misses": mean[1], "false alarms": mean[2]}
    hits = np.nanmean([a["hits"] for a in found.values()], axis=0)
    for name, (share, chance) in zip(("at that time", "ever"), hits, strict=True):
        values |= {f"proto-objects looked at {name}": share, f"nodes looked at {name}": chance}
        values[f"times chance, {name}"] = share / chance
    ranking = np.nanmean(np.concatenate([a["subsequences/ranking"] for a in found.values()]), axis=0)
    names = next(iter(found.values()))["rankings"]
    values |= {f"area under the curve, {name}": value for name, value in zip(names, ranking, strict=True)}
    extents = np.concatenate([a["extents"][:, 1] for a in found.values()])
    extents = extents[extents > 0]
    values["extents of 1 to 10 %"] = float(((extents >= 0.01) & (extents <= 0.1)).mean())
    return [{"data": way, "measure": measure, "value": float(value)} for measure, value in values.items()]


def membranes(found: Mapping[str, Mapping[str, np.ndarray]]) -> list[Row]:
    """Balanced error rates with and without the membranes' score among the features, task by task."""
    rows: list[Row] = []
    for task, a in found.items():
        if not len(a.get("groups/names", ())):
            continue
        rate = dict(zip(a["groups/names"].tolist(), a["groups/balanced"].tolist(), strict=True))
        values = {"all groups": a["elimination/balanced"][0], "all but the membrane": rate["all but membrane"]}
        values["the membrane alone"] = rate["membrane"]
        rows += [
            {"data": task, "measure": f"balanced error rate, {name}", "value": float(v)} for name, v in values.items()
        ]
    return rows


def _rates(runs: Runs):
    """Table 3.1 by both splits, the printed figures beside."""
    rows = []
    for way, words in (("sequence", "whole subsequences"), ("random", "points at random")):
        for task, a in runs[way].items():
            for n, rates in enumerate(a["folds/rates"]):
                rows.append([f"{task}, {words}, {n + 1}", f"{int(rates[0])}", *(number(float(v)) for v in rates[1:3]),
                             number(100 * float(rates[3]), 4), number(float(rates[4]))])  # fmt: skip
    for n, (positives, misses, alarms, accuracy) in enumerate(PRINTED):
        rows.append([f"thesis, iteration {n + 1}", f"{positives}", number(misses), number(alarms), number(accuracy, 4),
                     number((misses + alarms) / 2)])  # fmt: skip
    head = ["task, split, fold", "positives", "wp+ / |D|+", "wp- / |D|-", "accuracy, %", "(3.35)"]
    lead = (
        "Split by subsequence, no neighbour of a point is on the other side; place (F1) and time (F4) are left out. At "
        "random, as printed, they are in. The printed accuracies do not follow from the printed error rates."
    )
    return section("Table 3.1", table(head, rows), lead=lead)


PRINTED = ((44707, 0.0127, 0.0318, 95.334), (46881, 0.01883, 0.0206, 93.591), (420034, 0.0093, 0.0157, 93.019))


def _extents(found: Mapping[str, Mapping[str, np.ndarray]]):
    """Figure 3.14: minimum, quartiles and maximum of each region, as lines."""
    charts = []
    for task, a in found.items():
        shown = a["extents"][a["extents"][:, 1] > 0]
        regions = np.unique(shown[:, 0])
        marks = np.array([np.percentile(100 * shown[shown[:, 0] == r, 1], (0, 25, 50, 75, 100)) for r in regions])
        names = ("least", "first quartile", "median", "third quartile", "greatest")
        lines = [Series(name, regions, marks[:, k], dashed=k in (0, 4)) for k, name in enumerate(names)]
        charts.append(plot(lines, task, "coherent region", "% of the frame", from_zero=True))
    lead = "Share of a frame that a coherent region takes, over the frames that show it (figure 3.14)."
    return section("Extents", element("div", *charts, class_="plots"), lead=lead)


def _seen(a: Mapping[str, np.ndarray]):
    shown = [
        figure(photograph(marked(a, n), 420), f"Frame {a['pictures/frames'][n]}")
        for n in range(min(12, len(a["pictures/frames"])))
    ]
    lead = "Points of regard in red, predicted proto-objects in green (figure 3.15)."
    return section("Seen and predicted", gallery(*shown, columns=4, small=True), lead=lead)


def _objects(runs: Runs):
    """Figure 3.16."""
    rows = []
    for way, words in WAYS.items():
        for task, a in runs.get(way, {}).items():
            hit = a["objects/hit"]
            (now, now_chance), (ever, ever_chance) = a["hits"].tolist()
            counts = [int(a["subsequences/regards"].sum()), len(hit), int((hit >= 1).sum())]
            shares = [ever, ever_chance, ever / ever_chance, now, now_chance, now / now_chance]
            rows.append([f"{task}, {words}", *map(str, counts), *map(number, shares)])
    head = ["task", "points of regard", "proto-objects", "in coherent regions", "share", "chance", "ratio",
            "share at that time", "chance", "ratio"]  # fmt: skip
    lead = (
        "Proto-objects that lie in coherent regions: of the whole task, and of their own subsequence, of which there "
        "is one among up to three proto-objects (figure 3.16). Chance is the share of nodes."
    )
    return section("Proto-objects in coherent regions", table(head, rows), lead=lead)


WAYS = {
    "sequence": "limited domain",
    "free": "free domain",
    "printed": "excited by curvature, as printed",
    "others": "learnt for the other tasks (3.20)",
}


def _worth(found: Mapping[str, Mapping[str, np.ndarray]]):
    rows = []
    for task, a in found.items():
        if len(a.get("groups/names", ())):
            for kind, words in (("groups", ""), ("elimination", "left by elimination: ")):
                pairs = zip(a[f"{kind}/names"].tolist(), a[f"{kind}/balanced"].tolist(), strict=True)
                rows += [[task, words + name, number(float(value))] for name, value in pairs]
    return section("Groups of features", table(["task", "groups", "balanced error rate"], rows)) if rows else None
