"""Warns about boxes that overhang the deck of their pallet, where nothing supports them.

Statics treats the deck as part of an infinite ground at height 0, so it supports such a box on more area than there is.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from math import cos, radians, sin
from typing import Final

from stability.model import Vec3
from stackdsl.diagnostics import ScenarioWarning
from stackdsl.importers.load import Deck, Exact3, ImportedBox, ImportedLoad, digits
from stackdsl.importers.settling import RIGHT_ANGLE
from stackdsl.language.imports import Import

SIDES: Final = ("-x", "+x", "-y", "+y")
OPPOSITE: Final = {"-x": "+x", "+x": "-x", "-y": "+y", "+y": "-y"}
ROUNDED: Final = Fraction(1, 10**9)  # [m] rounding error of turned corners
MILLIMETRES: Final = 1000


@dataclass(frozen=True, slots=True)
class Overhang:
    """The largest distance by which a box reaches beyond the deck."""

    box: ImportedBox
    side: str  # such as `+x`
    amount: Fraction  # [m]


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
    allowed = Fraction(repr(options.deck.overhang)) if options.deck is not None else Fraction(0)
    largest = (Overhang(box, *max(_side_overhangs(box, deck), key=lambda each: each[1])) for box in load.boxes)
    return [overhang for overhang in largest if overhang.amount > allowed + load.precision + ROUNDED]


def overhang_warnings(load: ImportedLoad, options: Import) -> Iterator[ScenarioWarning]:
    """Yield one warning if any box overhangs, at the position of the box that overhangs most."""
    deck, overhanging = deck_of(load, options), overhangs(load, options)
    if deck is None or not overhanging:
        return
    worst = max(overhanging, key=lambda overhang: overhang.amount)
    name = f"'{worst.box.name}'" if worst.box.name else "this box"
    amount = f"{_mm(worst.amount)} mm"
    others = len(overhanging) - 1
    more = f", and {others} other box{'es' * (others > 1)} by at most this amount" if others else ""
    size = " x ".join(map(_mm, deck.size))
    yield ScenarioWarning(
        worst.box.span,
        f"{name} overhangs the deck of {size} mm by {amount} towards {worst.side}{more}; the verdict assumes that the "
        "deck continues there",
        f"move the box {amount} towards {OPPOSITE[worst.side]}, or permit the overhang: `deck: {{overhang: {amount}}}`",
    )


def _mm(length: Fraction) -> str:
    return digits(round(MILLIMETRES * length, 3))


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
