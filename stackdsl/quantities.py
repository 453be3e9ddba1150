"""Quantities and tolerances as people write them, read into SI.

Numbers stay exact fractions until the last step, so `13.5 mm` is the double nearest to 0.0135 and `0.3 m / 0.1 m` is 3.
Units are the few that scenarios need, defined for pint; an unknown one is a mistake, never a guess.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache, partial
from math import ceil, floor, inf
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Final, Self, TypeAlias

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    field_validator,
    model_validator,
)
from pydantic_core import CoreSchema, core_schema

from stackdsl.diagnostics import did_you_mean

if TYPE_CHECKING:
    from pint import UnitRegistry
    from pint.facets.plain import PlainQuantity

    Amount: TypeAlias = PlainQuantity[Fraction]  # in SI base units; an angle is a dimension of its own

JsonSchema: TypeAlias = dict[str, object]

# What pint is told, and nothing more: no prefixes, no long names.
UNITS: Final[Mapping[str, str]] = {
    **{"m": "[length]", "mm": "0.001 * m", "cm": "0.01 * m", "km": "1000 * m"},
    **{"s": "[time]", "ms": "0.001 * s", "min": "60 * s"},
    **{"kg": "[mass]", "g": "0.001 * kg"},
    # An angle is not a number here, so `sin(0.5)` and `tilt: 50 %` are mistakes that can be told.
    **{"rad": "[angle]", "deg": "3.14159265358979323846264338327950288 / 180 * rad"},
    **{"N": "kg * m / s**2", "J": "N * m", "g0": "9.80665 * m / s**2", "percent": "0.01"},
}
_SPELLINGS = str.maketrans({"²": "2", "³": "3", "^": "", "·": "*", "°": "deg", "%": "percent"})

# Digits are bounded: reading a number of a million digits takes minutes.
NUMBER: Final = r"(?:\d{1,20}(?:\.\d{1,20})?|\.\d{1,20})(?:[eE][+-]?\d{1,3})?"
_NAMES = "|".join(sorted([*UNITS, "%", "°"], key=len, reverse=True))
_FACTOR = rf"(?:{_NAMES})(?:\^?[23]|[²³])?(?!\w)"
UNIT: Final = rf"{_FACTOR}(?:[*/·]{_FACTOR})*"
_SIGNED = rf"[+-]?{NUMBER}"
_QUANTITY = re.compile(rf"(?P<number>{_SIGNED})\s*(?P<unit>(?:[^\W\d_]|[%°])[^\s.<>=±]*)?")


class MistakeError(ValueError):
    """A mistake of the author in one value; a `ValueError`, so that pydantic carries it."""

    def __init__(self, code: str, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.code, self.message, self.hint = code, message, hint


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


# Beyond 10 km or a day there is a typo, which should not cost a day to find.
LENGTH: Final = Dimension("a length", ("mm", "cm", "m", "km"), "13.5 mm", -1e4, 1e4)
EXTENT: Final = replace(LENGTH, least=0.0)
DURATION: Final = Dimension("a duration", ("ms", "s", "min"), "1.5 s", 0.0, 86_400.0)
ANGLE: Final = Dimension("an angle", ("deg", "rad"), "30 deg", -100.0, 100.0)
DENSITY: Final = Dimension("a density", ("kg/m3", "g/cm3"), "557 kg/m3", 0.0, 1e6, positive=True)
MASS: Final = Dimension("a mass", ("g", "kg"), "11.9 g", 0.0, 1e9, positive=True)
ACCELERATION: Final = Dimension(
    "an acceleration", ("m/s2", "cm/s2", "mm/s2", "g0"), "9.81 m/s2", 0.0, 1e4, positive=True
)
COUNT: Final = Dimension("a count", (), "<= 2", 0, 10**9, needs_unit=False, whole=True)
LEVEL: Final = Dimension("a level", (), "level 9 ± 1", 1, 10**9, needs_unit=False, whole=True, prefix="level")
SHARE: Final = Dimension("a share", ("%",), "25 %", 0.0, 1.0, needs_unit=False)


# --- units ------------------------------------------------------------------------------------------------------------


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
    for operator, name, power in re.findall(r"([*/]?)([A-Za-z]+0?)([23]?)", unit.translate(_SPELLINGS)):
        factor = registry().Quantity(Fraction(1), name).to_base_units() ** int(power or 1)
        product = product / factor if operator == "/" else product * factor
    return product


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


def _text(written: object, dimension: Dimension) -> str:
    if isinstance(written, int | float) and not isinstance(written, bool):
        return repr(written)
    if isinstance(written, str):
        return written.strip()
    raise MistakeError("SD103", f"expected {dimension.noun}, not {shown(written)}", _advice(dimension))


def _advice(dimension: Dimension) -> str:
    unit = " with its unit" if dimension.needs_unit else ""
    return f"write {dimension.noun}{unit}, such as {dimension.example}"


def _exact(text: str, dimension: Dimension) -> Fraction:
    """A quantity in SI, exactly."""
    match = _QUANTITY.fullmatch(text)
    if match is None:
        raise MistakeError("SD103", f"expected {dimension.noun}, not {shown(text)}", _advice(dimension))
    unit = match["unit"] or ""
    if not unit and dimension.needs_unit:
        raise MistakeError("SD105", f"{shown(text)} lacks the unit of {dimension.noun}", _advice(dimension))
    if unit and unit.translate(_SPELLINGS) not in {known.translate(_SPELLINGS) for known in dimension.units}:
        hint = did_you_mean(unit, dimension.units) or _advice(dimension)
        raise MistakeError("SD106", f"'{unit}' is not a unit of {dimension.noun}", hint)
    return Fraction(match["number"]) * unit_amount(unit).magnitude


def parse_quantity(written: object, dimension: Dimension) -> float:
    """A quantity in SI (angles in rad), within the range of its dimension."""
    exact = _exact(_text(written, dimension), dimension)
    if dimension.positive and exact <= 0:
        raise MistakeError("SD104", f"{dimension.noun} of {written} is not more than zero", _advice(dimension))
    if not dimension.least <= exact <= dimension.most:
        raise MistakeError("SD104", f"{dimension.noun} of {written} is out of range", _advice(dimension))
    return float(exact)


# --- tolerances -------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Tolerance:
    """The values that satisfy an author, in SI."""

    low: float  # -inf if there is none
    high: float  # inf if there is none
    low_open: bool  # the bound itself does not hold
    high_open: bool
    text: str  # as written

    def holds(self, value: float) -> bool:
        """Whether the value lies inside."""
        above = self.low < value if self.low_open else self.low <= value
        return above and (value < self.high if self.high_open else value <= self.high)

    def margin(self, value: float) -> float:
        """Signed distance to the nearest bound, positive inside; 0 at a bound, also at an open one."""
        return min(value - self.low, self.high - value)


_ONE_SIDED = re.compile(r"(>=|<=|[<>≥≤])\s*(.+)")
_AROUND = re.compile(r"(.+?)\s*(?:±|\+/?-)\s*(.+)")
_BETWEEN = re.compile(r"(.+?)\s*\.\.\s*(.+)")


def parse_tolerance(written: object, dimension: Dimension) -> Tolerance:
    """A tolerance in SI: `9 ± 1`, `>= 20`, `5 s .. 7 s`, or an exact whole number."""
    text = _text(written, dimension)
    body = _after_prefix(text, dimension)
    low, high, is_open = _bounds(body, text, dimension)
    tolerance = Tolerance(float(low), float(high), is_open and low != -inf, is_open and high != inf, text)
    if low > high:
        raise _malformed(text, "has its bounds the wrong way round", "write the smaller number first")
    if low == high and not dimension.whole:
        raise _malformed(text, "leaves no room, and a measured value is never exact", "add ± and a width")
    if not _can_hold(tolerance, dimension):
        raise _malformed(text, f"can never hold for {dimension.noun}", _advice(dimension))
    return tolerance


def parse_lower_bound(written: object, dimension: Dimension) -> Tolerance:
    """A tolerance without an upper end."""
    tolerance = parse_tolerance(written, dimension)
    if tolerance.high != inf:
        raise _malformed(tolerance.text, "is not a lower bound", f"write > {dimension.example}")
    return tolerance


def _malformed(text: str, fault: str, hint: str) -> MistakeError:
    return MistakeError("SD107", f"the tolerance '{text}' {fault}", hint)


def _after_prefix(text: str, dimension: Dimension) -> str:
    head, _, rest = text.partition(" ")
    if not dimension.prefix:
        return text
    if head != dimension.prefix:
        raise MistakeError("SD105", f"'{text}' does not say '{dimension.prefix}'", _advice(dimension))
    return rest.strip()


def _bounds(body: str, text: str, dimension: Dimension) -> tuple[Fraction | float, Fraction | float, bool]:
    """Lower and upper bound, and whether they are open."""
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
    """Both numbers; a unit that is due and stands only at the end is for both."""
    first, last = match[1], match[2]
    unit = _QUANTITY.fullmatch(last)
    if dimension.needs_unit and unit and re.fullmatch(_SIGNED, first):
        first += unit["unit"] or ""
    return _part(first, text, dimension), _part(last, text, dimension)


def _part(part: str, text: str, dimension: Dimension) -> Fraction:
    try:
        return _exact(part, dimension)
    except MistakeError as mistake:
        if mistake.code != "SD103":
            raise
        raise _malformed(text, f"cannot be read at '{part}'", "write 9 ± 1, >= 20, or 5 .. 7") from mistake


def _can_hold(tolerance: Tolerance, dimension: Dimension) -> bool:
    low, high = max(tolerance.low, dimension.least), min(tolerance.high, dimension.most)
    if dimension.whole:
        first = floor(low) + 1 if tolerance.low_open and low == tolerance.low else ceil(low)
        last = ceil(high) - 1 if tolerance.high_open and high == tolerance.high else floor(high)
        return first <= last
    return low < high or (tolerance.holds(low) and low == high)


# --- what pydantic and editors need -----------------------------------------------------------------------------------


class AuthorModel(BaseModel):
    """A mapping that an author writes."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    @field_validator("*", mode="before")
    @classmethod
    def _reject_nothing(cls, written: object) -> object:
        if written is None:
            raise MistakeError("SD103", "there is no value", "write one, or remove the key")
        return written


class Choice(AuthorModel):
    """A mapping that needs exactly one of several keys."""

    one_of: ClassVar[tuple[str, ...]]

    @model_validator(mode="after")
    def _choose(self) -> Self:
        written = [key for key in self.one_of if getattr(self, key) is not None]
        if len(written) == 1:
            return self
        message = f"exactly one of {', '.join(self.one_of)} is needed, not {' and '.join(written) or 'none'}"
        raise MistakeError("SD108", message, "keep one of them" if written else "write one of them")

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchema:
        schema = handler(core)
        handler.resolve_ref_schema(schema)["oneOf"] = [{"required": [key]} for key in cls.one_of]
        return schema


def default(written: object, description: str) -> Any:  # noqa: ANN401 -- as `Field`, it stands for a value of any type
    """A key that may be absent, with its default as an author would write it, so that editors show it so."""
    return Field(default=written, validate_default=True, description=description)


@dataclass(frozen=True, eq=False)  # compared as what it is, for `schema` cannot be hashed
class Reads:
    """Tells pydantic which function reads a value, and editors how it is written."""

    read: Callable[[object], object]
    schema: JsonSchema

    def __get_pydantic_core_schema__(self, _source: object, _handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, _core: CoreSchema, _handler: GetJsonSchemaHandler) -> JsonSchema:
        return dict(self.schema)


EXPRESSION_PATTERN: Final = r"\$\{"


def text_schema(pattern: str, description: str, example: str) -> JsonSchema:
    """Text of one form, or an expression."""
    whole = rf"^\s*(?:{pattern})\s*$|{EXPRESSION_PATTERN}"
    return {"type": "string", "pattern": whole, "description": description, "examples": [example]}


def quantity_pattern(dimension: Dimension) -> str:
    """A regular expression for the quantities of a dimension, common to Python and ECMAScript."""
    units = "|".join(_any_spelling(unit) for unit in dimension.units)
    unit = rf"\s*(?:{units})" if units else ""
    return _SIGNED + (f"(?:{unit})?" if unit and not dimension.needs_unit else unit)


def _any_spelling(unit: str) -> str:
    for spelling, pattern in {"2": r"(?:\^?2|²)", "3": r"(?:\^?3|³)", "deg": "(?:deg|°)"}.items():
        unit = unit.replace(spelling, pattern)
    return unit


def _quantity(dimension: Dimension) -> Reads:
    schema = text_schema(quantity_pattern(dimension), f"{dimension.noun} with its unit", dimension.example)
    return Reads(partial(parse_quantity, dimension=dimension), _or_number(schema, dimension))


def _tolerance(dimension: Dimension, example: str, parse: Callable[..., Tolerance] = parse_tolerance) -> Reads:
    quantity = quantity_pattern(dimension)
    pair = rf"{quantity if dimension.units else _SIGNED}|{_SIGNED}"
    forms = [rf"(?:[<>]=?|[≤≥])\s*{quantity}", rf"(?:{pair})\s*(?:±|\+/?-|\.\.)\s*{quantity}"]
    prefix = rf"{dimension.prefix}\s+" if dimension.prefix else ""
    pattern = rf"{prefix}(?:{'|'.join([*forms, *([_SIGNED] if dimension.whole else [])])})"
    schema = text_schema(pattern, f"{dimension.noun} within a tolerance", example)
    return Reads(partial(parse, dimension=dimension), _or_number(schema, dimension) if dimension is COUNT else schema)


def _or_number(schema: JsonSchema, dimension: Dimension) -> JsonSchema:
    if dimension.needs_unit:
        return schema
    number = {"type": "integer" if dimension.whole else "number", "minimum": dimension.least, "maximum": dimension.most}
    return {"anyOf": [number, schema]}


Length = Annotated[float, _quantity(LENGTH)]  # [m], either sign
NonNegativeLength = Annotated[float, _quantity(EXTENT)]  # [m]
PositiveLength = Annotated[float, _quantity(replace(EXTENT, positive=True))]  # [m]
Duration = Annotated[float, _quantity(DURATION)]  # [s]
PositiveDuration = Annotated[float, _quantity(replace(DURATION, positive=True))]  # [s]
Angle = Annotated[float, _quantity(ANGLE)]  # [rad]
Slope = Annotated[float, _quantity(replace(ANGLE, least=0.0, most=1.5))]  # [rad], less than upright
Density = Annotated[float, _quantity(DENSITY)]  # [kg/m3]
Mass = Annotated[float, _quantity(MASS)]  # [kg]
Acceleration = Annotated[float, _quantity(ACCELERATION)]  # [m/s2]
Friction = Annotated[float, Field(strict=True, ge=0, le=10, allow_inf_nan=False)]  # Coulomb coefficient

LengthTolerance = Annotated[Tolerance, _tolerance(EXTENT, "200 mm ± 1 mm")]
LengthLowerBound = Annotated[Tolerance, _tolerance(EXTENT, "> 5 mm", parse_lower_bound)]
DurationTolerance = Annotated[Tolerance, _tolerance(DURATION, "5 s .. 7 s")]
CountTolerance = Annotated[Tolerance, _tolerance(COUNT, "<= 2")]
LevelTolerance = Annotated[Tolerance, _tolerance(LEVEL, "level 9 ± 1")]
ShareTolerance = Annotated[Tolerance, _tolerance(SHARE, "0.25 ± 0.02")]
