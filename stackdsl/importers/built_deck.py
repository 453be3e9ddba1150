"""The pallet that is built below an imported load, and the load on top of its deck."""

from dataclasses import dataclass
from fractions import Fraction
from typing import Final

from stackdsl.diagnostics import Span
from stackdsl.importers.load import Exact3, ImportedBox, ImportedLoad, digits, shifted
from stackdsl.importers.overhang import deck_of
from stackdsl.language.imports import Import
from stackdsl.language.pallets import CLOSED, DECK_BRICK, DECKS, EUR_MASS, boards_of, pallet_boxes
from stackdsl.language.quantities import InputError
from stackdsl.language.yaml.source import Plain

LENGTH, WIDTH = DECKS["EUR"]
EUR_AREA: Final = Fraction(LENGTH * WIDTH, 10**6)  # [m2]


@dataclass(frozen=True, slots=True)
class BuiltDeck:
    """A pallet as a brick of a scenario."""

    written: dict[str, Plain]  # an item of `bricks`
    boxes: tuple[ImportedBox, ...]  # the closed pallet, or its boards and bearers; upright


def on_deck(load: ImportedLoad, options: Import) -> tuple[ImportedLoad, BuiltDeck | None]:
    """Return the load at the height of its deck, and the pallet that is built below it; None if none is built.

    The ground, or the pallet on it, is moved by the `origin` of the load. Raises InputError for a deck without a size,
    or with boards that do not fit.
    """
    if options.deck is None:
        return load, None
    is_built, level = options.deck.surface is not None, Fraction(repr(options.deck.level))
    height = Fraction(repr(options.deck.height)) if is_built else Fraction(0)
    if height != level:
        load = shifted(load, (0.0, 0.0, float(height - level)))
    return load, _built(load, options, height) if is_built else None


def _built(load: ImportedLoad, options: Import, height: Fraction) -> BuiltDeck:
    deck, asked = deck_of(load, options), options.deck
    assert asked is not None
    assert asked.surface is not None
    if deck is None:
        raise InputError("SD102", "the size of the deck is missing, and the file gives none", "add `size: EUR`")
    bottom = Fraction(repr(options.origin[2]))
    x, y = (corner + side / 2 for corner, side in zip(deck.corner, deck.size, strict=True))
    middle: Exact3 = (x, y, bottom + height / 2)
    span = load.boxes[0].span
    boards = boards_of(deck.size, asked.surface)
    whole = (float(deck.size[0]), float(deck.size[1]), float(height))
    boxes = (
        [_part(box.size, pose.position_W, middle, span) for box, pose in pallet_boxes(whole, boards)]
        if boards
        else [ImportedBox(DECK_BRICK, (*deck.size, height), middle, Fraction(1), span)]
    )
    mass = Fraction(repr(asked.mass)) if asked.mass is not None else _usual_mass(deck.size)
    surface: Plain = (
        asked.surface if isinstance(asked.surface, str) else [_mm(_exact(width)) for width in asked.surface]
    )
    pallet: dict[str, Plain] = {"size": [_mm(side) for side in deck.size], "height": _mm(height)}
    if surface != CLOSED:
        pallet["surface"] = surface
    written: dict[str, Plain] = {
        "name": DECK_BRICK,
        "at": [_mm(part) for part in middle],
        "brick": {"pallet": pallet, "mass": f"{digits(mass)} kg"},
    }
    return BuiltDeck(written, tuple(boxes))


def _usual_mass(size: tuple[Fraction, Fraction]) -> Fraction:
    """Return the mass of a pallet of a length and width, in proportion to an EUR pallet [kg]."""
    return Fraction(round(1000 * Fraction(EUR_MASS) * size[0] * size[1] / EUR_AREA), 1000)


def _part(size: tuple[float, ...], place: tuple[float, ...], middle: Exact3, span: Span) -> ImportedBox:
    length, width, height = map(_exact, size)
    x, y, z = (own + _exact(part) for own, part in zip(middle, place, strict=True))
    return ImportedBox(DECK_BRICK, (length, width, height), (x, y, z), Fraction(1), span)


def _exact(length: float) -> Fraction:
    """Return a length without the rounding error of sums of decimals [m]."""
    return Fraction(repr(round(length, 12)))


def _mm(length: Fraction) -> str:
    return f"{digits(1000 * length)} mm"
