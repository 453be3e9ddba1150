"""Reads quantities with units into SI."""

import re
import unicodedata
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


# Mistakes in one value, raised by its parser, which does not know the place of the value in the file.


DECIMAL_COMMA: Final = re.compile(r"((?:[<>]=?\s*)?[-+]?\d{1,9}),(\d{1,9})(\s*[a-zA-Z%][^,]*)?")


class InputError(ValueError):
    """A mistake in one value. A `ValueError`, so that pydantic collects it.

    A hint that is slow to compute, such as a search for similar names, is computed only when the mistake is reported.
    """

    def __init__(self, code: str, message: str, hint: str | Callable[[], str] = "") -> None:
        super().__init__(message)
        self.code, self.message, self._hint = code, message, hint

    @property
    def hint(self) -> str:
        """Return the remedy."""
        return self._hint if isinstance(self._hint, str) else self._hint()


class ConsequentialError(ValueError):
    """A consequence of a mistake that is reported elsewhere; not reported itself."""


LONGEST_NUMBER: Final = 100  # [characters] of a text that may be meant as numbers; longer ones take long to match
THOUSANDS: Final = re.compile(r"[1-9][0-9]{0,2}(?:,[0-9]{3})+")


def number_remedy(written: object) -> str:
    """Return the remedy for a number with a decimal comma or with characters like those of ASCII; empty for others."""
    text = written.strip() if isinstance(written, str) and len(written) <= LONGEST_NUMBER else ""
    if THOUSANDS.fullmatch(text):
        return f"write {text.replace(',', '')}, without commas"
    if match := DECIMAL_COMMA.fullmatch(text):
        return f"replace the decimal comma by a point: {match[1]}.{match[2]}{match[3] or ''}"
    for character in text if any(map(str.isdigit, text)) else "":
        if (ascii_character := _in_ascii(character)) != character:
            name = f"U+{ord(character):04X} {unicodedata.name(character, '')}".rstrip()
            return f"write {''.join(map(_in_ascii, text))}; {name} is not the character {ascii_character}"
    return ""


def _in_ascii(character: str) -> str:
    """Return the ASCII character for a dash, a digit of another script, or a full-width character; others unchanged."""
    if character == "\N{MINUS SIGN}" or (unicodedata.category(character) == "Pd"):
        return "-"
    if character.isdecimal():
        return str(unicodedata.decimal(character))
    return unicodedata.normalize("NFKC", character) if "\uff01" <= character <= "\uff5e" else character


_RANGE: Final = re.compile(r"([-+]?[\d.]*\d.*?)\s*(?:\.{3}|[-:…\u2010-\u2015\u2212]|\bto\b)\s*([-+]?[\d.]*\d.*)")


def range_remedy(text: str) -> str:
    """Return the remedy for a range written with another sign, such as `1-3`; empty for other texts."""
    match = _RANGE.fullmatch(text.strip()) if len(text) <= LONGEST_NUMBER else None
    parts = [QUANTITY.fullmatch(part) for part in match.groups()] if match else [None]
    return f"write {match[1]} .. {match[2]}" if match and all(parts) else ""


_PART: Final = r"([-+]?[\d.]+)\s*([^\W\d]*?)"
_TRIPLE: Final = re.compile(r"\s*[x×*,;\s]\s*".join([_PART, _PART, r"([-+]?[\d.]+)\s*([^\W\d]+)"]))


def triple(text: str) -> str:
    """Return three quantities in one text, such as `117 x 23 x 8 mm`, as a list in YAML; empty for other texts."""
    if len(text) > LONGEST_NUMBER or (match := _TRIPLE.fullmatch(text.strip())) is None:
        return ""
    x, x_unit, y, y_unit, z, unit = match.groups()
    return f"[{x} {x_unit or unit}, {y} {y_unit or unit}, {z} {unit}]"


def shown(written: object) -> str:
    """Format a value for a message."""
    match written:
        case None:
            return "nothing"
        case bool():
            return str(written).lower()
        case str():
            return f"'{written}'" if len(written) <= 40 else f"'{written[:39]}…'"  # noqa: PLR2004 -- fits a line
        case dict():
            return "a mapping"
        case list() | tuple():
            return "a list"
    return repr(written)


# Quantities with units, read into SI.
#
# Numbers stay exact fractions until the last step, so `13.5 mm` is the double nearest to 0.0135 and `0.3 m / 0.1 m` is
# 3. Only the units that scenarios need are defined for pint; an unknown unit is a mistake and never guessed.


if TYPE_CHECKING:
    Amount: TypeAlias = PlainQuantity[Fraction]  # in SI base units; an angle is a dimension of its own

REMEMBERED: Final = 10_000  # parsed texts in a cache: long scenarios repeat the same ones

# All definitions that pint gets: no prefixes, no long names.
UNITS: Final[Mapping[str, str]] = {
    **{"m": "[length]", "mm": "0.001 * m", "cm": "0.01 * m", "km": "1000 * m", "um": "0.000001 * m"},
    **{"s": "[time]", "ms": "0.001 * s", "min": "60 * s", "h": "3600 * s", "d": "86400 * s", "Hz": "1 / s"},
    **{"kg": "[mass]", "g": "0.001 * kg"},
    # An angle has its own dimension here, so that `sin(0.5)` and `tilt: 50 %` are reported as mistakes.
    **{"rad": "[angle]", "deg": "3.14159265358979323846264338327950288 / 180 * rad"},
    **{"N": "kg * m / s**2", "mN": "0.001 * N", "J": "N * m", "g0": "9.80665 * m / s**2", "percent": "0.01"},
    **{"kN": "1000 * N", "daN": "10 * N", "Pa": "N / m**2", "kPa": "1000 * Pa", "MPa": "1000000 * Pa"},
}
# Units that may also be names of variables; in expressions a unit follows a number.
ALSO_VARIABLES: Final = frozenset({"h", "d"})
# The factor from each unit to SI. A test compares it with pint, whose import takes longer than most checks.
_IN_SI: Final[Mapping[str, Fraction]] = {
    **{
        "m": Fraction(1),
        "mm": Fraction(1, 1000),
        "cm": Fraction(1, 100),
        "km": Fraction(1000),
        "um": Fraction(1, 10**6),
    },
    **{"s": Fraction(1), "ms": Fraction(1, 1000), "min": Fraction(60), "h": Fraction(3600), "d": Fraction(86400)},
    "Hz": Fraction(1),
    **{"kg": Fraction(1), "g": Fraction(1, 1000)},
    **{"rad": Fraction(1), "deg": Fraction("3.14159265358979323846264338327950288") / 180},
    **{"Pa": Fraction(1), "kPa": Fraction(1000), "MPa": Fraction(10**6), "kN": Fraction(1000), "daN": Fraction(10)},
    **{
        "N": Fraction(1),
        "mN": Fraction(1, 1000),
        "J": Fraction(1),
        "g0": Fraction("9.80665"),
        "percent": Fraction(1, 100),
    },
}
# The everyday unit in place of an SI unit, for amounts below a limit in SI.
_EVERYDAY: Final[Mapping[str, tuple[str, float]]] = {"m": ("mm", 1.0), "kg": ("g", 1.0), "rad": ("deg", inf)}
_SPELLINGS = str.maketrans(
    {"²": "2", "³": "3", "^": "", "·": "*", "°": "deg", "%": "percent", "µ": "u", "μ": "u"}
)  # both signs of micro

# The number of digits is bounded: reading a number of a million digits takes minutes. Digits are ASCII: Python also
# reads the digits of other scripts as numbers, but no other reader of YAML does.
NUMBER: Final = r"(?:[0-9]{1,20}(?:\.[0-9]{1,20})?|\.[0-9]{1,20})(?:[eE][+-]?[0-9]{1,3})?"
_NAMES = "|".join(sorted([*UNITS, "%", "°", "µm", "μm"], key=len, reverse=True))
_FACTOR = rf"(?:{_NAMES})(?:\^?[23]|[²³])?(?!\w)"
UNIT: Final = rf"{_FACTOR}(?:[*/·]{_FACTOR})*"
SIGNED: Final = rf"[+-]?{NUMBER}"
ZERO: Final = r"[+-]?0(?:\.0{1,20})?"  # needs no unit
QUANTITY: Final = re.compile(rf"(?P<number>{SIGNED})\s*(?P<unit>(?:[^\W\d_]|[%°])[^\s.<>=±]*)?")


@dataclass(frozen=True, slots=True)
class Dimension:
    """A kind of value: its units in YAML, and its range in SI."""

    noun: str
    units: tuple[str, ...]
    example: str
    least: float = -inf
    most: float = inf
    positive: bool = False  # zero is excluded
    needs_unit: bool = True
    whole: bool = False
    prefix: str = ""  # a word before the number
    own_unit: str = ""  # the unit of the number itself, which may be written
    gravities: bool = False  # `g` is standard gravity, as `g0`, and not the gram


def _degrees(angle: int) -> float:
    """Return the angle [rad] rounded up, so that the exact angle is within the limit."""
    return nextafter(radians(angle), inf)


# More than 10 km, a day of motion or a hundred turns is a typo, and would take a day to simulate.
LENGTH: Final = Dimension("a length", ("mm", "cm", "m", "km", "um"), "13.5 mm", -1e4, 1e4)
EXTENT: Final = replace(LENGTH, least=0.0)
SIDE: Final = replace(LENGTH, least=SHORTEST, positive=True)  # statics treats shorter sides as zero
DURATION: Final = Dimension("a duration", ("ms", "s", "min", "h", "d"), "1.5 s", 0.0, 86_400.0)
LONG_DURATION: Final = replace(DURATION, most=3650 * 86_400.0)  # between actions on a structure that is judged at rest
FREQUENCY: Final = Dimension("a frequency", ("Hz",), "5 Hz", 0.0, 1e6)
ANGLE: Final = Dimension("an angle", ("deg", "rad"), "30 deg", -_degrees(36_000), _degrees(36_000))
SLOPE: Final = replace(ANGLE, least=0.0, most=_degrees(90))
DENSITY: Final = Dimension("a density", ("kg/m3", "g/cm3"), "557 kg/m3", 0.0, 1e6, positive=True)
MASS: Final = Dimension("a mass", ("g", "kg"), "11.9 g", 0.0, 1e9, positive=True)
ACCELERATION: Final = Dimension(
    "an acceleration", ("m/s2", "cm/s2", "mm/s2", "g0"), "9.81 m/s2", 0.0, 1e4, positive=True, gravities=True
)
# At higher speeds thin bricks pass through each other in the engines.
SPEED: Final = Dimension("a speed", ("m/s", "cm/s", "mm/s"), "2 m/s", 0.0, 20.0, positive=True)
IMPULSE: Final = Dimension("an impulse", ("N*s", "mN*s", "kg*m/s", "g*m/s"), "0.01 N*s", -1e6, 1e6)
FORCE: Final = Dimension("a force", ("N", "kN", "daN", "mN", "kg*m/s2"), "2 N", 0.0, 1e9)
PRESSURE: Final = Dimension("a pressure", ("kPa", "Pa", "MPa", "N/m2", "kN/m2", "N/mm2", "kg/m/s2"), "1 kPa", -1e9, 1e9)
MOMENT: Final = Dimension("a moment", ("N*m", "kN*m", "N*mm", "mN*m", "kg*m2/s2"), "5 N*m", -1e9, 1e9)
UNIT_WEIGHT: Final = Dimension(
    "a weight per volume", ("kN/m3", "N/m3", "kg/m2/s2"), "10 kN/m3", 0.0, 1e9, positive=True
)
LINE_LOAD: Final = Dimension("a force per length", ("N/m", "kN/m", "N/mm", "kg/s2"), "2 kN/m", 0.0, 1e9)
STRENGTH: Final = Dimension("a strength", ("MPa", "kPa", "Pa", "N/mm2", "kg/m/s2"), "0.2 MPa", 0.0, 1e12)
COUNT: Final = Dimension("a count", (), "<= 2", 0, 10**9, needs_unit=False, whole=True)
LEVEL: Final = Dimension("a level", (), "level 9 ± 1", 1, 10**9, needs_unit=False, whole=True, prefix="level")
SHARE: Final = Dimension("a share", ("%",), "25 %", 0.0, 1.0, needs_unit=False)

PARTS_OF_G: Final = Dimension("an acceleration in g", (), ">= 0.05 g", 0.0, 1e3, needs_unit=False, own_unit="g")
LOAD_FACTOR: Final = Dimension("a load factor", (), ">= 1.5", 0.0, 1e9, needs_unit=False)
COEFFICIENT: Final = Dimension("a coefficient of friction", (), "<= 0.2", 0.0, 10.0, needs_unit=False)


@cache
def registry() -> "UnitRegistry[Fraction]":
    """Return pint's registry of the units of scenarios, made at the first use."""
    # Importing pint takes a quarter of a second, which `--help` or a broken file should not wait for.
    from pint import UnitRegistry  # noqa: PLC0415 -- see above

    units: UnitRegistry[Fraction] = UnitRegistry(None, non_int_type=Fraction)
    for name, meaning in UNITS.items():
        units.define(f"{name} = {meaning}")
    return units


@cache
def unit_amount(unit: str) -> "Amount":
    """Return one unit that matches `UNIT`, in SI base units; the number one for the empty text."""
    product: Amount = registry().Quantity(Fraction(1))
    for name, power in _factors(unit):
        product = product * registry().Quantity(Fraction(1), name).to_base_units() ** power
    return product


@cache
def in_si(unit: str) -> Fraction:
    """Return the factor to SI of a unit that matches `UNIT`; one for the empty text."""
    return prod((_IN_SI[name] ** power for name, power in _factors(unit)), start=Fraction(1))


def _factors(unit: str) -> Iterator[tuple[str, int]]:
    """Yield the factors of a compound unit, each with its power."""
    for operator, name, power in re.findall(r"([*/]?)([A-Za-z]+0?)([23]?)", unit.translate(_SPELLINGS)):
        yield name, int(power or 1) * (-1 if operator == "/" else 1)


def as_text(written: object, dimension: Dimension) -> str:
    """Return the written value as text; YAML may have read it as a number."""
    if isinstance(written, int | float) and not isinstance(written, bool):
        return repr(written)
    if isinstance(written, str):
        return written.strip()
    raise InputError("SD103", f"expected {dimension.noun}, not {shown(written)}", advice(dimension))


def advice(dimension: Dimension, number: str = "") -> str:
    """Return the remedy for a malformed quantity, or for a number without its unit."""
    unit = " with its unit" if dimension.needs_unit else ""
    example = _example(dimension, Fraction(number)) if number else dimension.example
    return f"write {dimension.noun}{unit}, such as {example}"


# Numbers below SMALL (1 for other units), and from LARGE on, are likely in SI: they are unusual in everyday units.
SMALL: Final = {"rad": 7.0, "Pa": 0.0}
LARGE: Final = {"Pa": 1000.0}


def _example(dimension: Dimension, number: Fraction) -> str:
    """Return a number with its likely unit; one in SI also in the everyday unit."""
    unit, si = dimension.example.split()[-1], si_unit(dimension)
    if unit == si or SMALL.get(si, 1.0) <= abs(number) < LARGE.get(si, inf):
        return f"{float(number):.15g} {unit}"
    return f"{float(number / in_si(unit)):.4g} {unit} for {float(number):.15g} {si}"


def range_advice(dimension: Dimension) -> str:
    """Return the remedy for a well-formed quantity that is out of range."""
    if dimension.whole:
        return f"write whole numbers; the minimum is {dimension.least}"
    unit = _everyday_unit(si_unit(dimension), dimension.most)
    least, most = (f"{bound / float(in_si(unit)):.10g}" for bound in (dimension.least, dimension.most))
    low = (
        "a value greater than zero, at most"
        if dimension.positive and not dimension.least
        else f"a value between {least} and"
    )
    return f"write {low} {most} {unit}".rstrip()


def si_unit(dimension: Dimension) -> str:
    """Return the SI unit of a dimension; empty for numbers."""
    return next((unit for unit in dimension.units if in_si(unit) == 1), "")


def quantity_text(magnitude: Fraction, unit: str, everyday: bool = True) -> str:
    """Format an amount of an SI unit as in YAML, in its everyday unit or in SI; it reads back to the same double."""
    chosen = _everyday_unit(unit, magnitude) if everyday else unit
    scale = Fraction(1) if chosen == unit else in_si(chosen)
    number = magnitude / scale
    decimal = f"{Decimal(number.numerator) / number.denominator:.20f}".rstrip("0").rstrip(".")
    if re.fullmatch(SIGNED, decimal) and float(Fraction(decimal) * scale) == float(magnitude):
        return f"{decimal} {chosen}"
    return f"{float(magnitude)!r} {unit}"


def _everyday_unit(unit: str, magnitude: Fraction | float) -> str:
    """Return the usual unit for an amount of an SI unit, such as mm for lengths below 1 m."""
    small, limit = _EVERYDAY.get(unit, (unit, 0.0))
    return small if abs(float(magnitude)) < limit else unit


# Units that are not read -> value in a unit that is, for remedies.
FOREIGN: Final[Mapping[str, tuple[float, str]]] = {
    **dict.fromkeys(("in", "inch", "inches"), (25.4, "mm")),
    **dict.fromkeys(("ft", "feet"), (0.3048, "m")),
    **dict.fromkeys(("sec", "secs", "second", "seconds"), (1, "s")),
    **dict.fromkeys(("hour", "hours"), (1, "h")),
    **dict.fromkeys(("day", "days"), (1, "d")),
    **dict.fromkeys(("degree", "degrees"), (1, "deg")),
    **dict.fromkeys(("g/cc", "g/ccm"), (1, "g/cm3")),
    "t": (1000, "kg"),
    "lb": (0.45359237, "kg"),
    "oz": (28.349523, "g"),
    "lbf": (4.4482216, "N"),
    **dict.fromkeys(("kgf", "kp"), (9.80665, "N")),
    "GPa": (1000, "MPa"),
    "psi": (6.8947573, "kPa"),
    "bar": (100, "kPa"),
    "N/m2": (1, "Pa"),
    "kN/m2": (1, "kPa"),
    "km/h": (1 / 3.6, "m/s"),
    "mph": (0.44704, "m/s"),
}


@lru_cache(maxsize=REMEMBERED)
def exact_quantity(text: str, dimension: Dimension) -> Fraction:
    """Read a quantity into SI, as an exact fraction."""
    match = QUANTITY.fullmatch(text)
    if match is None:
        raise InputError("SD103", f"expected {dimension.noun}, not {shown(text)}", advice(dimension))
    unit = match["unit"] or ""
    unit = "" if unit == dimension.own_unit else "g0" if dimension.gravities and unit == "g" else unit
    if not unit and dimension.needs_unit and Fraction(match["number"]) != 0:  # zero is the same in every unit
        hint = advice(dimension, match["number"])
        raise InputError("SD105", f"{shown(text)} has no unit; expected {dimension.noun}", hint)
    if unit and unit.translate(_SPELLINGS) not in _spelled(dimension):
        grams = "in expressions and variables, `g` is the gram; write `g0` for standard gravity"
        if dimension.gravities and unit == "kg":
            raise InputError("SD106", f"{shown(unit)} is not a unit of {dimension.noun}", grams)
        hint = did_you_mean(unit if unit.isalpha() else "", dimension.units) or advice(dimension)
        if (factor := FOREIGN.get(unit.translate(_SPELLINGS))) is not None and factor[1] in dimension.units:
            hint = f"write {float(match['number']) * factor[0]:.6g} {factor[1]}"
        raise InputError("SD106", f"{shown(unit)} is not a unit of {dimension.noun}", hint)
    return Fraction(match["number"]) * in_si(unit)


@cache
def _spelled(dimension: Dimension) -> frozenset[str]:
    """Return the units of a dimension in their normalised spelling."""
    return frozenset(unit.translate(_SPELLINGS) for unit in dimension.units)


def parse_quantity(written: object, dimension: Dimension) -> float:
    """Read a quantity into SI (angles in rad) and check the range of its dimension."""
    value = nearest_double(exact_quantity(as_text(written, dimension), dimension))
    if dimension.positive and value <= 0.0:
        raise InputError(
            "SD104", f"{dimension.noun} of {written} is not greater than zero", "write a value greater than zero"
        )
    # Compare doubles, since the limits are doubles: the exact 1e-9 is less than the double 1e-9.
    if not dimension.least <= value <= dimension.most:
        raise InputError("SD104", f"{dimension.noun} of {written} is out of range", range_advice(dimension))
    return value


def nearest_double(exact: Fraction) -> float:
    """Return the double nearest to a number; infinite if the number is out of range."""
    try:
        return float(exact)
    except OverflowError:
        return inf if exact > 0 else -inf


def quantity_pattern(dimension: Dimension) -> str:
    """Return a regular expression for the quantities of a dimension, valid in Python and ECMAScript."""
    units = "|".join(
        _any_spelling(unit)
        for unit in (*dimension.units, *filter(None, [dimension.own_unit, "g" * dimension.gravities]))
    )
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


def quantity_of(written: str) -> dict[str, float | str | None]:
    """Return a written value with its number, unit and SI value; these are None for a word."""
    match = QUANTITY.fullmatch(written.strip())
    if match is None:
        return {"written": written, "number": None, "unit": None, "si": None}
    number, unit = float(match["number"]), match["unit"] or ""
    factor = float(in_si(unit)) if unit else 1.0
    return {"written": written, "number": number, "unit": unit, "si": number * factor}


def number_or_word(written: str) -> float | str:
    """Return a written value in SI, or its word."""
    si = quantity_of(written)["si"]
    return si if isinstance(si, float) else written
