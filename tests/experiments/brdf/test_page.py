"""The tables of the experiments of chapter 7 on made-up errors, and objects of our own that are in one piece."""

import numpy as np
import pytest
from scipy.ndimage import label

from experiments.brdf import page, scenes

NONE = [0.3, 0.3, 2.0, np.nan]
ORACLES = {"true rim": NONE, "true map, as a solid": NONE}
ROWS = {
    "a": {"flat": [0.8, 0.8, 9.0, np.nan], "inflation": [0.2, 0.2, 4.0, np.nan], "ours": [0.1, 0.1, 1.0, 3.0]}
    | ORACLES,
    "b": {"flat": [0.2, 0.2, 1.0, np.nan], "inflation": [0.2, 0.2, 1.0, np.nan], "ours": [0.4, 0.3, 4.0, 5.0]}
    | ORACLES,
}


def test_means_are_geometric_for_mit_and_count_what_is_worse():
    lines = {line[0]: line for line in page.summary("mit", ROWS, {})}
    assert lines["ours"][1] == "0.2"
    assert lines["ours"][3] == "2"
    assert lines["ours"][4:] == ["+0 %", "1 of 2"]
    lines = {line[0]: line for line in page.summary("diligent", ROWS, {})}
    assert lines["ours"][1] == "0.25"


def test_what_was_measured_is_written(tmp_path):
    page.write(tmp_path, "mit", ROWS, {"a": "x", "b": "y"})
    assert len((tmp_path / "errors.csv").read_text().splitlines()) == 11
    assert "NaN" not in (tmp_path / "errors.json").read_text()
    assert "worse by 2" in (tmp_path / "index.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", ["boot", "moka pot", "dish", "teapot", "vase"])
def test_objects_of_our_own_are_whole(name):
    made = scenes.own(64)[name]
    assert label(made.mask)[1] == 1
    assert made.mask.mean() > 0.1
    assert np.isfinite(made.height[made.mask]).all()
