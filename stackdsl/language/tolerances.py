"""Tolerances, read into SI: `9 ± 1`, `>= 20`, `5 s .. 7 s`.

A tolerance that no value meets, or that allows a single measured value only, is a mistake.
"""

import re
from dataclasses import dataclass
from fractions import Fraction
from math import ceil, floor, inf, isfinite

from stackdsl.language.quantities import (
    QUANTITY,
    SIGNED,
    Dimension,
    InputError,
    advice,
    as_text,
    exact_quantity,
    nearest_double,
    quantity_text,
    range_advice,
    range_remedy,
    si_unit,
)


@dataclass(frozen=True, slots=True)
class Tolerance:
    """An interval of accepted values, in SI."""

    low: float  # -inf if there is none
    high: float  # inf if there is none
    low_open: bool  # the lower bound itself is not accepted
    high_open: bool
    text: str  # as written

    def holds(self, value: float) -> bool:
        """Return whether the value lies inside."""
        above = self.low < value if self.low_open else self.low <= value
        return above and (value < self.high if self.high_open else value <= self.high)

    def meets(self, other: "Tolerance") -> bool:
        """Return whether some value lies in both tolerances."""
        low, high = max(self.low, other.low), min(self.high, other.high)
        return low < high or (low == high and self.holds(low) and other.holds(low))

    def same_for(self, least: float, most: float) -> bool:
        """Return whether all values from `least` to `most` are accepted, or none is."""
        between = Tolerance(least, most, low_open=False, high_open=False, text="")
        return (self.holds(least) and self.holds(most)) or not self.meets(between)

    def margin(self, value: float) -> float:
        """Return the signed distance to the nearest bound, positive inside; 0 at a bound, open or not."""
        return min(value - self.low, self.high - value)

    @property
    def least_count(self) -> float:
        """Return the least whole number that is accepted; 0 if there is no lower bound."""
        if self.low == -inf:
            return 0.0
        return floor(self.low) + 1.0 if self.low_open else float(ceil(self.low))


@dataclass(frozen=True, slots=True)
class MassTolerance(Tolerance):
    """A tolerance of a weight that is written as a mass [kg]."""


_ONE_SIDED = re.compile(r"(>=|<=|[<>≥≤])\s*(.+)")
_AROUND = re.compile(r"(.+?)\s*(?:±|\+/?-)\s*(.+)")
_APPROXIMATE = ("~", "≈")
_BETWEEN = re.compile(r"(.+?)\s*\.\.\s*(.+)")


def parse_tolerance(written: object, dimension: Dimension) -> Tolerance:
    """Read a tolerance into SI: `9 ± 1`, `>= 20`, `5 s .. 7 s`, or an exact whole number. Raises InputError."""
    text = as_text(written, dimension)
    body = _after_prefix(text, dimension)
    low, high, is_open = _bounds(body, text, dimension)
    tolerance = Tolerance(float(low), float(high), is_open and low != -inf, is_open and high != inf, text)
    if low > high:
        raise _malformed(text, "has its bounds in the wrong order", "write the smaller number first")
    # A measured value can be exactly the least of its dimension: `drift: 0 mm` means that nothing moves.
    if low == high and not dimension.whole and low != dimension.least:
        raise _malformed(text, "is a single value, which a measurement never equals exactly", _with_room(body))
    if not _can_hold(tolerance, dimension):
        raise _malformed(text, f"cannot be met by {dimension.noun}", range_advice(dimension))
    return tolerance


def parse_lower_bound(written: object, dimension: Dimension) -> Tolerance:
    """Read a tolerance that must not have an upper bound. Raises InputError."""
    text = as_text(written, dimension)
    low, high, _ = _bounds(_after_prefix(text, dimension), text, dimension)
    if isinstance(high, Fraction):
        bound = max(low if isinstance(low, Fraction) else high, Fraction(0))
        hint = f'write "> {quantity_text(bound, si_unit(dimension)).rstrip()}"'
        raise _malformed(text, "is not a lower bound", hint)
    return parse_tolerance(text, dimension)


def parse_share(written: object, dimension: Dimension) -> Tolerance:
    """Read a tolerance of a share; a single number is the least accepted share. Raises InputError."""
    text = as_text(written, dimension)
    alone = QUANTITY.fullmatch(text) is not None
    return parse_tolerance(f">= {text}" if alone else text, dimension)


def _malformed(text: str, fault: str, hint: str) -> InputError:
    return InputError("SD107", f"the tolerance '{text}' {fault}", hint)


def _with_room(body: str) -> str:
    """Return the remedy for a single value: add a width, or write a limit."""
    is_range = re.search(r"±|\+/?-|\.\.", body)
    last = QUANTITY.fullmatch(re.split(r"±|\+/?-|\.\.", body)[-1].strip())
    unit = f" {last['unit']}" if last is not None and last["unit"] else ""
    return f"add a width, such as ± 0.1{unit}" + ("" if is_range else f', or write a limit: "<= {body}" or ">= {body}"')


def _after_prefix(text: str, dimension: Dimension) -> str:
    head, _, rest = text.partition(" ")
    if not dimension.prefix:
        return text
    if head != dimension.prefix:
        raise InputError("SD105", f"'{text}' does not begin with '{dimension.prefix}'", advice(dimension))
    return rest.strip()


def _bounds(body: str, text: str, dimension: Dimension) -> tuple[Fraction | float, Fraction | float, bool]:
    """Return lower and upper bound, and whether they are open. Raises InputError if a bound overflows a double."""
    low, high, is_open = _exact_bounds(body, text, dimension)
    if any(isinstance(bound, Fraction) and not isfinite(nearest_double(bound)) for bound in (low, high)):
        raise InputError("SD104", f"the tolerance '{text}' is out of range", range_advice(dimension))
    return low, high, is_open


def _exact_bounds(body: str, text: str, dimension: Dimension) -> tuple[Fraction | float, Fraction | float, bool]:
    if match := _ONE_SIDED.fullmatch(body):
        bound = _part(match[2], text, dimension)
        low, high = (bound, inf) if match[1] in {">", ">=", "≥"} else (-inf, bound)
        return low, high, match[1] in {">", "<"}
    if match := _AROUND.fullmatch(body):
        middle, width = _pair(match, text, dimension)
        if width < 0:
            raise _malformed(text, "has a negative width", "write the width after ± without a sign")
        return middle - width, middle + width, False
    if match := _BETWEEN.fullmatch(body):
        return *_pair(match, text, dimension), False
    exact = _part(body, text, dimension)
    return exact, exact, False


def _pair(match: re.Match[str], text: str, dimension: Dimension) -> tuple[Fraction, Fraction]:
    """Return both numbers. A unit that is only at the end applies to both."""
    first, last = match[1], match[2]
    unit = QUANTITY.fullmatch(last)
    if dimension.needs_unit and unit and re.fullmatch(SIGNED, first):
        first += unit["unit"] or ""
    middle = QUANTITY.fullmatch(first)
    if dimension.needs_unit and unit and middle and unit["unit"] == "%":
        width = f"{float(middle['number']) * float(unit['number']) / 100:g} {middle['unit']}"
        raise _malformed(text, "has a width in percent", f"write {first} ± {width}")
    return _part(first, text, dimension), _part(last, text, dimension)


def _part(part: str, text: str, dimension: Dimension) -> Fraction:
    try:
        return exact_quantity(part, dimension)
    except InputError as mistake:
        unit = f" {dimension.example.split()[-1]}" if dimension.needs_unit else ""
        if mistake.code == "SD105":
            quantity = f"{text}{unit}"
            forms = f'write, for example, {quantity} ± 0.1{unit}, "<= {quantity}" or ">= {quantity}"'
            is_single = QUANTITY.fullmatch(text) is not None
            raise InputError("SD105", mistake.message, forms if is_single else f"write {quantity}") from mistake
        if mistake.code != "SD103":
            raise
        if part[:1] in _APPROXIMATE and QUANTITY.fullmatch(bare := part[1:].strip()):
            raise _malformed(text, "has no width", _with_room(bare)) from mistake
        forms = f'write, for example, 9{unit} ± 1{unit}, ">= 20{unit}", or 5{unit} .. 7{unit}'
        raise _malformed(text, f"cannot be read at '{part}'", range_remedy(part) or forms) from mistake


def _can_hold(tolerance: Tolerance, dimension: Dimension) -> bool:
    low, high = max(tolerance.low, dimension.least), min(tolerance.high, dimension.most)
    if dimension.whole:
        first = floor(low) + 1 if tolerance.low_open and low == tolerance.low else ceil(low)
        last = ceil(high) - 1 if tolerance.high_open and high == tolerance.high else floor(high)
        return first <= last
    return low < high or (tolerance.holds(low) and low == high)
