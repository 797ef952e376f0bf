"""Measures of the experiment on search tasks, from artefacts with known figures."""

import numpy as np
import pytest

from experiments.saliency import tasks


def artefact(hits, rates):
    return {
        "hits": np.array(hits), "folds/rates": np.array(rates),
        "subsequences/ranking": np.array([[0.9, np.nan], [0.7, 0.5]]),
        "rankings": np.array(["learnt function", "membrane"]), "extents": np.array([[0, 0.0], [0, 0.05], [1, 0.2]]),
        "groups/names": np.array(["membrane", "all but membrane"]), "groups/balanced": np.array([0.4, 0.05]),
        "elimination/balanced": np.array([0.04, 0.06]),
    }  # fmt: skip


def test_measures_are_means_over_folds_and_tasks():
    found = {
        "a": artefact([[0.4, 0.1], [0.8, 0.2]], [[10, 0.1, 0.3, 0.9, 0.2], [10, 0.3, 0.1, 0.8, 0.2]]),
        "b": artefact([[0.2, 0.1], [0.6, 0.2]], [[10, 0.0, 0.2, 1.0, 0.1], [10, 0.0, 0.2, 1.0, 0.1]]),
    }
    values = {row["measure"]: row["value"] for row in tasks.measures("sequence", found)}
    assert values["balanced error rate"] == pytest.approx(0.15)
    assert values["accuracy"] == pytest.approx(0.925)
    assert values["times chance, ever"] == pytest.approx(3.5)
    assert values["times chance, at that time"] == pytest.approx(3.0)
    assert values["area under the curve, membrane"] == pytest.approx(0.5)
    assert values["extents of 1 to 10 %"] == pytest.approx(0.5)
    added = {row["measure"]: row["value"] for row in tasks.membranes(found) if row["data"] == "a"}
    assert added["balanced error rate, all but the membrane"] == 0.05
    assert added["balanced error rate, all groups"] == 0.04
