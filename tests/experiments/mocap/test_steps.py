"""The experiments of chapter 5: the printed tables, what they are held to, and each target as QUICK=1."""

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.mocap.methods import METHODS
from experiments.kit.bars import read_bars
from experiments.mocap import page, takes
from experiments.mocap.experiment import WORDS
from ipcli.geometry.motion import heading
from ipcli.models.mocap.features import reference_lengths, repose
from tests.fixtures.makefile import make
from tests.fixtures.mocap_bodies import ACTIONS, GROUPS
from tests.fixtures.mocap_clips import clip


def test_the_printed_tables_are_read_and_their_largest_numbers_are_where_the_thesis_says():
    """In kick and throw most clusters are in the left leg and in the left arm; the torso has the fewest in squat and
    walk.
    """
    table = page.printed_table("5.2")
    groups = table.columns[2:]
    counts = {row[0]: dict(zip(groups, map(int, row[2:]), strict=True)) for row in table.rows}
    assert max(counts["Kick with Left Leg"], key=counts["Kick with Left Leg"].get) == "left_leg"
    assert max(counts["Throw with Left Arm"], key=counts["Throw with Left Arm"].get) == "left_arm"
    assert all(min(counts[name], key=counts[name].get) == "torso" for name in ("Squat", "Walk"))
    assert [row[1:] for row in page.printed_table("5.1").rows] == [("93.86", ""), ("", "85.78")]


@pytest.mark.parametrize("name", ["hdm05", "florence", "utkinect"])
def test_every_experiment_is_held_to_something_that_its_tables_have(name):
    bars = read_bars(page.HERE / "bars.csv", name)
    assert name in page.EXPERIMENTS
    assert bars
    for bar in bars:
        split, query = bar.measure
        assert split in WORDS
        assert query in ("frames", "pose", "poses", "clips", "20", "5", "1")
        assert bar.goal is None or bar.goal > float(bar.bar)
        assert isinstance(bar.bar, float) or bar.bar in METHODS


def test_a_take_goes_on_where_a_clip_ended_and_every_pose_stays_as_it_was():
    parts = [clip(action, 0, 12) for action in ACTIONS]
    take = takes.strung(parts, GROUPS, "ann")
    assert len(take.motion.positions) == 36
    assert list(take.frame_labels[[0, 11, 12, 35]]) == [parts[0].label] * 2 + [
        parts[1].label,
        parts[2].label,
    ]
    root = take.motion.skeleton.joints.index(GROUPS.root)
    track, facing = take.motion.positions[:, root], heading(take.motion.skeleton, take.motion.positions, GROUPS)
    for start in (12, 24):
        np.testing.assert_allclose(track[start, [0, 2]], track[start - 1, [0, 2]], atol=1e-9)
        np.testing.assert_allclose(facing[start], facing[start - 1], atol=1e-9)
    for index, part in enumerate(parts):
        mine = replace(take.motion, positions=take.motion.positions[12 * index : 12 * index + 12])
        lengths = reference_lengths([part.motion], GROUPS)
        np.testing.assert_allclose(repose(mine, GROUPS, lengths), repose(part.motion, GROUPS, lengths), atol=1e-9)


@pytest.mark.slow
def test_a_quick_look_at_takes_names_most_of_the_time_right(tmp_path):
    folder = made(tmp_path, "takes")
    with (folder / "index.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 6
    assert all(float(row["time named right %"]) > 80 for row in rows if row["none allowed"] == "False")
    assert all(float(row["called none %"]) == 0 for row in rows if row["none allowed"] == "False")
    html = (folder / "index.html").read_text()
    assert "take of eve" in html
    assert "quick look" in html


@pytest.mark.slow
@pytest.mark.parametrize("name", ["hdm05", "florence"])
def test_a_quick_look_ends_in_a_page_and_a_table(name, tmp_path):
    folder = made(tmp_path, name)
    html, table = (folder / "index.html").read_text(), json.loads((folder / "index.json").read_text())
    assert "quick look" in html
    assert ("Table 5.2" in html) == (name == "hdm05")
    with (folder / "index.csv").open() as stream:
        rows = {(row["method"], row["split"], row["query"]): float(row["right %"]) for row in csv.DictReader(stream)}
    assert len(rows) == len(table["rows"])
    assert rows["aligned", "clips", "clips"] == 100
    assert rows["aligned", "frames", "frames"] > 90


@pytest.mark.slow
def test_the_demo_names_pages_that_are_there_and_all_that_a_stranger_does(tmp_path):
    told = make(tmp_path, "demo")
    pages = [Path(line.strip()) for line in told.splitlines() if line.endswith(".html")]
    assert len(pages) == 3
    assert all(page.is_file() for page in pages)
    with (tmp_path / "build" / "demo" / "motions.recognition.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 12
    assert all(row["clip"].split(".")[:2] == [row["action"], "eve"] for row in rows)


def made(place, name):
    """What the target of an experiment leaves, as a quick look; with data that are not there."""
    make(place, f"experiments/mocap-{name}", "QUICK=1")
    return place / "build" / "experiments" / f"mocap-{name}-quick"
