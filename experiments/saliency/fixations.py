"""Recorded fixations on pictures (OSIE) and on surfaces in virtual reality: models, baselines, each feature's worth."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from experiments.kit.arguments import Arguments
from experiments.kit.bars import Standing, bars_section, read_bars
from experiments.kit.run import Findings, page_of, quick_lead
from ipcli.io.files import h5
from ipcli.report.kit.page import section, table
from ipcli.report.saliency.saliency_evaluation import features_table, models_table, shown_items

BARS = Path(__file__).with_name("bars.csv")
OURS = "logistic + boosting"
TITLES = {"osie": "Fixations on pictures: OSIE", "meshes": "Surfaces looked at in virtual reality"}
DEVELOPMENT = 30  # first pictures of OSIE, on which channels and settings were chosen
CURVED = ("curvature", "Lee's mesh saliency", "convexity", "roughness", "flatness")


def findings(arguments: Arguments) -> Findings:
    """Page and rows of one evaluation."""
    arrays = h5.read(arguments.files[0], "saliency-evaluation").arrays
    predictors, measures = arrays["predictors"].tolist(), arrays["measures"].tolist()
    rows = [
        {"data": predictor, "measure": measure, "value": float(arrays["values"][r, c])}
        for r, predictor in enumerate(predictors)
        for c, measure in enumerate(measures)
    ]
    by_key = {(row["data"], row["measure"]): float(row["value"]) for row in rows}
    held = [
        Standing(bar, bar.measure, float(bar.bar), {OURS: by_key[bar.measure]})
        for bar in read_bars(BARS, arguments.name)
        if bar.measure in by_key
    ]
    lead = quick_lead("a small generated set") if arguments.quick else ""
    sections = [
        bars_section(held, OURS, ("predictor", "measure"), least=False, lead="Large is good."),
        models_table(arrays),
        _apart(arrays) if arguments.name == "osie" and not arguments.quick else None,
        _curvature(arrays),
        features_table(arrays),
        *shown_items(arrays, 480),
    ]
    return Findings(page_of("saliency", TITLES[arguments.name], f"{lead}{arrays['protocol']}.", *sections), rows)


def _apart(arrays: dict[str, np.ndarray]):
    """Figures of the pictures that settings were chosen on, and of those that they were not."""
    kept = [k for k, role in enumerate(arrays["roles"]) if role != "feature"]
    parts = {"chosen on": slice(None, DEVELOPMENT), "not looked at": slice(DEVELOPMENT, None)}
    rows = []
    for r in kept:
        for name, part in parts.items():
            weight = arrays["looked_at"][part]
            values = [float(np.average(arrays["each"][r, part, c], weights=weight)) for c in range(3)]
            rows.append((f"{arrays['predictors'][r]}, {name}", *(f"{value:.3f}" for value in values)))
    lead = (
        f"The untrained formula was chosen on the first {DEVELOPMENT} pictures. Channels and settings of learning were "
        "thought of before and not tuned, but their figures were seen on all 60."
    )
    return section(
        "Pictures that settings were chosen on, and others", table(("", "AUC", "sAUC", "NSS"), rows), lead=lead
    )


def _curvature(arrays: dict[str, np.ndarray]):
    """What bending says by itself."""
    rows = [
        (str(name), f"{values[0]:.3f}", "above chance" if values[0] > 0.52 else "at chance or below")
        for name, values in zip(arrays["predictors"], arrays["values"], strict=True)
        if str(name).startswith(CURVED)
    ]
    lead = (
        "The thesis takes curvature for what attracts. Chance is .500: this is what it is worth alone on fixations "
        "that were recorded."
    )
    return section("What curvature says by itself", table(("", "AUC", ""), rows), lead=lead)
