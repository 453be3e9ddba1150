"""Formats of measured values in a text: `sig2` for two significant digits, or any format of Python."""

import re
from math import floor, log10

from benchmarks.figures.data import Value

NOTHING = "-"
SIGNIFICANT = re.compile(r"sig(\d)")


def written(value: Value, form: str = "") -> str:
    """Return a value as text; `-` for None."""
    if value is None:
        return NOTHING
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, str):
        return value
    digits = SIGNIFICANT.fullmatch(form)
    return significant(value, int(digits[1])) if digits else format(value, form)


def significant(value: float, digits: int) -> str:
    """Return a number with significant digits, without exponent from 1e-4 on: 0.154 -> 0.15, 1760 -> 1,800."""
    if value == 0.0:
        return "0"
    place = digits - 1 - floor(log10(abs(value)))
    if place > digits + 3:
        return f"{value:.{digits - 1}e}"
    place = digits - 1 - floor(log10(abs(round(value, place))))  # 0.0996 is 0.10 with two digits
    return f"{round(value, place):,.{max(place, 0)}f}"
