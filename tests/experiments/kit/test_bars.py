"""What experiments are held to: the file, the verdicts, the section of the page."""

import re

import pytest

from experiments.kit.bars import Bar, Standing, bars_section, met, read_bars
from ipcli.report.kit.numbers import DASH

FILE = """# at least the bar
experiment,split,query,bar,goal,why
one,subjects,clips,95,100,"a, b"
two,all,clips,1,,c
one,subjects,20,k-NN of frames,,d
"""


def test_bars_are_those_of_the_experiment_and_a_bar_that_is_no_number_is_the_name_of_a_peer(tmp_path):
    (tmp_path / "bars.csv").write_text(FILE)
    assert read_bars(tmp_path / "bars.csv", "one") == [
        Bar(("subjects", "clips"), 95.0, 100.0, "a, b"),
        Bar(("subjects", "20"), "k-NN of frames", None, "d"),
    ]
    assert read_bars(tmp_path / "bars.csv", "three") == []


@pytest.mark.parametrize(
    ("reached", "asked", "goal", "least", "verdict"),
    [
        (0.2, 0.3, None, True, "yes"),
        (0.3, 0.3, 0.3, True, "the goal too"),
        (0.2, 0.3, 0.1, True, "yes"),
        (0.4, 0.3, 0.1, True, "no"),
        (0.4, 0.3, 0.5, False, "yes"),
        (0.5, 0.3, 0.5, False, "the goal too"),
        (0.2, 0.3, None, False, "no"),
        (float("nan"), 0.3, None, True, DASH),
        (0.3, float("nan"), None, False, DASH),
    ],
)
def test_a_verdict_knows_which_way_is_better(reached, asked, goal, least, verdict):
    assert met(reached, asked, goal, least=least) == verdict


def test_the_section_names_the_default_and_the_best_and_dashes_what_was_not_run():
    bars = [Bar(("RMSE",), 0.5, None, "w<"), Bar(("MAE",), "peer", 0.1, "x")]
    standings = [
        Standing(bars[0], ("RMSE",), 0.5, {"ours": 0.6, "other": 0.4}),
        Standing(bars[1], ("MAE",), float("nan"), {}),
    ]
    text = str(bars_section(standings, "ours", ("",), least=True, unit="m", lead="L"))
    rows = [re.findall(r"<td>(.*?)</td>", row) for row in text.split("<tr>")[2:]]
    assert rows[0] == ["0.5", DASH, "0.6", "no", "0.4 by other", "yes", "w&lt;"]
    assert rows[1] == [f"peer: {DASH}", "0.1", DASH, DASH, DASH, DASH, "x"]
    assert "least, m" in text
    assert bars_section([], "ours", ("",), least=True, lead="L") is None
