"""`import`: the boxes of a file that another program wrote, and how they are to be taken."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Annotated, ClassVar, Final, Literal, Self, TypeAlias, get_args

from pydantic import Field, WithJsonSchema, model_validator

from stackdsl.language import value_types as t
from stackdsl.language.model_base import AtLeastOneKey, AuthorModel, Shorthand, default
from stackdsl.language.quantities import EXTENT, MistakeError, exact_quantity, quantity_pattern, shown
from stackdsl.language.value_types import Reads, text_schema

Format: TypeAlias = Literal["table", "pallet-sim", "bed-bpp", "compas", "obj", "mjcf", "urdf"]
FORMATS: Final[tuple[Format, ...]] = get_args(Format)
# Of which formats a key is: the others say it by themselves, or have no such thing.
OF_FORMATS: Final[Mapping[str, tuple[Format, ...]]] = {
    "load": ("pallet-sim", "bed-bpp"),
    "point": ("table",),
    "units": ("table", "compas", "obj"),
    "density": ("compas", "obj"),
    "up": ("obj",),
    "supports": ("compas",),
}

_ADVICE: Final = "write as written, down, or such as within 5 mm"


@dataclass(frozen=True, slots=True)
class Settle:
    """How boxes of a file are brought into contact with what is below them."""

    lowered: bool = False  # each until it touches
    within: Fraction | None = None  # gaps up to this count as contact [m]


def parse_settle(written: object) -> Settle:
    """`as written`, `down`, or `within 5 mm`."""
    words = " ".join(written.split()) if isinstance(written, str) else ""
    if words in {"as written", "down"}:
        return Settle(lowered=words == "down")
    if (found := re.fullmatch(r"within (.+)", words)) is None:
        raise MistakeError("SD104", f"{shown(written)} is no way to settle", _ADVICE)
    gap = exact_quantity(found[1], EXTENT)
    if not 0 < gap <= 1:
        raise MistakeError("SD104", f"a gap of {found[1]} is out of range", "write more than zero, at most 1 m")
    return Settle(within=gap)


_SETTLE: Final = rf"as written|down|within\s+{quantity_pattern(EXTENT)}"


class DefaultUnits(AtLeastOneKey):
    """Units of what says none."""

    length: Literal["mm", "cm", "m"] | None = Field(None, description="of sizes and places")
    mass: Literal["g", "kg"] | None = Field(None, description="of masses")


# Length and width, as names of standards have them [mm]: EN 13698 and ISO 6780.
DECKS: Final[Mapping[str, tuple[int, int]]] = {
    "EUR": (1200, 800),
    "EUR2": (1200, 1000),
    "EUR3": (1000, 1200),
    "EUR6": (800, 600),
    "GMA": (1219, 1016),
}


def parse_deck_size(written: object) -> tuple[Fraction, Fraction]:
    """`EUR` and others by name, or length and width with their units [m]."""
    advice = f"write one of {', '.join(DECKS)}, or such as [1200 mm, 800 mm]"
    if isinstance(written, str) and written in DECKS:
        length, width = DECKS[written]
        return Fraction(length, 1000), Fraction(width, 1000)
    if not (isinstance(written, list | tuple) and len(written) == 2 and all(isinstance(each, str) for each in written)):  # noqa: PLR2004
        raise MistakeError("SD104", f"{shown(written)} is no size of a deck", advice)
    length_, width_ = (exact_quantity(each, EXTENT) for each in written)
    if not (0 < length_ <= 100 and 0 < width_ <= 100):  # noqa: PLR2004 -- [m]
        raise MistakeError("SD104", "a deck has no length or width, or more than 100 m", advice)
    return length_, width_


_SIDE: Final = {"type": "string", "pattern": rf"^\s*{quantity_pattern(EXTENT)}\s*$"}
_DECK_SIZE: Final = {
    "anyOf": [{"enum": list(DECKS)}, {"type": "array", "items": _SIDE, "minItems": 2, "maxItems": 2}],
    "examples": ["EUR"],
}


class DeckWords(Shorthand):
    """The deck of the pallet that a load is on: at height 0, its sides along x and y."""

    size: Annotated[tuple[Fraction, Fraction], Reads(parse_deck_size, _DECK_SIZE)] | None = Field(
        None, description="EUR, EUR2, EUR3, EUR6, GMA, or [length along x, width along y]; default: what the file says"
    )
    at: tuple[t.Length, t.Length] | None = Field(None, description="[x, y] of its corner; default: [0, 0] of the file")
    overhang: t.NonNegativeLength = default("0 mm", "how far a box may reach beyond it")

    scalar_key: ClassVar[str] = "size"


class Import(AuthorModel):
    """The boxes of one load in a file."""

    file: Annotated[str, WithJsonSchema({**t.FILE, "examples": ["load.csv"]})] = Field(
        description="the file, as seen from this one; inside the project"
    )
    format: Format | None = Field(None, description="what it is; default: what it cannot but be")
    load: str | None = Field(None, description="which of several loads: number of the pallet, or of the order")
    settle: Annotated[
        Settle, Reads(parse_settle, text_schema(_SETTLE, "how boxes come to touch what is below", "within 5 mm"))
    ] = default("as written", "how boxes come to touch what is below them")
    point: Literal["corner", "centre"] | None = Field(
        None, description="of a table: what x, y, z are of a box, its lower corner or its centre"
    )
    units: DefaultUnits | None = Field(
        None, description="of columns whose headers say none, or of an OBJ or COMPAS file, which never does"
    )
    density: t.Density | None = Field(None, description="of an OBJ or COMPAS file: of all blocks in it")
    up: Literal["+y", "+z"] | None = Field(None, description="of an OBJ file: which of its axes points up")
    supports: Literal["bricks"] | None = Field(
        None, description="of a COMPAS file: `bricks` takes the blocks that it says are fixed as bricks like others"
    )
    deck: DeckWords | None = Field(
        None, description="the deck of its pallet, of which what overhangs is told; default: what the file says"
    )
    origin: tuple[t.Length, t.Length, t.Length] = default(["0 mm", "0 mm", "0 mm"], "shifts the load by [x, y, z]")
    ignore: Annotated[tuple[str, ...], Field(max_length=1000)] = Field(
        (), description="what the file has beside, and is not to be taken: columns, keys, or bodies"
    )

    @model_validator(mode="after")
    def _say_what_is_open(self) -> Self:
        if self.format is not None and (wrong := self.beside(self.format)) is not None:
            raise MistakeError("SD108", *wrong)
        if self.format not in {None, "table"} and self.units is not None and self.units.mass is not None:
            raise MistakeError("SD108", "`units: mass` is of tables", "leave it out")
        return self

    def beside(self, format_: Format) -> tuple[str, str] | None:
        """Which key there is that a file of this format has no use for, and what to do; None if there is none."""
        for key, formats in OF_FORMATS.items():
            if format_ not in formats and getattr(self, key) is not None:
                return f"`{key}` is of {' and '.join(formats)} files, and this is {format_}", f"leave `{key}` out"
        return None
