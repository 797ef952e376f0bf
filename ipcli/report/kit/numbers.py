"""How numbers are written and where axes are ticked: the part that pictures, curves and tables share."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, floor, isfinite, log10

import numpy as np

MINUS, DASH = "\N{MINUS SIGN}", "\N{EM DASH}"
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def number(value: float, digits: int = 3) -> str:
    """``value`` to ``digits`` significant digits as in print: a true minus, powers of ten, a dash for NaN.

    >>> number(-0.01234), number(3.2e-7), number(1234567.0, 2), number(float("nan"))
    ('−0.0123', '3.2×10⁻⁷', '1.2×10⁶', '—')
    """
    value = float(value)
    if not isfinite(value):
        return DASH if value != value else ("∞" if value > 0 else MINUS + "∞")
    mantissa, _, exponent = f"{value:.{digits - 1}e}".partition("e")
    if -4 <= int(exponent) < 5:
        return _fixed(value, max(0, digits - 1 - int(exponent)))
    mantissa = _fixed(float(mantissa), digits - 1)
    return f"{mantissa}×10{str(int(exponent)).translate(SUPERSCRIPTS)}"


def _fixed(value: float, decimals: int) -> str:
    text = f"{value:.{decimals}f}"
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return "0" if text in ("-0", "") else text.replace("-", MINUS)


def aligned(values: Sequence[float] | np.ndarray, digits: int = 3) -> list[str]:
    """A column of numbers with the decimals that the smallest needs for ``digits`` digits, five at most."""
    known = [abs(value) for value in map(float, values) if isfinite(value) and value]
    if known and (max(known) >= 1e6 or max(known) < 1e-3):
        return [number(value, digits) for value in values]
    smallest = max(min(known), 1e-3 * max(known)) if known else 1.0  # what is next to nothing need not be spelt out
    decimals = min(5, max(0, digits - 1 - floor(log10(smallest))))
    return [
        f"{value:.{decimals}f}".replace("-", MINUS) if isfinite(value) else number(value)
        for value in map(float, values)
    ]


def power_of_ten(values: Sequence[float]) -> int:
    """The exponent to take out of the numbers along an axis: 0 while they are easy to read as they are."""
    largest = max((abs(value) for value in values), default=0.0)
    exponent = floor(log10(largest)) if largest else 0
    return 0 if -3 <= exponent < 4 else exponent


def with_unit(value: float, unit: str, digits: int = 3) -> str:
    """``number`` and its unit, joined by a no-break space."""
    return f"{number(value, digits)}\N{NO-BREAK SPACE}{unit}" if unit else number(value, digits)


def counted(number: int, noun: str) -> str:
    """``1 image``, ``2 images``."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def percent(share: float) -> str:
    """A share of 1 as a percentage with at most three digits; what is not quite all never reads as 100 %."""
    if share != share:
        return DASH
    if 0.9995 <= share < 1:
        return ">\N{NO-BREAK SPACE}99.9\N{NO-BREAK SPACE}%"
    if 0 < share < 1e-5:
        return "<\N{NO-BREAK SPACE}0.001\N{NO-BREAK SPACE}%"
    return f"{number(100 * share)}\N{NO-BREAK SPACE}%"


def nice_step(span: float, count: int) -> float:
    """The step 1, 2 or 5 times a power of ten that divides ``span`` > 0 into at most ``count`` parts."""
    raw = span / count
    power = 10.0 ** floor(log10(raw))
    return next(power * factor for factor in (1, 2, 5, 10) if power * factor >= raw * (1 - 1e-9))


def ticks(low: float, high: float, count: int = 5) -> list[float]:
    """Round values within [low, high], about ``count``, a step of 1, 2 or 5 times a power of ten apart."""
    step = nice_step(high - low, count)
    first, last = ceil(low / step - 1e-9), floor(high / step + 1e-9)
    return [round(index * step, 12 - floor(log10(step))) for index in range(first, last + 1)]


def log_ticks(low: float, high: float, count: int = 6) -> list[float]:
    """Round values within [low, high] for a log axis: powers of ten, 2 and 5 below two decades, even within one."""
    if high < 10 * low:
        return ticks(low, high, count)
    decades = range(floor(log10(low)), ceil(log10(high)) + 1)
    stride = max(1, ceil(len(decades) / count))
    factors = (1, 2, 5) if log10(high / low) < 2 else (1,)
    values = [factor * 10.0**decade for decade in decades if decade % stride == 0 for factor in factors]
    return [value for value in values if low * (1 - 1e-9) <= value <= high * (1 + 1e-9)]


def round_outwards(low: float, high: float) -> tuple[float, float]:
    """Limits widened to short numbers (by a fortieth of the range at most), to be read at the ends of a colour bar."""
    step = nice_step(high - low, 40)
    decimals = 12 - floor(log10(step))
    return round(floor(low / step + 1e-9) * step, decimals), round(ceil(high / step - 1e-9) * step, decimals)


def finite(arrays: Sequence[np.ndarray]) -> np.ndarray:
    """All finite values of the arrays in one row, at most some 100 000 of each: percentiles of maps need no more."""
    thinned = [np.ravel(array)[:: max(1, np.size(array) // 100_000)] for array in arrays]
    return np.concatenate([values[np.isfinite(values)] for values in thinned]) if thinned else np.empty(0)
