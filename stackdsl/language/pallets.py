"""Decks of pallets: standard sizes, and the boards on which a load lies."""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import accumulate
from typing import Annotated, ClassVar, Final, TypeAlias

from pydantic import Field, model_validator

from stability.geometry.box import Box
from stability.model import Pose, Vec3
from stackdsl.language import value_types as t
from stackdsl.language.model_base import Shorthand, default
from stackdsl.language.quantities import EXTENT, InputError, exact_quantity, quantity_pattern, shown
from stackdsl.language.value_types import JsonSchema, Reads
from stackdsl.wording import mm

# Length and width [mm]: EUR pallets of EN 13698, the sizes of ISO 6780, and the common one of North America.
DECKS: Final[Mapping[str, tuple[int, int]]] = {
    "EUR": (1200, 800),
    "EUR2": (1200, 1000),
    "EUR3": (1000, 1200),
    "EUR6": (800, 600),
    "ISO-1200x800": (1200, 800),
    "ISO-1200x1000": (1200, 1000),
    "ISO-1219x1016": (1219, 1016),
    "ISO-1140x1140": (1140, 1140),
    "ISO-1100x1100": (1100, 1100),
    "ISO-1067x1067": (1067, 1067),
    "GMA": (1219, 1016),
}
LENGTH_X_WIDTH: Final = 2
MOST_BOARDS: Final = 50
BOARD: Final = 0.022  # [m] thickness of the boards of EN 13698
BEARER: Final = 0.1  # [m] width of the three bearers, like the outer blocks of an EUR pallet
BEARERS: Final = 3
# Width of the boards of an EUR pallet, from one long side to the other [m] (EN 13698-1).
EUR_BOARDS: Final = (0.145, 0.100, 0.145, 0.100, 0.145)
EUR_HEIGHT: Final = "144 mm"
EUR_MASS: Final = 25.0  # [kg], the usual one
DECK_BRICK: Final = "deck"  # name of the pallet that is built below an imported load
CLOSED: Final = "closed"
AS_EUR: Final = "boards"

Surface: TypeAlias = str | tuple[float, ...]  # `closed`, `boards` of an EUR pallet, or the widths of boards [m]
Boxes: TypeAlias = tuple[tuple[Box, Pose], ...]


def parse_deck_size(written: object) -> tuple[Fraction, Fraction]:
    """Read the name of a standard pallet such as `EUR`, or length and width with their units. Return [m]."""
    advice = f"write one of {', '.join(DECKS)}, or length and width, such as [1200 mm, 800 mm]"
    if isinstance(written, str) and written in DECKS:
        length, width = DECKS[written]
        return Fraction(length, 1000), Fraction(width, 1000)
    sides = list(written) if isinstance(written, list | tuple) else []
    if len(sides) != LENGTH_X_WIDTH or not all(isinstance(side, str) for side in sides):
        raise InputError("SD104", f"{shown(written)} is not the size of a deck", advice)
    length_, width_ = (exact_quantity(side, EXTENT) for side in sides)
    if not (0 < length_ <= 100 and 0 < width_ <= 100):  # noqa: PLR2004 -- [m]
        raise InputError(
            "SD104", "a side of the deck is out of range: it must be greater than zero, at most 100 m", advice
        )
    return length_, width_


_SIDE: Final[JsonSchema] = {"type": "string", "pattern": rf"^\s*{quantity_pattern(EXTENT)}\s*$"}
_DECK_SIZE: Final[JsonSchema] = {
    "anyOf": [{"enum": list(DECKS)}, {"type": "array", "items": _SIDE, "minItems": 2, "maxItems": 2}],
    "examples": ["EUR"],
}
DeckSize: TypeAlias = Annotated[tuple[Fraction, Fraction], Reads(parse_deck_size, _DECK_SIZE)]


def parse_surface(written: object) -> Surface:
    """Read `closed`, `boards`, or the widths of the boards with their units. Return widths in metres."""
    if written in (CLOSED, AS_EUR):
        return str(written)
    advice = (
        f"write {CLOSED}, {AS_EUR} (of an EUR pallet), or the width of each board, such as [100 mm, 100 mm, 100 mm]"
    )
    if not isinstance(written, list | tuple) or not all(isinstance(width, str) for width in written):
        raise InputError("SD104", f"{shown(written)} is not the surface of a deck", advice)
    if not LENGTH_X_WIDTH <= len(written) <= MOST_BOARDS:
        raise InputError("SD104", f"a deck has 2 to {MOST_BOARDS} boards, not {len(written)}", advice)
    widths = tuple(float(exact_quantity(str(width), EXTENT)) for width in written)
    if min(widths) <= 0.0:
        raise InputError("SD104", "a board must be wider than zero", advice)
    return widths


_SURFACE: Final[JsonSchema] = {
    "anyOf": [
        {"enum": [CLOSED, AS_EUR]},
        {"type": "array", "items": _SIDE, "minItems": LENGTH_X_WIDTH, "maxItems": MOST_BOARDS},
    ],
    "examples": [CLOSED],
}
DeckSurface: TypeAlias = Annotated[Surface, Reads(parse_surface, _SURFACE)]


def boards_of(size: Sequence[Fraction | float], surface: Surface) -> tuple[float, ...]:
    """Return the widths of the boards of a deck of a length and width [m]; none if it is closed. Raises InputError."""
    if surface == CLOSED:
        return ()
    if surface == AS_EUR:
        if [round(1000 * float(side)) for side in size] != list(DECKS["EUR"]):
            message = f"`surface: {AS_EUR}` is that of an EUR pallet of 1200 x 800 mm, and this deck has another size"
            hint = f"write {CLOSED}, or the width of each board, such as [100 mm, 100 mm, 100 mm]"
            raise InputError("SD104", message, hint)
        return EUR_BOARDS
    assert not isinstance(surface, str)
    if sum(surface) > float(size[1]) + 1e-9:  # rounding
        message = f"the boards are {mm(sum(surface))} wide in total, wider than the deck of {mm(float(size[1]))}"
        raise InputError("SD104", message, "write fewer or narrower boards; they lie along the length of the deck")
    return surface


def pallet_boxes(size: Vec3, boards: Sequence[float]) -> Boxes:
    """Return the boards of a pallet along x, with equal gaps, and three bearers across them. Raises InputError.

    `size` is the length, width and height of the whole [m], and the origin is the middle of it.
    """
    length, width, height = size
    if height <= BOARD:
        message = f"a height of {mm(height)} leaves nothing below boards of {mm(BOARD)}"
        raise InputError("SD104", message, f"write a height above {mm(BOARD)}, or `surface: {CLOSED}`")
    if length <= BEARERS * BEARER:
        message = f"a length of {mm(length)} has no room for {BEARERS} bearers of {mm(BEARER)} below the boards"
        raise InputError("SD104", message, f"write a longer deck, or `surface: {CLOSED}`")
    gap = max(0.0, width - sum(boards)) / (len(boards) - 1)
    starts = [start + n * gap - 0.5 * width for n, start in enumerate(accumulate((0.0, *boards[:-1])))]
    top, below = 0.5 * (height - BOARD), height - BOARD
    laid = [
        (Box((length, own, BOARD)), Pose((0.0, start + 0.5 * own, top)))
        for start, own in zip(starts, boards, strict=True)
    ]
    reach = 0.5 * (length - BEARER)
    bearers = [(Box((BEARER, width, below)), Pose((x, 0.0, -0.5 * BOARD))) for x in (-reach, 0.0, reach)]
    return (*laid, *bearers)


class Pallet(Shorthand):
    """A pallet whose deck has its length along x."""

    size: DeckSize = Field(description=f"{', '.join(DECKS)}, or [length along x, width along y]")
    height: t.Side = default(EUR_HEIGHT, "height of the pallet")
    surface: DeckSurface = default(
        CLOSED,
        "the deck: `closed`, the `boards` of an EUR pallet, or the width of each board, which lie along x with equal "
        "gaps",
    )

    scalar_key: ClassVar[str] = "size"

    @property
    def whole(self) -> Vec3:
        """Return length, width and height [m]."""
        return (float(self.size[0]), float(self.size[1]), self.height)

    @property
    def boards(self) -> tuple[float, ...]:
        """Return the widths of the boards [m]; none if the deck is closed."""
        return boards_of(self.size, self.surface)

    @model_validator(mode="after")
    def _fits(self) -> "Pallet":
        if self.boards:
            pallet_boxes(self.whole, self.boards)
        return self
