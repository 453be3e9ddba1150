"""Loads of a scenario: lasting forces, weights, pressures, wind, liquids, accelerations and moments on bricks."""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import Annotated, ClassVar, Final, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from stability.model import Vec3
from stackdsl.language import value_types as t
from stackdsl.language.model_base import AnchorText, Timed
from stackdsl.language.quantities import (
    ACCELERATION,
    ANGLE,
    DENSITY,
    DURATION,
    FORCE,
    LINE_LOAD,
    MASS,
    MOMENT,
    PRESSURE,
    SHARE,
    UNIT_WEIGHT,
    Dimension,
    InputError,
    parse_quantity,
    quantity_pattern,
    shown,
)
from stackdsl.language.records import SHARE as SHARE_COLUMN
from stackdsl.language.records import SHARES, Record, RecordFile

MAX_LOADS: Final = 1000

UP: Final[Vec3] = (0.0, 0.0, 1.0)
DOWN: Final[Vec3] = (0.0, 0.0, -1.0)
# Directions by word; all others are horizontal, given by a bearing.
WORDS: Final = {"down": DOWN, "up": UP}
FACES: Final = {"top": UP, "bottom": DOWN}

Direction = str | float  # a word, or a bearing [rad]


def _read_direction(written: object, words: tuple[str, str], noun: str) -> Direction:
    if isinstance(written, str) and written.strip() in words:
        return written.strip()
    hint = f"write {words[0]}, {words[1]}, or a horizontal bearing such as 90 deg, from +x towards +y"
    if isinstance(written, str) and re.fullmatch(r"[A-Za-z]+", written.strip()):
        raise InputError("SD104", f"{shown(written)} is not {noun}", hint)
    try:
        return parse_quantity(written, ANGLE)
    except InputError as error:
        raise InputError(error.code, error.message, hint) from error


def _direction(words: tuple[str, str], noun: str) -> t.Reads:
    pattern = rf"{words[0]}|{words[1]}|{quantity_pattern(ANGLE)}"
    return t.Reads(lambda written: _read_direction(written, words, noun), t.text_schema(pattern, noun, words[0]))


Towards = Annotated[Direction, _direction(("down", "up"), "a direction")]
FaceName = Annotated[Direction, _direction(("top", "bottom"), "a face")]


Row = tuple[float, float]


def in_order_of_time(rows: Sequence[Row]) -> Sequence[Row]:
    """Return the rows of a table over time. Raises InputError if times decrease, or are all the same."""
    for number, (before, after) in enumerate(pairwise(rows), start=2):
        if after[0] < before[0]:
            message = f"row {number} of the table is at {after[0]:g} s, but the row above is at {before[0]:g} s"
            raise InputError(
                "SD104", message, "sort the rows by time; two rows with the same time define a step change"
            )
    if rows[-1][0] == rows[0][0]:
        raise InputError("SD104", "all rows of the table have the same time", "add a row with a later time")
    return rows


MOST_ROWS: Final = 1000  # the structure is judged again at each
SHARE_OF_LOAD: Final = replace(SHARE, least=-1e3, most=1e3)
Table = Annotated[
    tuple[tuple[t.Duration, Annotated[float, t.quantity(SHARE_OF_LOAD)]], ...],
    Field(min_length=2, max_length=MOST_ROWS),
    AfterValidator(in_order_of_time),
]


@dataclass(frozen=True, slots=True)
class Growing:
    """An amount that grows or falls in proportion to the time."""

    first: float
    last: float
    over: float  # [s]


Amount = float | Growing
_GROWING: Final = re.compile(r"from\s+(\S.*?)\s+to\s+(\S.*?)\s+over\s+(\S.*)")


def _read_amount(written: object, read: Callable[[object], float]) -> Amount:
    """Read a constant amount, or one that grows, such as `from 0 N to 50 N over 10 s`."""
    match = _GROWING.fullmatch(written.strip()) if isinstance(written, str) else None
    if match is None:
        return read(written)
    over = parse_quantity(match[3], replace(DURATION, positive=True))
    return Growing(read(match[1]), read(match[2]), over)


def _amount(dimension: Dimension) -> t.Reads:
    """Return parser and schema of an amount that may grow."""
    return _growing(partial(parse_quantity, dimension=dimension), quantity_pattern(dimension), dimension)


def _growing(read: Callable[[object], float], pattern: str, dimension: Dimension) -> t.Reads:
    grows = rf"from\s+{pattern}\s+to\s+{pattern}\s+over\s+{quantity_pattern(DURATION)}"
    schema = t.text_schema(rf"{pattern}|{grows}", f"{dimension.noun} with its unit", dimension.example)
    schema["pattern"] = f"{schema['pattern']}|{t.DISTRIBUTION_PATTERN}"
    return t.Reads(partial(_read_amount, read=read), {"anyOf": [{"const": 0}, schema]})


def _weighed(mass: Dimension, force: Dimension, noun: str) -> t.Reads:
    read = partial(t.read_weighed, mass=mass, force=force, noun=noun)
    return _growing(read, rf"(?:{quantity_pattern(mass)}|{quantity_pattern(force)})", mass)


Place = tuple[t.Length, t.Length, t.Length]


class Load(Timed):
    """A load that lasts, on bricks of the structure."""

    at: t.Duration | None = Field(
        None, description="time at which the load begins; default: when the structure is complete"
    )
    after: AnchorText | None = Field(None, description="event after which the load begins")

    force: Annotated[Amount, _amount(FORCE)] | None = Field(None, description="force in the direction of `towards`")
    weight: Annotated[Amount, _weighed(MASS, FORCE, "a weight")] | None = Field(
        None, description="weight that lies on the brick: a mass, or a force downwards"
    )
    pressure: Annotated[Amount, _amount(PRESSURE)] | None = Field(
        None, description="pressure on the whole of `face`; negative for suction"
    )
    wind: Annotated[Amount, _amount(PRESSURE)] | None = Field(
        None, description="pressure on the area that the wind sees, in the direction of `towards`"
    )
    fluid: Annotated[Amount, _weighed(DENSITY, UNIT_WEIGHT, "a weight per volume")] | None = Field(
        None,
        description="weight per volume of a liquid at `face`, or of soil times its coefficient of earth pressure; "
        "the pressure grows with the depth below `surface`",
    )
    acceleration: Annotated[Amount, _amount(ACCELERATION)] | None = Field(
        None, description="acceleration that acts on the mass of each brick in the direction of `towards`"
    )
    moment: Annotated[Amount, _amount(MOMENT)] | None = Field(
        None, description="moment about an axis in the direction of `about`, by the right-hand rule"
    )
    line: Annotated[Amount, _amount(LINE_LOAD)] | None = Field(
        None, description="force per length in the direction of `towards`, between the points `from` and `to`"
    )

    brick: t.BodyName | None = Field(None, description="name of the loaded brick")
    bricks: t.BodyNames | None = Field(
        None, description="names of loaded bricks, which share a force, a weight or a moment equally"
    )
    level: t.Levels | None = Field(
        None, description="loaded level, whose bricks share a force, a weight or a moment equally"
    )

    all: Literal[True] | None = Field(None, description="`true`: all bricks of the structure")

    table: Table | None = Field(
        None,
        description="rows [time after the beginning, share of the load], linear in between; the last share lasts",
    )

    file: Annotated[Record, RecordFile("load.csv")] | None = Field(
        None, description="CSV file with the columns `time` and `share`, in place of `table`"
    )

    towards: Towards | None = Field(
        None, description="direction of the force: `down`, `up`, or a horizontal bearing from +x towards +y"
    )
    about: Towards | None = Field(
        None, description="axis of the moment: `up`, `down`, or a horizontal bearing from +x towards +y"
    )
    face: FaceName | None = Field(
        None, description="loaded face, by its outward direction: `top`, `bottom`, or a horizontal bearing"
    )
    surface: t.Length | None = Field(
        None, description="height of the surface of the fluid above the ground; default: the top of the loaded bricks"
    )
    point: Place | None = Field(
        None,
        description="point of application, relative to the centre of the brick, along the axes of the scene; "
        "default: the middle of `face`, or the centre",
    )
    from_: Place | None = Field(None, alias="from", description="beginning of a line load, as `point`")
    to: Place | None = Field(None, description="end of a line load, as `point`")

    one_of: ClassVar[tuple[str, ...]] = (
        "force",
        "weight",
        "pressure",
        "wind",
        "fluid",
        "acceleration",
        "moment",
        "line",
    )
    also_one_of: ClassVar[tuple[str, ...]] = ("brick", "bricks", "level", "all")
    examples: ClassVar = {"force": "50 N", "brick": "L3.1"}
    # The keys of each kind of load: those that it needs, and those that it may have.
    needs: ClassVar = {
        "force": ("towards",),
        "weight": (),
        "pressure": ("face",),
        "wind": ("towards",),
        "fluid": ("face",),
        "acceleration": ("towards",),
        "moment": ("about",),
        "line": ("towards", "from_", "to"),
    }
    allows: ClassVar = {"force": ("point", "face"), "weight": ("point", "face"), "fluid": ("surface",)}
    values: ClassVar = {
        "towards": "towards: 90 deg` or `towards: down",
        "about": "about: 90 deg",
        "face": "face: top",
        "from_": "from: [0 mm, -50 mm, 0 mm]",
        "to": "to: [0 mm, 50 mm, 0 mm]",
    }

    @property
    def amount(self) -> Amount:
        """Return the amount of the load."""
        written: Amount = getattr(self, self.kind)
        return written

    @property
    def rows(self) -> Sequence[Row]:
        """Return times after the beginning [s] with the amounts then, in order; the last amount lasts."""
        if isinstance(self.amount, Growing):
            return ((0.0, self.amount.first), (self.amount.over, self.amount.last))
        shares = self.table or (self.file and self.file.rows(SHARE_COLUMN, SHARES, "a share")) or ((0.0, 1.0),)
        return tuple((time, share * self.amount) for time, share in shares)

    @property
    def is_mass(self) -> bool:
        """True if the amounts are masses [kg] or densities [kg/m3]."""
        amounts = (self.amount.first, self.amount.last) if isinstance(self.amount, Growing) else (self.amount,)
        return any(isinstance(amount, t.Weighed) for amount in amounts)

    @model_validator(mode="after")
    def _read_shares(self) -> Self:
        """Reject files that cannot be a table of shares."""
        if self.file is None:
            return self
        if self.table is not None or isinstance(self.amount, Growing):
            other = "has a `table`" if self.table is not None else "grows"
            raise InputError("SD108", f"the load has a `file` and {other}", "remove one of them")
        if set(self.file.columns) != {SHARE_COLUMN}:
            hint = "write a CSV file with the columns `time [s]` and `share`; the load is the share of its amount"
            raise InputError("SD114", f"{self.file.file} has no column `share`", hint)
        shares = self.file.rows(SHARE_COLUMN, SHARES, "a share")
        if len(shares) > MOST_ROWS:
            message = f"{self.file.file} has {len(shares)} rows; the maximum for a load is {MOST_ROWS}"
            raise InputError("SD114", message, "use fewer rows: the structure is judged again at each")
        if max(abs(share) for _, share in shares) > float(SHARE_OF_LOAD.most):
            message = f"{self.file.file} has a share beyond {float(SHARE_OF_LOAD.most):g}"
            raise InputError("SD114", message, "write shares of the load, such as 0.5")
        return self

    @model_validator(mode="after")
    def _grow_once(self) -> Self:
        if not isinstance(self.amount, Growing):
            return self
        if self.table is not None:
            raise InputError("SD108", "a load that grows has no `table`", "remove one of them")
        first, last = self.amount.first, self.amount.last
        if isinstance(first, t.Weighed) is not isinstance(last, t.Weighed) and first and last:
            raise InputError("SD104", "the load grows from a mass to a force", "write both as masses or as forces")
        return self

    @model_validator(mode="after")
    def _keys_of_kind(self) -> Self:
        kind = self.kind
        for key in self.needs[kind]:
            if getattr(self, key) is None:
                named = {"towards": "direction", "about": "axis"}.get(key)
                what = f"no {named}" if named else f"no `{self._spelling(key)}`"
                raise InputError("SD102", f"the load `{kind}` has {what}", f"add `{self.values[key]}`")
        for key in ("towards", "about", "face", "surface", "point", "from_", "to"):
            if getattr(self, key) is not None and key not in (*self.needs[kind], *self.allows.get(kind, ())):
                raise InputError("SD108", f"`{self._spelling(key)}` does not apply to the load `{kind}`", "remove it")
        return self

    @model_validator(mode="after")
    def _place_on_one(self) -> Self:
        key = next((key for key in ("point", "from_") if getattr(self, key) is not None), None)
        if key is not None and self.brick is None:
            raise InputError(
                "SD108", f"`{self._spelling(key)}` is a place on a single brick", "name it with `brick`, or remove it"
            )
        if self.point is not None and self.face is not None:
            raise InputError("SD108", "`point` and `face` exclude each other", "remove one of them")
        if self.from_ is not None and self.from_ == self.to:
            raise InputError("SD104", "the line has no length", "write different points, or use `force`")
        return self


Loads = Annotated[tuple[Load, ...], Field(max_length=MAX_LOADS)]
