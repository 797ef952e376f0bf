"""The page of an experiment, on figures made up for the purpose."""

import re
from dataclasses import replace

import numpy as np
import pytest

from experiments.fusion import experiment as report
from experiments.fusion.experiment import FusionExperiment
from experiments.kit.bars import Bar
from experiments.kit.printed import Printed

COLUMNS = ("density %", "RMSE", "centred RMSE", "Z-MAE", "N-MAE rad", "D-avg px", "AUSE confidence")
METHODS = ("reference", "median", "tgv-l1", "tgv-l1, tuned λ", "l1-adapt (acs)", "l1-adapt (acs), tuned λ")
RMSE = {
    "reference": 1.0,
    "median": 0.5,
    "tgv-l1": 0.11,
    "tgv-l1, tuned λ": 0.1,
    "l1-adapt (acs)": 0.12,
    "l1-adapt (acs), tuned λ": 0.1,
}


def values(factor):
    """(m, c): every error the RMSE of its method times a factor."""
    rows = np.array([[100, *(5 * [factor * RMSE[name]]), 0.4] for name in METHODS])
    rows[:2, -1] = np.nan
    return rows


def trials(factor=1.0):
    rules = ["none", "none", "automatic", "tuned", "automatic", "tuned"]
    known = np.array([rule != "none" for rule in rules])[:, None]
    depth = np.full((3, 24, 32), 2.0, np.float32)
    return {
        "methods": np.array([name.split(",")[0] for name in METHODS]),
        "rules": np.array(rules),
        "columns": np.array(COLUMNS),
        "values": values(factor),
        "kept_error": np.where(known, np.linspace(0.5, 1, 10), np.nan),
        "least_error": np.where(known, np.linspace(0.1, 1, 10), np.nan),
        "maps": np.array(["median", "tgv-l1", "l1-adapt (acs)"]),
        "depth": depth,
        "confidence": depth,
        "truth": depth[0],
        "intrinsics": np.array([[30.0, 0, 16], [0, 30, 12], [0, 0, 1]]),
        "unit": np.array("m"),
    }


@pytest.fixture
def experiment():
    table = {
        "scenes": np.array(["a", "b"]),
        "methods": np.array(METHODS),
        "columns": np.array(COLUMNS),
        "values": np.stack([values(1), values(4)]),
    }
    tuning = {
        "scenes": np.array(["d"]),
        "methods": np.array(["tgv-l1", "l1-adapt (acs)"]),
        "lambdas": np.array([0.1, 1.0]),
        "columns": np.array(COLUMNS),
        "values": np.ones((1, 2, 2, len(COLUMNS))),
        "automatic_lambda": np.full((1, 2), 0.3),
        "automatic": np.ones((1, 2, len(COLUMNS))),
        "measure": np.array("RMSE"),
        "best": np.array([0.1, 1.0]),
    }
    printed = Printed(
        "Table 9.9: of its own",
        ("method", "ours", "centred RMSE", "Z-avg"),
        (("Median<", "median", "0.7777", "0.50"), ("Old", "not-run", "0.6", "0.4")),
    )
    asked = (("centred RMSE", 0.23, None), ("RMSE / median", 0.25, 0.1), ("Z-MAE", 0.1, None))
    bars = tuple(Bar((measure,), bar, goal, "why") for measure, bar, goal in asked)
    sweeps = {"laplace": {0.3: [trials(0.5)], 0.6: [trials(1.0)]}}
    return FusionExperiment(
        "T",
        "L",
        "C",
        "l1-adapt (acs)",
        table,
        tuning,
        {"a": trials()},
        sweeps,
        (printed,),
        bars,
        {"4.1 a boxes": np.eye(8)},
    )


def test_means_are_geometric_unless_told_otherwise_and_unknown_rows_are_not_known(experiment):
    assert experiment.mean("median", "RMSE") == pytest.approx(0.5 * 2)
    assert experiment.mean("median", "Z-avg") == pytest.approx(1.0)
    assert experiment.mean("median", "density %") == 100
    assert np.isnan(experiment.mean("rof", "RMSE"))
    assert np.isnan(experiment.mean("median", "AUSE confidence"))
    assert replace(experiment, arithmetic=True).mean("median", "RMSE") == pytest.approx(0.5 * 2.5)


def test_closeness_is_the_error_at_the_automatic_lambda_over_that_at_the_tuned_one(experiment):
    assert report.closeness(experiment) == pytest.approx({"tgv-l1": 1.1, "l1-adapt (acs)": 1.2})
    page = report.page(experiment)
    assert "1.2 times the tuned" in page
    assert "for 1 of 2 methods" in page


def test_a_bar_is_met_by_the_default_by_another_or_not(experiment):
    """Means: the default 0.24, tgv-l1 0.22, the median 1."""
    section = report.held_to(experiment)
    assert re.findall(r"<td>(0\.\d+ by tgv-l1|no|yes)</td>", section) == [
        *("no", "0.22 by tgv-l1", "yes"),
        *("yes", "0.22 by tgv-l1", "yes"),
        *("no", "0.22 by tgv-l1", "no"),
    ]


def test_the_printed_figures_stand_beside_ours_escaped_and_with_a_dash_where_there_is_none(experiment):
    (section,) = report.thesis_sections(experiment)
    assert "Median&lt;" in section
    assert "0.7777" in section
    assert "Table 9.9" in section
    assert "—" in section


def test_a_sweep_gives_each_method_its_errors_in_order_without_views_that_are_off_the_chart(experiment):
    (chart,) = report.sweep_charts(experiment, "Z-avg")
    assert [line.name for line in chart.lines][:2] == ["median", "tgv-l1"]
    assert "reference" not in [line.name for line in chart.lines]
    np.testing.assert_allclose(chart.lines[0].x, [0.3, 0.6])
    np.testing.assert_allclose(chart.lines[0].y, [0.25, 0.5])


def test_curves_of_the_confidence_end_at_one_and_the_best_order_is_dashed(experiment):
    chart = report.confidence_chart(experiment)
    assert [line.dashed for line in chart.lines] == [False, False, True]
    assert all(line.y[-1] == 1 for line in chart.lines)


def test_a_bare_table_makes_a_page_too(experiment):
    bare = FusionExperiment("T", "L", "C", "l1-adapt (acs)", experiment.table)
    page = report.page(bare)
    assert all(str(name).partition(",")[0] in page for name in experiment.table["methods"])
    assert "nan" not in page.lower().replace("reference", "")
