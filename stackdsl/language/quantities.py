"""Reads quantities with units into SI."""

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from decimal import Decimal
from fractions import Fraction
from functools import cache, lru_cache
from math import inf, nextafter, prod, radians
from typing import TYPE_CHECKING, Final, TypeAlias

from stability.geometry.vectors import SHORTEST
from stackdsl.diagnostics import did_you_mean

if TYPE_CHECKING:
    from pint import UnitRegistry
    from pint.facets.plain import PlainQuantity


# Mistakes as whoever reads one value raises them; where in the file that value stands is not known there.


DECIMAL_COMMA: Final = re.compile(r"((?:[<>]=?\s*)?[-+]?\d{1,9}),(\d{1,9})(\s*[a-zA-Z%][^,]*)?")


class MistakeError(ValueError):
    """A mistake of the author in one value; a `ValueError`, so that pydantic carries it.

    A hint that takes long to find, such as what else is called alike, is looked for only where the mistake is told.
    """

    def __init__(self, code: str, message: str, hint: str | Callable[[], str] = "") -> None:
        super().__init__(message)
        self.code, self.message, self._hint = code, message, hint

    @property
    def hint(self) -> str:
        """What to do about it."""
        return self._hint if isinstance(self._hint, str) else self._hint()


class EchoError(ValueError):
    """What follows from a mistake that is told elsewhere, and is itself none."""


def without_comma(written: object) -> str:
    """What to write in place of a number with a decimal comma; empty for anything else."""
    found = DECIMAL_COMMA.fullmatch(written.strip()) if isinstance(written, str) else None
    return f"write a decimal point in place of the comma: {found[1]}.{found[2]}{found[3] or ''}" if found else ""


def shown(written: object) -> str:
    """What the author wrote, for a message."""
    match written:
        case None:
            return "nothing"
        case bool():
            return str(written).lower()
        case str():
            return f"'{written}'" if len(written) <= 40 else f"'{written[:39]}…'"  # noqa: PLR2004 -- what fits a line
        case dict():
            return "a mapping"
        case list() | tuple():
            return "a list"
    return repr(written)


# Quantities as people write them, read into SI.
#
# Numbers stay exact fractions until the last step, so `13.5 mm` is the double nearest to 0.0135 and `0.3 m / 0.1 m` is
# 3. Units are the few that scenarios need, defined for pint; an unknown one is a mistake, never a guess.


if TYPE_CHECKING:
    Amount: TypeAlias = PlainQuantity[Fraction]  # in SI base units; an angle is a dimension of its own

REMEMBERED: Final = 10_000  # texts with what they mean: in long scenarios the same ones stand again and again

# What pint is told, and nothing more: no prefixes, no long names.
UNITS: Final[Mapping[str, str]] = {
    **{"m": "[length]", "mm": "0.001 * m", "cm": "0.01 * m", "km": "1000 * m", "um": "0.000001 * m"},
    **{"s": "[time]", "ms": "0.001 * s", "min": "60 * s", "Hz": "1 / s"},
    **{"kg": "[mass]", "g": "0.001 * kg"},
    # An angle is not a number here, so `sin(0.5)` and `tilt: 50 %` are mistakes that can be told.
    **{"rad": "[angle]", "deg": "3.14159265358979323846264338327950288 / 180 * rad"},
    **{"N": "kg * m / s**2", "mN": "0.001 * N", "J": "N * m", "g0": "9.80665 * m / s**2", "percent": "0.01"},
}
# How many SI base units each is. Pint says the same (a test asks it), but takes longer to import than most checks take.
_IN_SI: Final[Mapping[str, Fraction]] = {
    **{
        "m": Fraction(1),
        "mm": Fraction(1, 1000),
        "cm": Fraction(1, 100),
        "km": Fraction(1000),
        "um": Fraction(1, 10**6),
    },
    **{"s": Fraction(1), "ms": Fraction(1, 1000), "min": Fraction(60), "Hz": Fraction(1)},
    **{"kg": Fraction(1), "g": Fraction(1, 1000)},
    **{"rad": Fraction(1), "deg": Fraction("3.14159265358979323846264338327950288") / 180},
    **{
        "N": Fraction(1),
        "mN": Fraction(1, 1000),
        "J": Fraction(1),
        "g0": Fraction("9.80665"),
        "percent": Fraction(1, 100),
    },
}
# What authors write in place of an SI unit, below so much of it.
_EVERYDAY: Final[Mapping[str, tuple[str, float]]] = {"m": ("mm", 1.0), "kg": ("g", 1.0), "rad": ("deg", inf)}
_SPELLINGS = str.maketrans(
    {"²": "2", "³": "3", "^": "", "·": "*", "°": "deg", "%": "percent", "µ": "u", "μ": "u"}
)  # both signs of micro

# Digits are bounded: reading a number of a million digits takes minutes. And they are ASCII: Python takes the digits of
# other scripts for numbers as well, and no other reader of the file does.
NUMBER: Final = r"(?:[0-9]{1,20}(?:\.[0-9]{1,20})?|\.[0-9]{1,20})(?:[eE][+-]?[0-9]{1,3})?"
_NAMES = "|".join(sorted([*UNITS, "%", "°", "µm", "μm"], key=len, reverse=True))
_FACTOR = rf"(?:{_NAMES})(?:\^?[23]|[²³])?(?!\w)"
UNIT: Final = rf"{_FACTOR}(?:[*/·]{_FACTOR})*"
SIGNED: Final = rf"[+-]?{NUMBER}"
ZERO: Final = r"[+-]?0(?:\.0{1,20})?"  # needs no unit
QUANTITY: Final = re.compile(rf"(?P<number>{SIGNED})\s*(?P<unit>(?:[^\W\d_]|[%°])[^\s.<>=±]*)?")


@dataclass(frozen=True, slots=True)
class Dimension:
    """A kind of value: how it is written, and between which SI values it lies."""

    noun: str
    units: tuple[str, ...]
    example: str
    least: float = -inf
    most: float = inf
    positive: bool = False  # more than zero
    needs_unit: bool = True
    whole: bool = False
    prefix: str = ""  # a word before the number


def _degrees(angle: int) -> float:
    """A limit that the exact angle does not exceed, as the nearest double may [rad]."""
    return nextafter(radians(angle), inf)


# Beyond 10 km, a day or a hundred turns there is a typo, which should not cost a day to find.
LENGTH: Final = Dimension("a length", ("mm", "cm", "m", "km", "um"), "13.5 mm", -1e4, 1e4)
EXTENT: Final = replace(LENGTH, least=0.0)
SIDE: Final = replace(LENGTH, least=SHORTEST, positive=True)  # the least that statics tells from nothing
DURATION: Final = Dimension("a duration", ("ms", "s", "min"), "1.5 s", 0.0, 86_400.0)
FREQUENCY: Final = Dimension("a frequency", ("Hz",), "5 Hz", 0.0, 1e6)
ANGLE: Final = Dimension("an angle", ("deg", "rad"), "30 deg", -_degrees(36_000), _degrees(36_000))
SLOPE: Final = replace(ANGLE, least=0.0, most=_degrees(90))
DENSITY: Final = Dimension("a density", ("kg/m3", "g/cm3"), "557 kg/m3", 0.0, 1e6, positive=True)
MASS: Final = Dimension("a mass", ("g", "kg"), "11.9 g", 0.0, 1e9, positive=True)
ACCELERATION: Final = Dimension(
    "an acceleration", ("m/s2", "cm/s2", "mm/s2", "g0"), "9.81 m/s2", 0.0, 1e4, positive=True
)
# Faster, and engines let thin bricks pass through one another.
SPEED: Final = Dimension("a speed", ("m/s", "cm/s", "mm/s"), "2 m/s", 0.0, 20.0, positive=True)
IMPULSE: Final = Dimension("an impulse", ("N*s", "mN*s", "kg*m/s", "g*m/s"), "0.01 N*s", -1e6, 1e6)
COUNT: Final = Dimension("a count", (), "<= 2", 0, 10**9, needs_unit=False, whole=True)
LEVEL: Final = Dimension("a level", (), "level 9 ± 1", 1, 10**9, needs_unit=False, whole=True, prefix="level")
SHARE: Final = Dimension("a share", ("%",), "25 %", 0.0, 1.0, needs_unit=False)

PARTS_OF_G: Final = Dimension("an acceleration in g", (), ">= 0.05", 0.0, 1e3, needs_unit=False)
COEFFICIENT: Final = Dimension("a coefficient of friction", (), "<= 0.2", 0.0, 10.0, needs_unit=False)


@cache
def registry() -> "UnitRegistry[Fraction]":
    """The units of scenarios, made when the first one is met."""
    # Importing pint takes a quarter of a second, which `--help` or a broken file should not wait for.
    from pint import UnitRegistry  # noqa: PLC0415 -- as said

    units: UnitRegistry[Fraction] = UnitRegistry(None, non_int_type=Fraction)
    for name, meaning in UNITS.items():
        units.define(f"{name} = {meaning}")
    return units


@cache
def unit_amount(unit: str) -> "Amount":
    """One of a unit that matches `UNIT`, in SI base units; of the empty text, the number one."""
    product: Amount = registry().Quantity(Fraction(1))
    for name, power in _factors(unit):
        product = product * registry().Quantity(Fraction(1), name).to_base_units() ** power
    return product


@cache
def in_si(unit: str) -> Fraction:
    """How many SI base units one of a unit is that matches `UNIT`; of the empty text, one."""
    return prod((_IN_SI[name] ** power for name, power in _factors(unit)), start=Fraction(1))


def _factors(unit: str) -> Iterator[tuple[str, int]]:
    """The units that a unit is a product of, each with its power."""
    for operator, name, power in re.findall(r"([*/]?)([A-Za-z]+0?)([23]?)", unit.translate(_SPELLINGS)):
        yield name, int(power or 1) * (-1 if operator == "/" else 1)


def as_text(written: object, dimension: Dimension) -> str:
    """What was written, as text; YAML may have read it as a number."""
    if isinstance(written, int | float) and not isinstance(written, bool):
        return repr(written)
    if isinstance(written, str):
        return written.strip()
    raise MistakeError("SD103", f"expected {dimension.noun}, not {shown(written)}", advice(dimension))


def advice(dimension: Dimension) -> str:
    """What to write instead."""
    unit = " with its unit" if dimension.needs_unit else ""
    return f"write {dimension.noun}{unit}, such as {dimension.example}"


def range_advice(dimension: Dimension) -> str:
    """Between which values to stay, where the form is right."""
    if dimension.whole:
        return f"write whole numbers from {dimension.least} up"
    unit = _everyday_unit(si_unit(dimension), dimension.most)
    least, most = (f"{bound / float(in_si(unit)):.10g}" for bound in (dimension.least, dimension.most))
    low = "more than zero, at most" if dimension.positive and not dimension.least else f"between {least} and"
    return f"write {low} {most} {unit}".rstrip()


def si_unit(dimension: Dimension) -> str:
    """The SI unit of a dimension; empty for numbers."""
    return next((unit for unit in dimension.units if in_si(unit) == 1), "")


def quantity_text(magnitude: Fraction, unit: str) -> str:
    """So much of an SI unit as an author would write it; it reads back to the same double."""
    everyday = _everyday_unit(unit, magnitude)
    scale = Fraction(1) if everyday == unit else in_si(everyday)
    number = magnitude / scale
    decimal = f"{Decimal(number.numerator) / number.denominator:.20f}".rstrip("0").rstrip(".")
    if re.fullmatch(SIGNED, decimal) and float(Fraction(decimal) * scale) == float(magnitude):
        return f"{decimal} {everyday}"
    return f"{float(magnitude)!r} {unit}"


def _everyday_unit(unit: str, magnitude: Fraction | float) -> str:
    """The unit that an author would take for so much of an SI unit."""
    small, limit = _EVERYDAY.get(unit, (unit, 0.0))
    return small if abs(float(magnitude)) < limit else unit


@lru_cache(maxsize=REMEMBERED)
def exact_quantity(text: str, dimension: Dimension) -> Fraction:
    """A quantity in SI, exactly."""
    match = QUANTITY.fullmatch(text)
    if match is None:
        raise MistakeError("SD103", f"expected {dimension.noun}, not {shown(text)}", advice(dimension))
    unit = match["unit"] or ""
    if not unit and dimension.needs_unit and Fraction(match["number"]) != 0:  # which is the same in every unit
        raise MistakeError("SD105", f"{shown(text)} lacks the unit of {dimension.noun}", advice(dimension))
    if unit and unit.translate(_SPELLINGS) not in _spelled(dimension):
        hint = did_you_mean(unit, dimension.units) or advice(dimension)
        raise MistakeError("SD106", f"{shown(unit)} is not a unit of {dimension.noun}", hint)
    return Fraction(match["number"]) * in_si(unit)


@cache
def _spelled(dimension: Dimension) -> frozenset[str]:
    """The units of a dimension, each in the one spelling that all others are brought to."""
    return frozenset(unit.translate(_SPELLINGS) for unit in dimension.units)


def parse_quantity(written: object, dimension: Dimension) -> float:
    """A quantity in SI (angles in rad), within the range of its dimension."""
    value = nearest_double(exact_quantity(as_text(written, dimension), dimension))
    if dimension.positive and value <= 0.0:
        raise MistakeError("SD104", f"{dimension.noun} of {written} is not more than zero", "write more than zero")
    # The limits are doubles too: the exact 1e-9 is less than the double that is called so.
    if not dimension.least <= value <= dimension.most:
        raise MistakeError("SD104", f"{dimension.noun} of {written} is out of range", range_advice(dimension))
    return value


def nearest_double(exact: Fraction) -> float:
    """The double nearest to a number; infinite beyond all doubles."""
    try:
        return float(exact)
    except OverflowError:
        return inf if exact > 0 else -inf


def quantity_pattern(dimension: Dimension) -> str:
    """A regular expression for the quantities of a dimension, common to Python and ECMAScript."""
    units = "|".join(_any_spelling(unit) for unit in dimension.units)
    unit = rf"\s*(?:{units})" if units else ""
    if dimension.needs_unit:
        return rf"(?:{SIGNED}{unit}|{ZERO})"
    return SIGNED + (f"(?:{unit})?" if unit else "")


def _any_spelling(unit: str) -> str:
    for spelling, pattern in {
        "*": "[*·]",
        "2": r"(?:\^?2|²)",
        "3": r"(?:\^?3|³)",
        "deg": "(?:deg|°)",
        "um": "[uµμ]m",
    }.items():
        unit = unit.replace(spelling, pattern)
    return unit
