"""Variables of which only the spread is known: `uncertain: {mu: 0.5 ± 0.05}`, with another value in each sample.

The design has the middle of each. What two quantities have in common is said by expressions over one variable.
"""

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from math import erfc, exp, floor, inf, log, sqrt
from typing import TYPE_CHECKING, Final

from stackdsl.language.choices import Mistakes, add, check_name
from stackdsl.language.expressions import constant, unit_text
from stackdsl.language.mistakes import MistakeError, shown
from stackdsl.language.quantities import quantity_text
from stackdsl.reading.source import Plain

if TYPE_CHECKING:
    from stackdsl.language.quantities import Amount

DIGITS: Final = 12  # of a value that is drawn: fewer than processors agree on
EXAMPLE: Final = "write 0.5 ± 0.05, normal 12 g ± 0.5 g least 10 g, lognormal 0.5 dispersion 0.2, or table 1 mm; 3 mm"
LIMITS: Final[tuple[str, ...]] = ("least", "most")
ONE_LINE: Final = ("uniform", "normal", "lognormal", "table")  # what one in one line may begin with
KEYS: Final = (*ONE_LINE, "dispersion", *LIMITS)
ONE_LINE_EXAMPLE: Final = "write such as normal 12 g ± 0.5 g least 10 g, or lognormal 0.5 dispersion 0.2"
RAREST: Final = 1e-9  # of what lies within the limits; of less, digits are lost, and nobody means it
_FURTHER = re.compile(rf",?\s+({'|'.join(('dispersion', *LIMITS))})\b")  # a comma ends a value within braces of YAML
_AROUND = re.compile(r"(.+?)\s*(?:±|\+/?-)\s*(.+)")
_BETWEEN = re.compile(r"(.+?)\s*\.\.\s*(.+)")
Normal = Callable[[float], float]  # from a number between 0 and 1 to so many standard deviations


@dataclass(frozen=True, slots=True)
class Distribution:
    """How a variable is spread, in SI."""

    kind: str
    unit: str
    numbers: tuple[float, ...]  # both ends; or mean and standard deviation; or median and dispersion; or a table
    limits: tuple[float, float] = (-inf, inf)  # beyond which nothing is drawn

    @property
    def middle(self) -> Plain:
        """The value that the design has: half of all are below it."""
        if self.limits != (-inf, inf):
            from statistics import NormalDist  # noqa: PLC0415 -- few are cut off

            return self.at(0.5, NormalDist().inv_cdf)
        return self._written(Fraction(repr(self._value(0.5, lambda _: 0.0))))

    def at(self, uniform: float, normal: Normal) -> Plain:
        """The value below which this share of all lies, as an author would write it."""
        value = min(max(self._value(uniform, normal), self.limits[0]), self.limits[1])
        return self._written(Fraction(f"{value:.{DIGITS}g}"))

    def _written(self, value: Fraction) -> Plain:
        if self.unit:
            return quantity_text(value, self.unit)
        return int(value) if self.kind == "table" and value.denominator == 1 else float(value)

    def _value(self, uniform: float, normal: Normal) -> float:
        first, second = self.numbers[0], self.numbers[-1]
        match self.kind:
            case "uniform":
                return first + (second - first) * uniform
            case "normal":
                return first + second * self._within(uniform, normal)
            case "lognormal":
                return first * exp(second * self._within(uniform, normal))
            case _:
                return self.numbers[floor(uniform * len(self.numbers))]

    def _within(self, uniform: float, normal: Normal) -> float:
        """So many standard deviations, none beyond the limits: what lies beyond is left out, not moved to them."""
        if self.limits == (-inf, inf):
            return normal(uniform)
        low, high = (self._deviations(limit) for limit in self.limits)
        if low > 0.0:  # above the middle shares are near to one, where digits are lost: seen from the other side
            return -_between(-high, -low, 1.0 - uniform, normal)
        return _between(low, high, uniform, normal)

    @property
    def share_within(self) -> float:
        """The share of all that lies within the limits."""
        low, high = (self._deviations(limit) for limit in self.limits)
        low, high = (-high, -low) if low > 0.0 else (low, high)
        return _share_below(high) - _share_below(low)

    def _deviations(self, limit: float) -> float:
        """How many standard deviations a limit is above the middle."""
        if self.kind == "lognormal":
            return -inf if limit <= 0.0 else (log(limit / self.numbers[0]) / self.numbers[1])
        return (limit - self.numbers[0]) / self.numbers[1]


def _between(low: float, high: float, uniform: float, normal: Normal) -> float:
    """So many standard deviations, between two numbers of them."""
    least, most = _share_below(low), _share_below(high)
    return normal(least + (most - least) * uniform)


def _share_below(deviations: float) -> float:
    return 0.5 * erfc(-deviations / sqrt(2.0))


def distributions(written: Plain, taken: Mapping[str, object], mistakes: Mistakes) -> dict[str, Distribution | None]:
    """The variables of `uncertain`; None where one is mistaken. `taken` are the names that are in use."""
    if not isinstance(written, dict) or not written:
        add(mistakes, ("uncertain",), MistakeError("SD103", "expected a mapping of variables", EXAMPLE))
        return {}
    found: dict[str, Distribution | None] = {}
    for name, spread in written.items():
        try:
            check_name(name, taken, "the matrix")
            found[name] = distribution(spread)
        except MistakeError as mistake:
            add(mistakes, ("uncertain", name), mistake)
            found[name] = None
    return found


def distribution(written: Plain) -> Distribution:
    """How one variable is spread. Raises MistakeError."""
    if isinstance(written, str) and (worded := _in_one_line(written)) is not None:
        written = worded
    if not isinstance(written, dict):
        return _uniform(written)
    limits: dict[str, Plain] = {key: written[key] for key in LIMITS if key in written}
    found = _of_keys({key: value for key, value in written.items() if key not in LIMITS}, written)
    return _limited(found, limits) if limits else found


def _of_keys(written: Mapping[str, Plain], whole: Plain) -> Distribution:
    keys = set(written)
    if keys == {"uniform"}:
        return _uniform(written["uniform"])
    if keys == {"normal"}:
        middle, width = _pair(written["normal"], _AROUND)
        return _made("normal", middle, width, positive=True)
    if keys == {"lognormal", "dispersion"}:
        median, dispersion = _amount(written["lognormal"]), _amount(written["dispersion"])
        if unit_text(dispersion):
            raise MistakeError("SD104", "a dispersion is a number", "write such as 0.2, of the logarithm")
        if median.magnitude <= 0 or dispersion.magnitude <= 0:
            raise MistakeError("SD104", "median and dispersion are more than zero", EXAMPLE)
        numbers = (float(median.magnitude), float(dispersion.magnitude))
        return Distribution("lognormal", unit_text(median), numbers)
    if keys == {"table"}:
        return _table(written["table"])
    raise MistakeError("SD103", f"{shown(whole)} is no distribution", EXAMPLE)


def _in_one_line(text: str) -> Plain:
    """The mapping that `normal 0.5 ± 0.2 least 0.1` is short for; None of what begins with no such word."""
    word, _, rest = text.strip().partition(" ")
    if word not in ONE_LINE:
        return None
    if word == "table":
        return {"table": [part.strip() for part in re.split("[;,]", rest)]}
    first, *others = _FURTHER.split(rest)
    found: dict[str, Plain] = {word: first.strip()}
    for key, value in zip(others[::2], others[1::2], strict=True):
        if not value.strip() or key in found:
            raise MistakeError("SD103", f"{shown(text)} cannot be read at '{key}'", ONE_LINE_EXAMPLE)
        found[key] = value.strip()
    return found


def _limited(found: Distribution, written: Mapping[str, Plain]) -> Distribution:
    """The same, with nothing beyond its limits."""
    if found.kind not in ("normal", "lognormal"):
        message = f"a {found.kind} distribution has its limits"
        raise MistakeError("SD104", message, "leave `least` and `most` to normal and lognormal ones")
    limits = {}
    for key, value in written.items():
        amount = _amount(value)
        if unit_text(amount) != found.unit and amount.magnitude != 0:
            raise MistakeError("SD104", f"`{key}` is of another kind than what it limits", "give it the same unit")
        limits[key] = float(amount.magnitude)
    low, high = limits.get("least", -inf), limits.get("most", inf)
    made = replace(found, limits=(low, high))
    if low >= high or made.share_within < RAREST:
        raise MistakeError("SD104", "hardly anything lies within `least` and `most`", "let them hold more of it")
    return made


def _uniform(written: Plain) -> Distribution:
    text = written if isinstance(written, str) else ""
    if _BETWEEN.fullmatch(text.strip()):
        low, high = _pair(written, _BETWEEN)
        if low.magnitude >= high.magnitude:
            raise MistakeError("SD104", f"{shown(written)} leaves no room", "write the smaller end first")
        return _made("uniform", low, high)
    middle, width = _pair(written, _AROUND)
    if width.magnitude <= 0:
        raise MistakeError("SD104", f"{shown(written)} leaves no room", "write a width that is more than zero")
    return _made("uniform", middle - width, middle + width)


def _table(written: Plain) -> Distribution:
    if not isinstance(written, list) or not written:
        raise MistakeError("SD103", f"expected a list of values, not {shown(written)}", EXAMPLE)
    amounts = [_amount(each) for each in written]
    units = {unit_text(amount) for amount in amounts}
    if len(units) > 1:
        raise MistakeError("SD104", "the values of a table are of several kinds", "give all a unit of one kind")
    return Distribution("table", units.pop(), tuple(sorted(float(amount.magnitude) for amount in amounts)))


def _made(kind: str, first: "Amount", second: "Amount", *, positive: bool = False) -> Distribution:
    if positive and second.magnitude <= 0:
        raise MistakeError("SD104", "a standard deviation is more than zero", EXAMPLE)
    return Distribution(kind, unit_text(first), (float(first.magnitude), float(second.magnitude)))


def _pair(written: Plain, form: "re.Pattern[str]") -> tuple["Amount", "Amount"]:
    """Both parts of a text; a unit that stands only at the end is for both."""
    match = form.fullmatch(written.strip()) if isinstance(written, str) else None
    if match is None:
        raise MistakeError("SD103", f"{shown(written)} is no distribution", EXAMPLE)
    first, second = _amount(match[1]), _amount(match[2])
    if unit_text(second) and not unit_text(first):
        first = _amount(f"{match[1]} {match[2].lstrip('+-.0123456789eE')}")
    if unit_text(first) != unit_text(second):
        raise MistakeError("SD104", f"{shown(written)} has parts of several kinds", "give both a unit of one kind")
    return first, second


def _amount(written: Plain) -> "Amount":
    return constant(written, EXAMPLE)


def named(found: Mapping[str, Distribution | None]) -> Iterator[tuple[str, Distribution]]:
    """Those without a mistake."""
    yield from ((name, each) for name, each in found.items() if each is not None)


def middle(_: str, each: Distribution) -> Plain:
    """What the design has of a variable."""
    return each.middle
