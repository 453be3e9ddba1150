"""Several values written as one: `1 .. 18`, `5 mm .. 15 mm by 0.5 mm`, or a list of them."""

import re
from collections.abc import Iterator
from decimal import Decimal
from fractions import Fraction
from typing import TYPE_CHECKING, Final

from stackdsl.language.expressions import constant, value_of
from stackdsl.language.mistakes import MistakeError, shown
from stackdsl.language.quantities import QUANTITY, in_si, quantity_text
from stackdsl.reading.source import Plain

if TYPE_CHECKING:
    from stackdsl.language.quantities import Amount

_RANGE: Final = re.compile(r"(?P<first>.+?)\s*\.\.\s*(?P<last>.+?)(?:\s+by\s+(?P<step>.+))?")
ROUNDING: Final = Fraction(1, 10**9)  # of a step; what expressions may lose of their digits
LONGEST_DECIMAL: Final = 20  # [digits] that the text of a value may have after its point, as numbers are bounded
_ADVICE: Final = "write such as [10 mm, 12 mm], 1 .. 18, or 5 mm .. 15 mm by 0.5 mm"


def values_of(written: Plain, most: int) -> list[Plain]:
    """The values that a row or a loop runs through, as an author would write each.

    Raises MistakeError: SD206 where there are more than `most`, which is known before any is made.
    """
    if isinstance(written, str) and (match := _RANGE.fullmatch(written.strip())):
        return list(_between(match, written, most))
    if not isinstance(written, list) or not written:
        raise MistakeError("SD103", f"expected a list of values or a range, not {shown(written)}", _ADVICE)
    _keep_to(most, len(written), "the list")
    return written


def _between(match: re.Match[str], written: str, most: int) -> Iterator[Plain]:
    parts = {key: _part(part, written) for key, part in match.groupdict().items() if part is not None}
    first, last = parts["first"], parts["last"]
    if first.units != last.units or parts.get("step", first).units != first.units:
        raise MistakeError(
            "SD106", f"the range {shown(written)} has ends of two kinds", "give all parts a unit of one kind"
        )
    if "step" not in parts and not first.dimensionless:
        raise MistakeError(
            "SD102", f"the range {shown(written)} has no step", f"add such as: {written} by 1 {_unit(match)}"
        )
    step: Fraction = parts["step"].magnitude if "step" in parts else Fraction(1)
    if step == 0 or (last.magnitude - first.magnitude) / step < 0:
        raise MistakeError(
            "SD104", f"the range {shown(written)} never gets to its end", "a step down is negative: 18 .. 1 by -1"
        )
    steps = (last.magnitude - first.magnitude) / step
    count = round(steps)
    if abs(steps - count) > ROUNDING:
        ends = _text(first.magnitude + int(steps) * step, _unit(match))
        message = f"the range {shown(written)} ends at {ends}, and not where it says"
        raise MistakeError("SD104", message, "let its last value be one that the steps meet")
    _keep_to(most, count + 1, f"the range {shown(written)}")
    yield from (_text(first.magnitude + index * step, _unit(match)) for index in range(count + 1))


def _part(part: str, written: str) -> "Amount":
    try:
        return constant(part)
    except MistakeError as mistake:
        raise MistakeError("SD103", f"the range {shown(written)} cannot be read at '{part}'", _ADVICE) from mistake


def _keep_to(most: int, count: int, what: str) -> None:
    if count > most:
        raise MistakeError("SD206", f"{what} has {count} values, and {most} is the most", "take fewer, or larger steps")


def _unit(match: re.Match[str]) -> str:
    """The unit that the values are written in: that of the first part that has one."""
    units = (part["unit"] for text in match.groups() if text and (part := QUANTITY.fullmatch(text.strip())))
    return next(filter(None, units), "")


def _text(magnitude: Fraction, unit: str) -> Plain:
    """So much, in a unit; a number if there is none."""
    number = magnitude / in_si(unit)
    decimal = f"{Decimal(number.numerator) / number.denominator:.{LONGEST_DECIMAL}f}".rstrip("0").rstrip(".")
    if not unit:
        return int(number) if number.denominator == 1 else float(number)
    return f"{decimal} {unit}" if Fraction(decimal) == number else quantity_text(magnitude, unit)


def told_apart(values: list[Plain]) -> Iterator[tuple[int, MistakeError]]:
    """The values of a list that are none, or that are there already, by number; `10 mm` and `1 cm` are the same."""
    seen: set[object] = set()
    for index, written in enumerate(values):
        try:
            value = value_of(written)
        except MistakeError as mistake:
            yield index, mistake
            continue
        if value in seen:
            yield index, MistakeError("SD104", f"{shown(written)} is in the row already", "write each value once")
        seen.add(value)
