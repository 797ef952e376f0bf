"""The page of an experiment with actions, on figures made up for the purpose."""

import re
from dataclasses import replace

import numpy as np
import pytest

from experiments.kit.bars import Bar
from experiments.kit.printed import Printed
from experiments.mocap import experiment as report
from experiments.mocap.experiment import RecognitionExperiment
from ipcli.report.kit.numbers import DASH
from tests.fixtures.pages import sound
from tests.fixtures.report_artefacts import evaluation

CLASSES = np.array(["kick", "sit", "squat"])
PEERS = {
    "leave-one-out": [
        {"method": "k-NN", "single frames %": "61.5 ± 2.0", "whole clips %": "90.0", "20 frames of a clip %": "70.0"}
    ]
}


def confused(right: int, wrong: int, splits: int = 2):
    """(s, 3, 3) with so many answers right and wrong in each row."""
    return np.broadcast_to(
        right * np.eye(3, dtype=np.int64) + wrong * np.eye(3, k=1, dtype=np.int64), (splits, 3, 3)
    ).copy()


@pytest.fixture
def experiment():
    one = evaluation(2) | {"classes": CLASSES, "frame_confusion": confused(3, 0), "sequence_confusion": confused(8, 2)}
    one["frame_confusion"][1] = [[0, 3, 0], [0, 0, 3], [3, 0, 0]]
    other = evaluation(1) | {"classes": CLASSES, "split": np.array("frames"), "unordered_frames": np.array([20])}
    other["unordered_confusion"] = other["unordered_confusion"][:, :1]
    bars = [
        Bar(("leave-one-out", "frames"), 50.0, 60.0, "a"),
        Bar(("leave-one-out", "clips"), "k-NN", None, "b"),
        Bar(("leave-one-out", "20"), "LDA", None, "c"),
    ]
    printed = {
        "5.1": Printed("Table 5.1: accuracy", ("", "frames %", "clips %"), (("X", "93.86", ""),)),
        "5.2": Printed("Table 5.2: n", ("a", "b"), (("K", ""),)),
    }
    return RecognitionExperiment(
        "T", "L", {("aligned", "leave-one-out"): one, ("thesis", "frames"): other}, None, bars, printed, PEERS
    )


def test_the_page_is_whole_without_a_model_and_without_peers(experiment):
    for one in (experiment, replace(experiment, peers={}, printed={}, bars=[])):
        text = report.page(one)
        assert 'href="aligned-leave-one-out.evaluation.html"' in text
        sound(re.sub(r'<a href="[a-z-]+\.evaluation\.html">', "<a>", text))


def test_what_is_reached_is_the_mean_over_splits_and_what_was_not_run_is_unknown(experiment):
    assert experiment.percent("aligned", "leave-one-out", "frames") == pytest.approx(50)
    right = 100 * (8 + 8 + 8) / (3 * 10 - 2)  # the last row has no wrong answers
    assert experiment.percent("aligned", "leave-one-out", "clips") == pytest.approx(right)
    assert np.isnan(experiment.percent("thesis", "leave-one-out", "clips"))
    assert experiment.queries == ["frames", "pose", "20", "poses", "clips"]
    assert experiment.splits == ["leave-one-out", "frames"]


def test_bars_are_numbers_or_peers_and_an_unknown_peer_is_not_a_bar_met(experiment):
    assert experiment.peer("k-NN", "leave-one-out", "frames") == 61.5
    assert np.isnan(experiment.peer("k-NN", "subjects", "frames"))
    assert np.isnan(experiment.peer("LDA", "leave-one-out", "20"))
    text = report.page(experiment)
    held = text[text.index("What it is held to") : text.index("<h2>Right answers")]
    rows = [row for row in held.split("<tr>")[2:]]
    assert "<td>yes</td>" in rows[0]
    assert "<td>no</td>" in rows[1]
    assert f"<td>{DASH}</td>" in rows[2]


def test_frames_and_clips_of_the_thesis_stay_in_columns_of_their_own(experiment):
    text = report.page(experiment)
    row = text[text.index("thesis: X") :].split("</tr>")[0]
    assert row.index("93.86") < row.index(DASH)
