"""A load as a whole somewhere else."""

from dataclasses import replace
from fractions import Fraction

from stability.model import Vec3
from stackdsl.importing.load import ImportedBox, ImportedLoad


def shifted(load: ImportedLoad, by: Vec3) -> ImportedLoad:
    """The load, moved by so much [m]."""
    if by == (0.0, 0.0, 0.0):
        return load
    x, y, z = (Fraction(repr(part)) for part in by)

    def moved(box: ImportedBox) -> ImportedBox:
        return replace(box, centre=(box.centre[0] + x, box.centre[1] + y, box.centre[2] + z))

    deck = load.deck and replace(load.deck, corner=(load.deck.corner[0] + x, load.deck.corner[1] + y))
    return replace(load, boxes=tuple(map(moved, load.boxes)), deck=deck)
