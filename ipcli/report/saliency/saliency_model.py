"""The page of a `saliency-model`: what it was learnt from, and what it goes by."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ipcli.report.kit.numbers import aligned
from ipcli.report.kit.page import Markup, element, section, table
from ipcli.report.kit.page import page as document
from ipcli.report.kit.provenance import origin


def page(arrays: Mapping[str, np.ndarray], provenance: Mapping[str, object], *, widest: int = 0) -> str:
    """The HTML of a `saliency-model` artefact; it has no pictures for `widest` to bound."""
    trees = len(arrays["trees/feature"]) if "trees/feature" in arrays else 0
    beside = f" and {trees} boosted trees" if trees else ""
    verdict = (
        f"Learnt from {len(arrays['items'])} {arrays['subject']} with {int(arrays['fixations'])} fixations: logistic "
        f"regression of {len(arrays['features'])} features{beside}. How good it is on others, saliency-evaluate tells."
    )
    return document(
        f"What is looked at on {arrays['subject']}",
        "ipcli saliency-train",
        verdict,
        _weights(arrays, trees),
        section("Learnt from", element("p", ", ".join(arrays["items"].tolist()))),
        origin(provenance),
    )


def _weights(arrays: Mapping[str, np.ndarray], trees: int) -> Markup:
    weights = arrays["weights"]
    heads = ["feature", "weight"]
    columns = [aligned(weights)]
    if trees:
        inner = arrays["trees/feature"][arrays["trees/left"] >= 0]
        asked = np.bincount(inner, minlength=len(weights))
        heads.append("asked for by trees")
        columns.append([str(count) for count in asked])
    order = np.argsort(-np.abs(weights), kind="stable")
    rows = [(str(arrays["features"][k]), *(column[k] for column in columns)) for k in order]
    lead = (
        "Weights of the standardised features in the log odds, the heaviest first. Features overlap, so that "
        "the weight of one is not its worth: saliency-evaluate measures that of each alone."
    )
    return section("What it goes by", table(heads, rows), lead=lead)
