"""The experiments of chapter 5: the printed tables, what they are held to, and each target as QUICK=1."""

import csv
import importlib
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from ipcli.report.mocap_experiment import WORDS

ROOT = Path(__file__).parents[2]


@pytest.fixture
def script(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "experiments"))
    return importlib.import_module("mocap_page")


def test_the_printed_tables_are_read_and_their_largest_numbers_are_where_the_thesis_says(script):
    """In kick and throw most clusters are in the left leg and in the left arm; the torso has the fewest in squat and walk."""
    table = script.read_printed("5.2")
    groups = table.columns[2:]
    counts = {row[0]: dict(zip(groups, map(int, row[2:]), strict=True)) for row in table.rows}
    assert max(counts["Kick with Left Leg"], key=counts["Kick with Left Leg"].get) == "left_leg"
    assert max(counts["Throw with Left Arm"], key=counts["Throw with Left Arm"].get) == "left_arm"
    assert all(min(counts[name], key=counts[name].get) == "torso" for name in ("Squat", "Walk"))
    assert [row[1:] for row in script.read_printed("5.1").rows] == [("93.86", ""), ("", "85.78")]


@pytest.mark.parametrize("name", ["hdm05", "florence", "utkinect"])
def test_every_experiment_is_held_to_something_that_its_tables_have(script, name):
    bars = script.read_bars(name)
    assert name in script.EXPERIMENTS and bars
    for bar in bars:
        assert bar.split in WORDS and bar.query in ("frames", "clips", "20", "5", "1")
        assert bar.goal is None or bar.goal > float(bar.bar)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["hdm05", "florence"])
def test_a_quick_look_ends_in_a_page_and_a_table(name, tmp_path):
    """From nothing, in a folder of its own; with data that are not there."""
    for part in ("Makefile", "experiments", "configs", "ipcli", "pyproject.toml", "sample_data"):
        (tmp_path / part).symlink_to(ROOT / part)
    environment = {**os.environ, "PYTHONPATH": str(tmp_path), "IPCLI_DATA": str(tmp_path / "nothing")}
    binaries = Path(sys.executable).parent
    command = ["make", "-o", ".venv/.installed", f"BIN={binaries}", "QUICK=1", f"experiments/mocap-{name}"]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    folder = tmp_path / "build" / "experiments" / f"mocap-{name}-quick"
    page, table = (folder / "index.html").read_text(), json.loads((folder / "index.json").read_text())
    assert "quick look" in page and "Table 5.2" in page if name == "hdm05" else "quick look" in page
    with (folder / "index.csv").open() as stream:
        rows = {(row["method"], row["split"], row["query"]): float(row["right %"]) for row in csv.DictReader(stream)}
    assert len(rows) == len(table["rows"])
    assert rows["aligned", "clips", "clips"] == 100 and rows["aligned", "frames", "frames"] > 90
