"""Warns about boxes that overhang the deck of their pallet, where nothing supports them.

Unless the deck is built as a brick, statics treats it as part of an infinite ground at height 0, which supports such a
box on more area than there is.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from math import cos, radians, sin

from stability.model import Vec3
from stability.name_order import names_text
from stackdsl.diagnostics import ScenarioWarning
from stackdsl.importers.load import Deck, Exact3, ImportedBox, ImportedLoad
from stackdsl.importers.settling import RIGHT_ANGLE
from stackdsl.language.imports import Import
from stackdsl.language.pallets import CLOSED
from stackdsl.language.room_on_deck import Bounds, Room, millimetres, room_text
from stackdsl.language.yaml.source import Area

SIDES = ("-x", "+x", "-y", "+y")
ROUNDED = Fraction(1, 10**9)  # [m] rounding error of turned corners


@dataclass(frozen=True, slots=True)
class Overhang:
    """The distances by which a box reaches beyond the deck."""

    box: ImportedBox
    beyond: tuple[tuple[str, Fraction], ...]  # each side, such as `+x`, and the distance there [m]; the largest first

    @property
    def side(self) -> str:
        """Return the side with the largest overhang."""
        return self.beyond[0][0]

    @property
    def amount(self) -> Fraction:
        """Return the largest overhang [m]."""
        return self.beyond[0][1]


def deck_of(load: ImportedLoad, options: Import) -> Deck | None:
    """Return the deck that the author gives, else that of the file; None if neither gives one."""
    given, own = options.deck, load.deck
    if given is None or (given.size is None and own is None):
        return own
    size = given.size or (own.size if own is not None else None)
    assert size is not None
    corner = own.corner if own is not None else (Fraction(repr(options.origin[0])), Fraction(repr(options.origin[1])))
    if given.at is not None:
        corner = (Fraction(repr(given.at[0])), Fraction(repr(given.at[1])))
    return Deck(size, corner)


def overhangs(load: ImportedLoad, options: Import) -> list[Overhang]:
    """Return the boxes that overhang by more than is allowed, in file order."""
    deck = deck_of(load, options)
    if deck is None:
        return []
    allowed = _allowed(options) + load.precision + ROUNDED
    beyond = ((box, [each for each in _side_overhangs(box, deck) if each[1] > allowed]) for box in load.boxes)
    return [Overhang(box, tuple(sorted(sides, key=lambda each: -each[1]))) for box, sides in beyond if sides]


def permitted_area(load: ImportedLoad, options: Import) -> Area | None:
    """Return the lowest and highest corner of the deck with its permitted overhang [m]; None without a deck."""
    deck, allowed = deck_of(load, options), _allowed(options)
    if deck is None:
        return None
    low = tuple(corner - allowed for corner in deck.corner)
    high = tuple(corner + size + allowed for corner, size in zip(deck.corner, deck.size, strict=True))
    return (float(low[0]), float(low[1])), (float(high[0]), float(high[1]))


def overhang_warnings(load: ImportedLoad, options: Import) -> Iterator[ScenarioWarning]:
    """Yield one warning if any box overhangs, at the position of the box that overhangs most."""
    deck, area, overhanging = deck_of(load, options), permitted_area(load, options), overhangs(load, options)
    if deck is None or area is None or not overhanging:
        return
    worst = max(overhanging, key=lambda overhang: overhang.amount)
    name = f"'{worst.box.name}'" if worst.box.name else "this box"
    sides = " and ".join(f"{millimetres(float(amount))} mm towards {side}" for side, amount in worst.beyond)
    others = [_name(each.box) for each in overhanging if each is not worst]
    more = f", and {names_text(others)} by at most this amount" if others else ""
    size = " x ".join(millimetres(float(side)) for side in deck.size)
    if _is_beside(worst.box, deck):
        assumed = "" if _is_built(options) else "; the verdict assumes that the deck continues there"
        yield ScenarioWarning(
            worst.box.span,
            f"{name} lies beside the deck of {size} mm, and reaches {sides} beyond it{more}{assumed}",
            "import each pallet of a table by itself; if the deck is elsewhere, give its corner in the scenario: "
            "`deck: {at: [x, y]}`",
        )
        return
    number = next(number for number, box in enumerate(load.boxes) if box is worst.box)
    names = [f"'{box.name}'" if box.name else _name(box) for box in load.boxes]
    yield ScenarioWarning(
        worst.box.span,
        f"{name} overhangs the deck of {size} mm by {sides}{more}; {_basis(load, deck, options)}",
        f"{room_text(Room([*map(_float_bounds, load.boxes)], area), number, names)}, or permit the overhang: "
        f"`deck: {{overhang: {millimetres(float(worst.amount))} mm}}`",
    )


def _is_built(options: Import) -> bool:
    return options.deck is not None and options.deck.surface is not None


def _basis(load: ImportedLoad, deck: Deck, options: Import) -> str:
    """Return whether the ground beside the deck carries a box in the verdict."""
    if _is_built(options):
        return "the verdict is that of this deck"
    allowed = load.precision + ROUNDED
    beside = [
        _name(box)
        for box in load.boxes
        if _bounds(box)[0][2] <= allowed and any(beyond > allowed for _, beyond in _side_overhangs(box, deck))
    ]
    if not beside:
        return "every overhanging box lies on other boxes, so the verdict is that of the real deck"
    carried = f"the verdict counts on ground beside the deck below {names_text(beside)}"
    return f"{carried}; to judge the real deck, build it: `deck: {{surface: {CLOSED}}}`"


def _name(box: ImportedBox) -> str:
    return box.name or f"the box of line {box.span.line}"


def _is_beside(box: ImportedBox, deck: Deck) -> bool:
    """Return whether no part of a box is above the deck."""
    low, high = _bounds(box)
    return any(low[axis] >= deck.corner[axis] + deck.size[axis] or high[axis] <= deck.corner[axis] for axis in (0, 1))


def _allowed(options: Import) -> Fraction:
    return Fraction(repr(options.deck.overhang)) if options.deck is not None else Fraction(0)


def _float_bounds(box: ImportedBox) -> Bounds:
    (a, b, c), (d, e, f) = _bounds(box)
    return (float(a), float(b), float(c)), (float(d), float(e), float(f))


def _side_overhangs(box: ImportedBox, deck: Deck) -> Iterator[tuple[str, Fraction]]:
    """Yield the overhang of a box at each side [m]; negative where it ends on the deck."""
    low, high = _bounds(box)
    for axis in (0, 1):
        yield SIDES[2 * axis], deck.corner[axis] - low[axis]
        yield SIDES[2 * axis + 1], high[axis] - (deck.corner[axis] + deck.size[axis])


def _bounds(box: ImportedBox) -> tuple[Exact3, Exact3]:
    """Return the corners of the bounding box [m]; exact for a box along the axes."""
    half = [side / 2 for side in box.size]
    if box.is_upright and box.turn[2] % RIGHT_ANGLE == 0:
        a, b, c = half if box.turn[2] % (2 * RIGHT_ANGLE) == 0 else (half[1], half[0], half[2])
        x, y, z = box.centre
        return (x - a, y - b, z - c), (x + a, y + b, z + c)
    turned = [_turned(corner, box.turn) for corner in box.corners or product(*((-side, side) for side in half))]
    ends = [(min(along), max(along)) for along in zip(*turned, strict=True)]
    low, high = ([centre + Fraction(end[k]) for centre, end in zip(box.centre, ends, strict=True)] for k in (0, 1))
    return (low[0], low[1], low[2]), (high[0], high[1], high[2])


def _turned(corner: tuple[Fraction, ...], turn: Exact3) -> Vec3:
    """Rotate a corner about x, then y, then z [deg]."""
    x, y, z = map(float, corner)
    (sin_x, cos_x), (sin_y, cos_y), (sin_z, cos_z) = ((sin(radians(angle)), cos(radians(angle))) for angle in turn)
    y, z = cos_x * y - sin_x * z, sin_x * y + cos_x * z
    x, z = cos_y * x + sin_y * z, cos_y * z - sin_y * x
    return (cos_z * x - sin_z * y, sin_z * x + cos_z * y, z)
