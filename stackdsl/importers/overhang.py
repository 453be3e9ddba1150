"""Finds boxes that overhang the deck of their pallet, where nothing carries them.

The deck is where height is 0, and the ground is taken to go on around it, so that statics has such a box on more than
there is. That is told, as a warning: how far, to which side, and what to do.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from math import cos, radians, sin
from typing import Final

from stability.model import Vec3
from stackdsl.diagnostics import Warned
from stackdsl.importers.load import Deck, Exact3, ImportedBox, ImportedLoad, digits
from stackdsl.importers.settling import RIGHT_ANGLE
from stackdsl.language.imports import Import

SIDES: Final = ("-x", "+x", "-y", "+y")
OPPOSITE: Final = {"-x": "+x", "+x": "-x", "-y": "+y", "+y": "-y"}
ROUNDED: Final = Fraction(1, 10**9)  # [m] how far what is turned may be off
MILLIMETRES: Final = 1000


@dataclass(frozen=True, slots=True)
class Overhang:
    """How far a box reaches beyond the deck, on the side on which it does most."""

    box: ImportedBox
    side: str  # such as `+x`
    amount: Fraction  # [m]


def deck_of(load: ImportedLoad, asked: Import) -> Deck | None:
    """The deck that the author says, or else the file; None where nobody says one."""
    words, own = asked.deck, load.deck
    if words is None or (words.size is None and own is None):
        return own
    size = words.size or (own.size if own is not None else None)
    assert size is not None
    corner = own.corner if own is not None else (Fraction(repr(asked.origin[0])), Fraction(repr(asked.origin[1])))
    if words.at is not None:
        corner = (Fraction(repr(words.at[0])), Fraction(repr(words.at[1])))
    return Deck(size, corner)


def overhangs(load: ImportedLoad, asked: Import) -> list[Overhang]:
    """The boxes that reach further beyond the deck than is allowed, as they are listed."""
    deck = deck_of(load, asked)
    if deck is None:
        return []
    allowed = Fraction(repr(asked.deck.overhang)) if asked.deck is not None else Fraction(0)
    found = (Overhang(box, *max(_beyond(box, deck), key=lambda each: each[1])) for box in load.boxes)
    return [each for each in found if each.amount > allowed + load.precision + ROUNDED]


def warned(load: ImportedLoad, asked: Import) -> Iterator[Warned]:
    """One warning of a load of which something overhangs, in the place of the box that does most."""
    deck, found = deck_of(load, asked), overhangs(load, asked)
    if deck is None or not found:
        return
    worst = max(found, key=lambda each: each.amount)
    name = f"'{worst.box.name}'" if worst.box.name else "this box"
    amount = f"{_mm(worst.amount)} mm"
    others = len(found) - 1
    more = f", and {others} other{'s' * (others > 1)} by less or as much" if others else ""
    size = " x ".join(map(_mm, deck.size))
    yield Warned(
        worst.box.span,
        f"{name} overhangs the deck of {size} mm by {amount} towards {worst.side}{more}; nothing is below it "
        "there, and it is judged as if the deck went on",
        f"move it {amount} towards {OPPOSITE[worst.side]}, or allow it: `deck: {{overhang: {amount}}}`",
    )


def _mm(length: Fraction) -> str:
    return digits(round(MILLIMETRES * length, 3))


def _beyond(box: ImportedBox, deck: Deck) -> Iterator[tuple[str, Fraction]]:
    """How far a box reaches beyond each side; less than nothing where it does not."""
    low, high = _bounds(box)
    for axis in (0, 1):
        yield SIDES[2 * axis], deck.corner[axis] - low[axis]
        yield SIDES[2 * axis + 1], high[axis] - (deck.corner[axis] + deck.size[axis])


def _bounds(box: ImportedBox) -> tuple[Exact3, Exact3]:
    """The lowest and the highest corner of the upright box around it [m]; exact of what lies along the axes."""
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
    """Turned about x, then y, then z [deg]."""
    x, y, z = map(float, corner)
    (sin_x, cos_x), (sin_y, cos_y), (sin_z, cos_z) = ((sin(radians(angle)), cos(radians(angle))) for angle in turn)
    y, z = cos_x * y - sin_x * z, sin_x * y + cos_x * z
    x, z = cos_y * x + sin_y * z, cos_y * z - sin_y * x
    return (cos_z * x - sin_z * y, sin_z * x + cos_z * y, z)
