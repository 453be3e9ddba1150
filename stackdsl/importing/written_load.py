"""A load as the items of `bricks`, as an author would write them."""

from fractions import Fraction

from stackdsl.importing.load import LEVEL, ImportedBox
from stackdsl.reading.source import Plain


def written_box(box: ImportedBox) -> dict[str, Plain]:
    """One box as an item of `bricks`."""
    named: dict[str, Plain] = {"name": box.name} if box.name is not None else {}
    turn: dict[str, Plain] = {} if box.turn == LEVEL else {"rotate": [f"{digits(part)} deg" for part in box.turn]}
    brick: dict[str, Plain] = {"size": [_length(side) for side in box.size], "mass": f"{digits(box.mass)} kg"}
    return {**named, "at": [_length(part) for part in box.centre], **turn, "brick": brick}


def _length(metres: Fraction) -> str:
    return f"{digits(1000 * metres)} mm"


def digits(number: Fraction) -> str:
    """A number in as few digits as tell it from other doubles."""
    text = repr(float(number))
    return text.removesuffix(".0")
