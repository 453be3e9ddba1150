"""A load as the items of `bricks`, as an author would write them."""

from fractions import Fraction

from stackdsl.importing.load import LEVEL, Exact3, ImportedBox
from stackdsl.reading.source import Plain


def written_box(box: ImportedBox) -> dict[str, Plain]:
    """One box as an item of `bricks`."""
    named: dict[str, Plain] = {"name": box.name} if box.name is not None else {}
    turn: dict[str, Plain] = {} if box.turn == LEVEL else {"rotate": [f"{digits(part)} deg" for part in box.turn]}
    brick: dict[str, Plain] = _form(box) | {"mass": f"{digits(box.mass)} kg"}
    if box.heavy_at is not None:
        brick["centre_of_mass"] = _lengths(box.heavy_at)
    rubs: dict[str, Plain] = {} if box.friction is None else {"friction": float(box.friction)}
    return {**named, "at": _lengths(box.centre), **turn, "brick": brick, **rubs}


def _form(box: ImportedBox) -> dict[str, Plain]:
    if box.corners is None:
        return {"size": _lengths(box.size)}
    return {"points": [_lengths(corner) for corner in box.corners]}


def _lengths(parts: Exact3) -> list[Plain]:
    return [_length(part) for part in parts]


def _length(metres: Fraction) -> str:
    return f"{digits(1000 * metres)} mm"


def digits(number: Fraction) -> str:
    """A number in as few digits as tell it from other doubles."""
    text = repr(float(number))
    return text.removesuffix(".0")
