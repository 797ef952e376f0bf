from __future__ import annotations

import doctest
from math import isclose, log10

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from ipcli.report.kit import numbers
from ipcli.report.kit.numbers import aligned, counted, log_ticks, nice_step, number, percent, round_outwards, ticks

ranges = st.tuples(st.floats(-1e6, 1e6), st.floats(1e-6, 1e6)).map(lambda pair: (pair[0], pair[0] + pair[1]))


def resolved(low: float, high: float) -> None:
    assume(high - low > 1e-6 * max(abs(low), abs(high)))


def test_examples_in_docstrings_hold():
    assert doctest.testmod(numbers).failed == 0


@given(st.floats(-1e12, 1e12))
def test_a_number_reads_back_to_its_digits(value):
    written = number(value, 4).replace("\N{MINUS SIGN}", "-").replace("×10", "e")
    plain = written.translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789"))
    assert float(plain) == pytest.approx(value, rel=1e-3, abs=0)


@given(ranges, st.integers(2, 12))
def test_ticks_are_round_evenly_spaced_and_inside(limits, count):
    low, high = limits
    resolved(low, high)
    step = nice_step(high - low, count)
    assert any(isclose(step / 10 ** round(log10(step / factor)), factor, rel_tol=1e-9) for factor in (1, 2, 5))
    found = ticks(low, high, count)
    slack = 1e-6 * step
    assert all(low - slack <= value <= high + slack for value in found)
    assert all(isclose(b - a, step, rel_tol=1e-5) for a, b in zip(found, found[1:], strict=False))
    assert found == [] or (found[0] - step < low and found[-1] + step > high)  # none is left out
    assert len(found) <= count + 1


@given(st.floats(-9, 9), st.floats(0.31, 12))
def test_log_ticks_are_inside_and_not_too_many(exponent, decades):
    low, high = 10.0**exponent, 10.0 ** (exponent + decades)
    found = log_ticks(low, high, 6)
    assert 2 <= len(found) <= 7
    assert all(low * (1 - 1e-8) <= value <= high * (1 + 1e-8) for value in found)
    assert decades < 1 or all(
        isclose(value / 10 ** round(log10(value / factor)), factor, rel_tol=1e-9)
        for value in found
        for factor in [float(f"{value:e}"[0])]
    )


@given(ranges)
def test_rounded_limits_contain_the_range_and_little_more(limits):
    low, high = limits
    resolved(low, high)
    outer_low, outer_high = round_outwards(low, high)
    slack = 1e-6 * (high - low)
    assert outer_low <= low + slack
    assert outer_high >= high - slack
    assert outer_high - outer_low <= 1.2 * (high - low)


def test_columns_of_numbers_share_their_decimals():
    assert aligned([0.5, 0.0123, float("nan"), 12]) == ["0.5000", "0.0123", "—", "12.0000"]


def test_one_is_singular():
    assert [counted(number, "image") for number in (0, 1, 2)] == ["0 images", "1 image", "2 images"]


def test_nearly_all_is_not_all():
    assert percent(1.0) == "100\N{NO-BREAK SPACE}%"
    assert percent(0.99999) != percent(1.0)
