"""Measuring in processes of their own, and the laws told from what was measured."""

import numpy as np
import pytest

from benchmarks.kit import measure


def test_memory_of_a_fresh_process_is_its_own():
    """Not that of the parent at the moment of the fork."""
    ballast = np.ones(30_000_000)
    assert measure.isolated("benchmarks.kit.measure:peak_memory", 1) < ballast.nbytes / 1e6


def test_an_exponent_is_that_of_the_law_and_unknown_where_nothing_grows():
    assert measure.exponent([1, 2, 8], [3, 12, 192]) == pytest.approx(2)
    assert measure.exponent([2, 2], [3, 4]) is None
    assert measure.exponent([1, 2], [0, 4]) is None


def test_what_fails_in_another_process_says_why_and_a_table_can_go_on():
    with pytest.raises(RuntimeError, match="missing"):
        measure.isolated("benchmarks.kit.measure:missing", 1)
    row = measure.attempted("benchmarks.kit.measure:missing", 1)
    assert list(row) == ["failed"]
    assert "missing" in row["failed"]


def test_a_clock_adds_up_what_it_is_asked_to_and_the_best_of_several_runs_is_the_least():
    clock = measure.Clock()
    for _ in range(2):
        with clock:
            pass
    assert 0 < clock.last < clock.total
    calls = []
    seconds, found = measure.best_of(3, lambda: calls.append(None) or len(calls))
    assert found == len(calls) == 3
    assert seconds > 0


def test_a_peer_that_is_not_installed_is_named(capsys):
    assert measure.installed("ours", "numpy")
    assert capsys.readouterr().err == ""
    assert not measure.installed("a peer", "no_such_package")
    assert capsys.readouterr().err == "a peer: no_such_package is not installed, skipped\n"
