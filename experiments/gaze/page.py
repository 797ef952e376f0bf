"""Page, table and bars of the gaze experiments, from `gaze-experiment` artefacts."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from experiments.kit.arguments import Arguments
from experiments.kit.bars import Standing, bars_section, read_bars
from experiments.kit.run import Findings, page_of, quick_lead, run
from ipcli.geometry.alignment import path_extent
from ipcli.io.files import h5
from ipcli.models.gaze import evaluation
from ipcli.report.kit.numbers import number
from ipcli.report.kit.page import section, table

SLACK = 4  # frames between a keyframe and the change of attention that it is of
OURS = "gaze-sfm"
BARS = Path(__file__).with_name("bars.csv")
Row = dict[str, object]


def localisation(runs: Mapping[str, Mapping[str, np.ndarray]]) -> list[Row]:
    """Errors of each head path."""
    rows: list[Row] = []
    for name, a in runs.items():
        values: dict[str, float] = {"frames": len(a["lost"]), "frames lost": int(a["lost"].sum())}
        if "accuracy/path" in a:
            rigid, similar, scale, online = (float(value) for value in a["accuracy/path"])
            values |= {
                "path error [m]": rigid,
                "with scale [m]": similar,
                "scale": scale,
                "path error online [m]": online,
            }
        values["farthest from the start [m]"] = path_extent(a["world_from_rig"])[1]
        values["keyframes after the first"] = int(a["keyframe"].sum()) - 1
        values["disparity offset [px]"] = float(a["offset"])
        rows += [{"data": name, "measure": measure, "value": value} for measure, value in values.items()]
    return rows


def regards(runs: Mapping[str, Mapping[str, np.ndarray]]) -> list[Row]:
    """Errors of points of regard on known targets, room by room and in all; shares of truth in the regions."""
    rows, everything = [], []
    for name, a in runs.items():
        moved = evaluation.registration(a["world_from_rig"], a["truth"])
        places = dict(zip(a["target_names"].tolist(), a["targets"], strict=True))
        true = np.array([places[label] for label in a["gaze/labels"].tolist()])
        errors, squares = evaluation.target_errors(a["por/points"], a["por/covariance"], true, moved)
        ranges = np.linalg.norm(a["por/points"] - a["por/origins"], axis=1)
        everything.append(np.stack([errors, squares, ranges]))
        rows += _regard_rows(name, everything[-1])
    return rows + _regard_rows("all", np.concatenate(everything, axis=1))


def _regard_rows(name: str, found: np.ndarray) -> list[Row]:
    errors, squares, ranges = found
    inside = evaluation.coverage(squares)
    values = {
        "gaze samples": len(errors),
        "points of regard": int(np.isfinite(errors).sum()),
        "median range [m]": float(np.nanmedian(ranges)),
        "RMS error [m]": float(np.sqrt(np.nanmean(errors**2))),
        "RMS error at 3 m [m]": float(np.sqrt(np.nanmean((3 * errors / ranges) ** 2))),
        "truth in the 68 % region": inside[0.68],
        "truth in the 95 % region": inside[0.95],
    }
    return [{"data": name, "measure": measure, "value": value} for measure, value in values.items()]


def keyframes(runs: Mapping[str, Mapping[str, np.ndarray]]) -> list[Row]:
    """Keyframes against the frames with which the gaze's label changes."""
    rows, found, true, start = [], [], [], 0
    for name, a in runs.items():
        labels = a["gaze/labels"]
        changes = np.flatnonzero(labels[1:] != labels[:-1]) + 1
        own = np.unique(np.concatenate([[0], a["por/frame"][changes]]))
        keys = np.flatnonzero(a["keyframe"])
        rows += _keyframe_rows(name, keys, own)
        found.append(keys + start)
        true.append(own + start)
        start += len(a["keyframe"]) + 100 * SLACK
    return rows + _keyframe_rows("all", np.concatenate(found), np.concatenate(true))


def _keyframe_rows(name: str, found: np.ndarray, true: np.ndarray) -> list[Row]:
    scores = evaluation.keyframe_scores(found, true, SLACK)
    values = {"keyframes": len(found), "changes of attention": len(true), **scores}
    words = {"f1": "F1"}
    return [{"data": name, "measure": words.get(measure, measure), "value": value} for measure, value in values.items()]


def chain(runs: Mapping[str, Mapping[str, np.ndarray]]) -> list[Row]:
    """What fuse-depth and merge-depth made of the views of a localised recording."""
    rows: list[Row] = []
    for name, a in runs.items():
        if "spacing" in a:
            values = {"points": len(a["points"]), "maps": len(a["maps"]), "confirmed": int(a["map_confirmed"].sum())}
            rows += [{"data": name, "measure": measure, "value": value} for measure, value in values.items()]
    return rows


MEASURES: dict[str, Callable[[Mapping[str, Mapping[str, np.ndarray]]], list[Row]]] = {
    "localisation": localisation,
    "por": regards,
    "keyframes": keyframes,
    "map": localisation,
    "chain": chain,
}
TITLES = {
    "localisation": "Head paths against the truth",
    "por": "Points of regard on known places",
    "keyframes": "Keyframes against changes of attention",
    "map": "A single camera in an earlier map",
    "chain": "From the head's path to one cloud",
}


def make(arguments: Arguments) -> Findings:
    """The findings of one experiment."""
    runs = {path.name.split(".")[0]: h5.read(path, h5.peek(path).kind).arrays for path in arguments.files}
    rows = MEASURES[arguments.name](runs)
    by_key = {(row["data"], row["measure"]): float(row["value"]) for row in rows}  # type: ignore[arg-type]
    least = arguments.name != "keyframes"
    held = [
        Standing(bar, bar.measure, float(bar.bar), {OURS: by_key[bar.measure]} if bar.measure in by_key else {})
        for bar in read_bars(BARS, arguments.name)
    ]
    bars = bars_section(held, OURS, ("data", "measure"), least=least, lead="What is asked for, and what was reached.")
    cells = [(row["data"], row["measure"], number(float(row["value"]), 4)) for row in rows]  # type: ignore[arg-type]
    lead = quick_lead("small generated rooms") if arguments.quick else ""
    found = section("Measures", table(("data", "measure", "value"), cells))
    return Findings(page_of("gaze", TITLES[arguments.name], lead, bars, found), rows)


if __name__ == "__main__":
    run(MEASURES, make)
