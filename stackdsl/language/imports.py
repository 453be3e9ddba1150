"""`import`: the boxes in a file of another program, and the options for reading it."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Annotated, ClassVar, Final, Literal, Self, TypeAlias, get_args

from pydantic import Field, WithJsonSchema, model_validator

from stackdsl.language import value_types as t
from stackdsl.language.model_base import AtLeastOneKey, AuthorModel, Shorthand, default
from stackdsl.language.pallets import AS_EUR, CLOSED, DECKS, EUR_HEIGHT, DeckSize, DeckSurface
from stackdsl.language.quantities import EXTENT, InputError, exact_quantity, quantity_pattern, shown
from stackdsl.language.strengths import BrickStrength
from stackdsl.language.value_types import Reads, text_schema

Format: TypeAlias = Literal[
    "table",
    "pallet-sim",
    "bed-bpp",
    "compas",
    "obj",
    "stl",
    "ply",
    "mjcf",
    "urdf",
    "stablelego",
    "apex-mr",
    "brickgpt",
    "ldraw",
]
LOAD_FORMATS: Final[tuple[Format, ...]] = get_args(Format)
# The formats that each key applies to. The others have the value in the file, or do not need it.
OF_FORMATS: Final[Mapping[str, tuple[Format, ...]]] = {
    "load": ("pallet-sim", "bed-bpp"),
    "point": ("table",),
    "map_": ("table",),
    "decimals": ("table",),
    "encoding": ("table",),
    "units": ("table", "compas", "obj", "stl", "ply"),
    "density": ("compas", "obj", "stl", "ply"),
    "up": ("obj", "stl", "ply"),
    "supports": ("compas",),
    "library": ("stablelego", "apex-mr"),
    "strength": ("table", "pallet-sim", "bed-bpp", "compas", "obj", "stl", "ply"),
}

_ADVICE: Final = "write `as written`, `down`, or a largest gap such as `within 5 mm` or `closed within 5 mm`"


@dataclass(frozen=True, slots=True)
class Settle:
    """How imported boxes are brought into contact with the boxes below."""

    lowered: bool = False  # each box moves down until it touches
    within: Fraction | None = None  # gaps up to this count as contact [m]
    closed: Fraction | None = None  # gaps up to this between bodies of any shape are closed by moving them [m]


def parse_settle(written: object) -> Settle:
    """Read `as written`, `down`, `within 5 mm` or `closed within 5 mm`."""
    words = " ".join(written.split()) if isinstance(written, str) else ""
    if words in {"as written", "down"}:
        return Settle(lowered=words == "down")
    if (match := re.fullmatch(r"(closed )?within (.+)", words)) is None:
        raise InputError("SD104", f"{shown(written)} is not a value of `settle`", _ADVICE)
    gap = exact_quantity(match[2], EXTENT)
    if not 0 < gap <= 1:
        raise InputError("SD104", f"a gap of {match[2]} is out of range", "write a gap greater than zero, at most 1 m")
    return Settle(closed=gap) if match[1] else Settle(within=gap)


_SETTLE: Final = rf"as written|down|(?:closed\s+)?within\s+{quantity_pattern(EXTENT)}"


class DefaultUnits(AtLeastOneKey):
    """Units of values without a unit in the file."""

    length: Literal["mm", "cm", "m", "in"] | None = Field(None, description="unit of sizes and positions")
    mass: Literal["g", "kg", "t", "lb"] | None = Field(None, description="unit of masses")


class ColumnMap(AtLeastOneKey):
    """The headers of a table for the columns of a load."""

    name: str | None = Field(None, description="header of the column of names")
    length: str | None = Field(None, description="header of the column of sides along x")
    width: str | None = Field(None, description="header of the column of sides along y")
    height: str | None = Field(None, description="header of the column of sides along z")
    mass: str | None = Field(None, description="header of the column of masses")
    x: str | None = Field(None, description="header of the column of positions along x")
    y: str | None = Field(None, description="header of the column of positions along y")
    z: str | None = Field(None, description="header of the column of positions along z")
    yaw: str | None = Field(None, description="header of the column of turns about the vertical")
    rotated: str | None = Field(None, description="header of the column of orientations, such as yes or WLH")
    friction: str | None = Field(None, description="header of the column of coefficients of friction")

    def headers(self) -> Mapping[str, str]:
        """Return the header of each column that has one here."""
        written = {column: getattr(self, column) for column in type(self).model_fields}
        return {column: header for column, header in written.items() if header is not None}


class DeckWords(Shorthand):
    """The deck of the pallet under a load: at height 0 of the file, its sides along x and y."""

    size: DeckSize | None = Field(
        None, description=f"{', '.join(DECKS)}, or [length along x, width along y]; default: from the file"
    )
    surface: DeckSurface | None = Field(
        None,
        description="builds the pallet as a brick `deck` below the load: `closed`, the `boards` of an EUR pallet, or "
        "the width of each board along x; default: the ground is the deck",
    )
    height: t.Side = default(EUR_HEIGHT, "height of the pallet that is built")
    mass: t.Mass | None = Field(
        None,
        description="mass of the pallet that is built; default: 25 kg for an area of 1200 x 800 mm, and in proportion",
    )
    level: t.Length = default("0 mm", "height of the deck in the file; 144 mm if z counts from below an EUR pallet")
    at: tuple[t.Length, t.Length] | None = Field(
        None, description="position [x, y] of the corner of the deck; default: [0, 0] in the file"
    )
    overhang: t.NonNegativeLength = default("0 mm", "permissible overhang of a box beyond the deck")

    scalar_key: ClassVar[str] = "size"

    @model_validator(mode="after")
    def _build_what_is_described(self) -> Self:
        for key in ("height", "mass"):
            if key in self.model_fields_set and self.surface is None:
                message = f"`{key}` applies only to a deck that is built"
                raise InputError("SD102", message, f"add `surface: {CLOSED}` or `surface: {AS_EUR}`")
        return self


class Import(AuthorModel):
    """The boxes of one load in a file."""

    file: Annotated[str, WithJsonSchema({**t.FILE, "examples": ["load.csv"]})] = Field(
        description="file inside the project; the path is relative to the folder of this file"
    )
    format: Format | None = Field(None, description="format of the file; default: recognised from its name and content")
    load: str | None = Field(None, description="number of the pallet or order, in a file with several loads")
    settle: Annotated[
        Settle, Reads(parse_settle, text_schema(_SETTLE, "treatment of gaps below boxes", "within 5 mm"))
    ] = default(
        "as written",
        "treatment of gaps: kept, closed below boxes by moving them down, counted as contact below boxes, "
        "or closed between stones of any shape by the least moves",
    )
    point: Literal["corner", "centre"] | None = Field(
        None,
        description="reference point of the coordinates x, y, z of a box in a table: its lower corner or its centre",
    )
    map_: ColumnMap | None = Field(
        None, alias="map", description="headers of a table that have other names, such as {length: L}"
    )
    decimals: Literal["point", "comma"] | None = Field(
        None, description="sign of decimals in a table; the other one may separate thousands; default: from the numbers"
    )
    encoding: Literal["utf-8", "windows-1252"] | None = Field(
        None, description="encoding of a table, such as that of a spreadsheet's CSV; default: utf-8"
    )
    units: DefaultUnits | None = Field(
        None, description="units of table columns without a unit in the header, or of a mesh or COMPAS file"
    )
    density: t.Density | None = Field(None, description="density of all blocks in a mesh or COMPAS file")
    up: Literal["+y", "+z"] | None = Field(None, description="vertical axis of an OBJ, STL or PLY file")
    supports: Literal["bricks"] | None = Field(
        None, description="`bricks` reads the fixed blocks of a COMPAS file as movable bricks"
    )
    library: str | None = Field(
        None, description="file with the sizes and masses of the bricks of a StableLego or APEX-MR file, beside it"
    )
    strength: BrickStrength | None = Field(
        None, description="strength of every imported brick against crushing; default: they never crush"
    )
    deck: DeckWords | None = Field(
        None, description="deck of the pallet, for the check of overhang; default: from the file"
    )
    origin: tuple[t.Length, t.Length, t.Length] = default(
        ["0 mm", "0 mm", "0 mm"], "displacement [x, y, z] of the load"
    )
    ignore: Annotated[tuple[str, ...], Field(max_length=1000)] = Field(
        (), description="parts of the file to ignore: columns, keys, or bodies"
    )

    @model_validator(mode="after")
    def _check_format(self) -> Self:
        if self.format is not None and (wrong := self.beside(self.format)) is not None:
            raise InputError("SD108", *wrong)
        if self.format not in {None, "table"} and self.units is not None and self.units.mass is not None:
            raise InputError("SD108", "`units: mass` applies to tables only", "remove it")
        return self

    def beside(self, format_: Format) -> tuple[str, str] | None:
        """Return message and hint for the first key that does not apply to a format; None if there is none."""
        for key, formats in OF_FORMATS.items():
            if format_ not in formats and getattr(self, key) is not None:
                told = key.removesuffix("_")
                return (
                    f"`{told}` applies only to {' and '.join(formats)} files, not to {format_} files",
                    f"remove `{told}`",
                )
        return None
