"""Types of values in YAML: quantities, tolerances, names, systems, references to bricks."""

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Annotated, Final, Literal, TypeAlias, get_args

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    WithJsonSchema,
)
from pydantic_core import CoreSchema, core_schema

from stability.model import GROUND, BodyId
from stackdsl.language.quantities import (
    ACCELERATION,
    ANGLE,
    COEFFICIENT,
    COUNT,
    DENSITY,
    DURATION,
    EXTENT,
    FORCE,
    FREQUENCY,
    IMPULSE,
    LENGTH,
    LEVEL,
    LOAD_FACTOR,
    LONG_DURATION,
    MASS,
    PARTS_OF_G,
    SHARE,
    SIDE,
    SIGNED,
    SLOPE,
    SPEED,
    STRENGTH,
    Dimension,
    InputError,
    as_text,
    exact_quantity,
    parse_quantity,
    quantity_pattern,
    shown,
)
from stackdsl.language.tolerances import MassTolerance, Tolerance, parse_lower_bound, parse_share, parse_tolerance
from stackdsl.language.yaml.source import KeyPath

# References to bricks in claims and impacts: values whose type carries a `NamesBody` marker.


def _itself(value: object) -> BodyId | None:
    return value if isinstance(value, str) else None


@dataclass(frozen=True, slots=True)
class NamesBody:
    """Marks a type whose values name a brick, as `Annotated[..., NamesBody()]`."""

    or_plane: bool = False  # the ground and walls are allowed, too
    read: Callable[[object], BodyId | None] = _itself  # returns the name in a value, or None


@dataclass(frozen=True, slots=True)
class NameReference:
    """A name of a body and its path in the file."""

    path: KeyPath
    name: BodyId
    or_plane: bool  # the ground and walls are allowed, too


def named_in(model: BaseModel, path: KeyPath = ()) -> Iterator[NameReference]:
    """Yield the names in the mapping at a path, in the order of its keys."""
    markers = _markers(type(model))
    for key, field in type(model).model_fields.items():
        value, place = getattr(model, key), (*path, field.alias or key)
        if isinstance(value, BaseModel):
            yield from named_in(value, place)
        elif key in markers and isinstance(value, tuple):
            yield from (name for index, item in enumerate(value) for name in _name(item, markers[key], (*place, index)))
        elif key in markers:
            yield from _name(value, markers[key], place)


def _name(value: object, marker: NamesBody, path: KeyPath) -> Iterator[NameReference]:
    name = marker.read(value)
    if name is not None:
        yield NameReference(path, name, marker.or_plane)


@cache
def _markers(model: type[BaseModel]) -> Mapping[str, NamesBody]:
    markers = {key: _marker_in((*field.metadata, field.annotation)) for key, field in model.model_fields.items()}
    return {key: marker for key, marker in markers.items() if marker is not None}


def _marker_in(parts: tuple[object, ...]) -> NamesBody | None:
    for part in parts:
        marker = part if isinstance(part, NamesBody) else _marker_in(get_args(part))
        if marker is not None:
            return marker
    return None


# Types of values: quantities, tolerances, names, and systems.
#
# Each type has a parser for pydantic and a JSON schema for editors.


JsonSchema: TypeAlias = dict[str, object]
EXPRESSION_PATTERN: Final = r"\$\{"
# A range or a distribution in place of a value, read by `distributions`.
DISTRIBUTION_PATTERN: Final = r"±|\+/?-|\.\.|^\s*(?:uniform|normal|lognormal|table)\s"


@dataclass(frozen=True, eq=False)  # compared by identity, since `schema` cannot be hashed
class Reads:
    """Gives a type a parser for pydantic and a JSON schema for editors."""

    read: Callable[[object], object]
    schema: JsonSchema

    def __get_pydantic_core_schema__(self, _source: object, _handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, _core: CoreSchema, _handler: GetJsonSchemaHandler) -> JsonSchema:
        return dict(self.schema)


def text_schema(pattern: str, description: str, example: str) -> JsonSchema:
    """Return the schema of text that matches a pattern or holds an expression."""
    whole = rf"^\s*(?:{pattern})\s*$|{EXPRESSION_PATTERN}"
    return {"type": "string", "pattern": whole, "description": description, "examples": [example]}


# --- quantities and tolerances ----------------------------------------------------------------------------------------


def quantity(dimension: Dimension) -> Reads:
    """Return parser and schema of quantities of a dimension."""
    noun = f"{dimension.noun} with its unit" if dimension.needs_unit else dimension.noun
    schema = text_schema(quantity_pattern(dimension), noun, dimension.example)
    schema["pattern"] = f"{schema['pattern']}|{DISTRIBUTION_PATTERN}"
    return Reads(partial(parse_quantity, dimension=dimension), _or_number(schema, dimension))


def _tolerance(
    dimension: Dimension, example: str, parse: Callable[..., Tolerance] = parse_tolerance, *, alone: bool = False
) -> Reads:
    quantity = quantity_pattern(dimension)
    pair = rf"{quantity if dimension.units else SIGNED}|{SIGNED}"
    forms = [rf"(?:[<>]=?|[≤≥])\s*{quantity}", rf"(?:{pair})\s*(?:±|\+/?-|\.\.)\s*{quantity}"]
    prefix = rf"{dimension.prefix}\s+" if dimension.prefix else ""
    pattern = rf"{prefix}(?:{'|'.join([*forms, *([SIGNED] if dimension.whole else [quantity] if alone else [])])})"
    schema = text_schema(pattern, f"{dimension.noun} within a tolerance", example)
    return Reads(partial(parse, dimension=dimension), _or_number(schema, dimension) if dimension is COUNT else schema)


def _or_number(schema: JsonSchema, dimension: Dimension) -> JsonSchema:
    if dimension.needs_unit:
        # Only 0 needs no unit; `errorMessage` is shown by editors for other numbers.
        bare = {"const": 0, "errorMessage": f"write {schema['description']}"}
        return schema if dimension.positive else {"anyOf": [bare, schema]}
    number = {"type": "integer" if dimension.whole else "number", "minimum": dimension.least, "maximum": dimension.most}
    return {"anyOf": [number, schema]}


Length = Annotated[float, quantity(LENGTH)]  # [m], either sign
NonNegativeLength = Annotated[float, quantity(EXTENT)]  # [m]
PositiveLength = Annotated[float, quantity(replace(EXTENT, positive=True))]  # [m]
Side = Annotated[float, quantity(SIDE)]  # [m] of a brick
Duration = Annotated[float, quantity(DURATION)]  # [s]
PositiveDuration = Annotated[float, quantity(replace(DURATION, positive=True))]  # [s]
TimeOfStep = Annotated[float, quantity(LONG_DURATION)]  # [s]
LongInterval = Annotated[float, quantity(replace(LONG_DURATION, positive=True))]  # [s]
Angle = Annotated[float, quantity(ANGLE)]  # [rad]
Slope = Annotated[float, quantity(SLOPE)]  # [rad], level to upright
Density = Annotated[float, quantity(DENSITY)]  # [kg/m3]
Mass = Annotated[float, quantity(MASS)]  # [kg]
Acceleration = Annotated[float, quantity(ACCELERATION)]  # [m/s2]
Speed = Annotated[float, quantity(SPEED)]  # [m/s]
Impulse = Annotated[float, quantity(IMPULSE)]  # [N s], either sign
Force = Annotated[float, quantity(FORCE)]  # [N]
Strength = Annotated[float, quantity(STRENGTH)]  # [Pa]
STEEPEST_TABLE: Final = 1.4  # [rad] of a tilting table; about 80 deg
MOST_SHAKEN: Final = 1e3  # [m/s2] a hundred times gravity: more is a typo
FASTEST_SHAKEN: Final = 100.0  # [Hz] the time steps of the engines do not resolve faster shaking
ShakeFrequency = Annotated[float, quantity(replace(FREQUENCY, most=FASTEST_SHAKEN, positive=True))]  # [Hz]
ShakeAcceleration = Annotated[float, quantity(replace(ACCELERATION, most=MOST_SHAKEN))]  # [m/s2]
# [m/s2], either way
SignedAcceleration = Annotated[
    float, quantity(replace(ACCELERATION, least=-MOST_SHAKEN, most=MOST_SHAKEN, positive=False))
]
PartOfG = Annotated[float, quantity(replace(PARTS_OF_G, example="0.5 g", most=2.0, positive=True))]  # [g]
TableSlope = Annotated[float, quantity(replace(SLOPE, most=STEEPEST_TABLE, positive=True))]  # [rad]
ScaleFactor = Annotated[float, quantity(replace(LOAD_FACTOR, noun="a factor", example="1.5", most=1e3, positive=True))]
Friction = Annotated[float, Field(strict=True, ge=0, le=10, allow_inf_nan=False)]  # Coulomb coefficient
ShareOfLimit = Annotated[float, quantity(replace(SHARE, most=2.0))]  # may go beyond the limit

LengthTolerance = Annotated[Tolerance, _tolerance(EXTENT, "200 mm ± 1 mm")]
LengthLowerBound = Annotated[Tolerance, _tolerance(EXTENT, "> 5 mm", parse_lower_bound)]
FrequencyTolerance = Annotated[Tolerance, _tolerance(FREQUENCY, ">= 2 Hz")]
DurationTolerance = Annotated[Tolerance, _tolerance(DURATION, "5 s .. 7 s")]
CountTolerance = Annotated[Tolerance, _tolerance(COUNT, "<= 2")]
LevelTolerance = Annotated[Tolerance, _tolerance(LEVEL, "level 9 ± 1")]
SlopeTolerance = Annotated[Tolerance, _tolerance(SLOPE, ">= 3 deg")]
GravityTolerance = Annotated[Tolerance, _tolerance(PARTS_OF_G, ">= 0.05")]
LoadFactorTolerance = Annotated[Tolerance, _tolerance(LOAD_FACTOR, ">= 1.5")]
UsedStrengthTolerance = Annotated[
    Tolerance, _tolerance(replace(SHARE, noun="a share of the strength", example="<= 80 %"), "<= 80 %")
]
FrictionTolerance = Annotated[Tolerance, _tolerance(COEFFICIENT, "<= 0.2")]
ShareOfSamples = Annotated[Tolerance, _tolerance(SHARE, ">= 95 %", parse_share, alone=True)]
Confidence = Annotated[float, quantity(replace(SHARE, least=0.5, most=0.999999))]
ShareTolerance = Annotated[Tolerance, _tolerance(SHARE, "0.25 ± 0.02")]
PressureTolerance = Annotated[
    Tolerance, _tolerance(replace(STRENGTH, noun="a pressure", example="20 kPa"), "<= 20 kPa")
]


class Weighed(float):
    """A mass [kg] or a density [kg/m3], whose weight depends on the gravity of the scene."""


def read_weighed(written: object, mass: Dimension, force: Dimension, noun: str) -> float:
    """Read a weight as a force, or as a mass; or both per volume."""
    text = as_text(written, force)
    if re.search(r"(?<![A-Za-z])k?g(/c?m\^?[3³])?$", text):
        return Weighed(parse_quantity(written, mass))
    try:
        exact_quantity(text, force)
    except InputError as error:
        hint = f"write {mass.noun} such as {mass.example}, or {force.noun} such as {force.example}"
        raise InputError(error.code, error.message.replace(force.noun, noun), hint) from error
    return parse_quantity(written, force)


def _read_weight_tolerance(written: object) -> Tolerance:
    """Read a tolerance of a weight: of a mass [kg], or of a force [N]."""
    if isinstance(written, str) and re.search(r"[0-9.\s]k?g\s*$", written):
        found = parse_tolerance(written, replace(MASS, positive=False))
        return MassTolerance(found.low, found.high, found.low_open, found.high_open, found.text)
    try:
        return parse_tolerance(written, FORCE)
    except InputError as error:
        message = error.message.replace("a force", "a weight")
        hint = error.hint.replace("choose from: ", "choose from: kg, g, ").replace("2 N", "20 kg")
        raise InputError(error.code, message, hint) from error


_WEIGHT: Final = rf"(?:{quantity_pattern(MASS)}|{quantity_pattern(FORCE)}|{SIGNED})"
WeightTolerance = Annotated[
    Tolerance,
    Reads(
        _read_weight_tolerance,
        text_schema(
            rf"(?:[<>]=?|[≤≥])\s*{_WEIGHT}|{_WEIGHT}\s*(?:±|\+/?-|\.\.)\s*{_WEIGHT}",
            "a weight within a tolerance, as a mass or a force",
            "<= 20 kg",
        ),
    ),
]


# --- which gaps count as contact --------------------------------------------------------------------------------------

_TOUCHING_ADVICE = "write `exactly`, or the largest gap that counts as contact, such as `within 0.1 mm`"


def read_touching(written: object) -> float:
    """Read the widest gap that counts as contact in statics [m]: 0 for `exactly`, or `within 0.1 mm`."""
    if not isinstance(written, str):
        raise InputError("SD103", f"{shown(written)} is not a limit for contact gaps", _TOUCHING_ADVICE)
    if written.strip() == "exactly":
        return 0.0
    match = re.fullmatch(r"\s*within\s+(\S.*?)\s*", written)
    if match is None:
        raise InputError("SD104", f"{shown(written)} is not a limit for contact gaps", _TOUCHING_ADVICE)
    return parse_quantity(match[1], replace(EXTENT, positive=True))


_TOUCHING_PATTERN = rf"exactly|within\s+{quantity_pattern(EXTENT)}"
Touching = Annotated[
    float, Reads(read_touching, text_schema(_TOUCHING_PATTERN, "largest gap that counts as contact", "within 0.1 mm"))
]

# --- counts -----------------------------------------------------------------------------------------------------------

MAX_LEVELS: Final = 10_000  # more is a typo: the tallest plank towers have a few hundred levels
MAX_BRICKS: Final = 20_000  # in one step of `build`; some seconds of computing
MAX_STONES: Final = 200  # of one arch: each is a separate solid, and thin wedges are all near each other

Flag = Annotated[bool, Field(strict=True)]
MAX_SAMPLES: Final = 10_000_000  # an hour for a tower of 100 planks
Samples = Annotated[int, Field(strict=True, ge=1, le=MAX_SAMPLES)]
Seed = Annotated[int, Field(strict=True, ge=0, lt=2**63)]
Levels = Annotated[int, Field(strict=True, ge=1, le=MAX_LEVELS)]


# --- names ------------------------------------------------------------------------------------------------------------

_SLUG = r"[a-z0-9][a-z0-9-]{0,63}"
NAME: Final = r"[A-Za-z][A-Za-z0-9_.-]{0,63}"


def _read_text(written: object, pattern: str, noun: str, advice: str) -> str:
    if not isinstance(written, str):
        quoted = f'write "{written}": ' if re.fullmatch(pattern, str(written)) else ""
        raise InputError("SD103", f"expected {noun}, not {shown(written)}", quoted + advice)
    if not re.fullmatch(pattern, written):
        stem = re.sub(r".*/|\.ya?ml$", "", written.lower())  # of a path
        near = re.sub(r"[^a-z0-9]+", "-", stem).strip("-")
        example = f"write {near}: " if near != written and re.fullmatch(pattern, near) else ""
        raise InputError("SD104", f"{shown(written)} is not {noun}", example + advice)
    return written


def _text(pattern: str, noun: str, advice: str, example: str) -> Reads:
    read = partial(_read_text, pattern=pattern, noun=noun, advice=advice)
    return Reads(read, text_schema(pattern, noun, example))


_NAME_ADVICE = "begin with a letter, then use letters, digits, _ . or -"
_SLUG_ADVICE = "use lower-case letters, digits and -, at most 64 characters"
Slug = Annotated[str, _text(_SLUG, "a valid name", _SLUG_ADVICE, "slant-tower")]
BodyName = Annotated[str, _text(NAME, "the name of a brick", _NAME_ADVICE, "L3.2"), NamesBody()]
PlaceName = Annotated[
    str,
    _text(r"L[1-9][0-9]{0,5}\.[1-9][0-9]{0,5}", "the level and place of a brick", "write, for example, L2.3", "L2.3"),
]
BodyNames = Annotated[tuple[BodyName, ...], Field(min_length=1, max_length=MAX_BRICKS)]
BodyOrPlaneName = Annotated[str, _text(NAME, "the name of a brick", _NAME_ADVICE, "L3.2"), NamesBody(or_plane=True)]
_UPHOLDS = _text(rf"(?!wall[0-9]+$){NAME}", "the name of a brick, or `ground`", _NAME_ADVICE, "beam")
Supports = Annotated[
    tuple[Annotated[str, _UPHOLDS, NamesBody(or_plane=True)], ...], Field(min_length=1, max_length=1000)
]
SUPPORTS: Final[JsonSchema] = {
    "anyOf": [_UPHOLDS.schema, {"type": "array", "items": _UPHOLDS.schema, "minItems": 1}],
}
_FIXED = rf"(?:{GROUND}|wall[0-9]+)"


def _not_fixed(name: str) -> str:
    if re.fullmatch(_FIXED, name):
        owner = "the ground" if name == GROUND else "a wall"
        message = f"'{name}' cannot be the name of a brick, since it is the name of {owner}"
        raise InputError("SD104", message, "use another name")
    return name


BrickName = Annotated[
    str,
    replace(
        _text(NAME, "a valid name of a brick", _NAME_ADVICE, "keystone"),
        schema=text_schema(rf"(?!{_FIXED}$){NAME}", "a valid name of a brick", "keystone"),
    ),
    AfterValidator(_not_fixed),
]
JOINED_NAME: Final = _text(
    NAME, "the name of a kind of brick, a step, a brick, the ground or a wall", _NAME_ADVICE, "carton"
)
ONE_OR_MORE_JOINED: Final[JsonSchema] = {
    "anyOf": [JOINED_NAME.schema, {"type": "array", "items": JOINED_NAME.schema, "minItems": 1}]
}


def listed(written: object) -> object:
    """Wrap a single text in a list."""
    return [written] if isinstance(written, str) else written


MAX_JOINED: Final = 1000  # names in one item
JoinedName = Annotated[str, JOINED_NAME]
JoinedNames = Annotated[
    tuple[JoinedName, ...],
    Field(min_length=1, max_length=MAX_JOINED),
    BeforeValidator(listed),
    WithJsonSchema(ONE_OR_MORE_JOINED),
]
TYPE_NAME: Final = _text(NAME, "a valid name of a kind of brick", _NAME_ADVICE, "carton")
Text = Annotated[str, Field(min_length=1, max_length=2000)]


# --- variables --------------------------------------------------------------------------------------------------------

VALUE: Final[JsonSchema] = {"type": ["number", "string"]}  # a number, a quantity, or a word
VALUES: Final[JsonSchema] = {
    "anyOf": [
        {"type": "array", "items": VALUE, "minItems": 1},
        {"type": "string", "pattern": r"\.\.|\$\{", "description": "a range", "examples": ["5 mm .. 15 mm by 0.5 mm"]},
    ]
}


_EITHER_WAY: Final[JsonSchema] = {"type": "string", "pattern": r"±|\+/?-|\.\.", "examples": ["0.5 ± 0.05"]}
_IN_ONE_LINE: Final[JsonSchema] = {"type": "string", "pattern": DISTRIBUTION_PATTERN, "examples": ["0.5 ± 0.05"]}
_DISTRIBUTIONS: Final[dict[str, tuple[str, JsonSchema]]] = {
    "uniform": ("range of equally likely values", _EITHER_WAY),
    "normal": ("mean ± standard deviation", _EITHER_WAY),
    "lognormal": ("median of a lognormal distribution", VALUE),
    "dispersion": ("standard deviation of the logarithm, of a lognormal distribution", {"type": "number"}),
    "table": ("list of equally likely values", {"type": "array", "items": VALUE, "minItems": 1}),
    "least": ("lower limit of a normal or lognormal distribution", VALUE),
    "most": ("upper limit of a normal or lognormal distribution", VALUE),
}
SPREADS: Final[JsonSchema] = {
    "anyOf": [
        _IN_ONE_LINE,
        {
            "type": "object",
            "properties": {key: {**schema, "description": text} for key, (text, schema) in _DISTRIBUTIONS.items()},
            "additionalProperties": False,
        },
    ]
}


def variables_schema(values: JsonSchema) -> WithJsonSchema:
    """Return the schema of a mapping from variables to values."""
    return WithJsonSchema({"type": "object", "additionalProperties": values})


# Expanded by `repeats` before validation.
REPEAT = Annotated[object, variables_schema(VALUES)]

# --- files ------------------------------------------------------------------------------------------------------------

FILE: Final[JsonSchema] = {
    "type": "string",
    "description": "path of a file, relative to the folder of this file",
    "examples": ["base.yaml"],
}

# --- systems ----------------------------------------------------------------------------------------------------------

System: TypeAlias = Literal["exact", "thesis", "tuned", "stock", "modified"]
SYSTEMS: Final[tuple[System, ...]] = get_args(System)
PROVING: Final[tuple[System, ...]] = ("exact",)  # systems with proofs of statics


def _once(systems: tuple[System, ...]) -> tuple[System, ...]:
    if len(set(systems)) < len(systems):
        raise InputError("SD104", "the list contains a system twice", "write each system once")
    return systems


Systems = Annotated[tuple[System, ...], Field(min_length=1), AfterValidator(_once)]
_ONE_SYSTEM: Final[JsonSchema] = {"enum": list(SYSTEMS)}
ONE_OR_MORE_SYSTEMS: Final[JsonSchema] = {
    "anyOf": [_ONE_SYSTEM, {"type": "array", "items": _ONE_SYSTEM, "minItems": 1}]
}
