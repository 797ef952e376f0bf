"""What saliency takes: the rows that are measured, and what is foretold from two of them."""

import pytest

from benchmarks.saliency import speed


def test_membranes_are_those_of_the_bar_and_take_some_time():
    row = speed.membranes(300)
    assert (row["nodes"], row["modes"], row["steps"]) == (300, "13 x 9", 30)
    assert row["all steps [ms]"] > 0


def test_a_long_recording_is_foretold_by_the_law_of_growth():
    rows = [{"frames": n, "seconds in all": 0.01 * n**2, "CPU s in all": 0.5 * n} for n in (100, 200)]
    found = speed.foretold(rows)
    assert found["seconds in all"] == pytest.approx(0.01 * 1500**2)
    assert found["CPU s in all"] == pytest.approx(750)


def test_a_fixed_cost_is_not_taken_for_a_law_below_linear():
    rows = [{"frames": n, "seconds in all": 50.0 + n, "CPU s in all": 1.0 * n} for n in (100, 200)]
    assert speed.foretold(rows)["seconds in all"] == pytest.approx(250 * 7.5)


def test_rows_that_failed_foretell_nothing():
    assert "failed" in speed.foretold([{"frames": 1, "failed": "no"}, {"frames": 2}])
