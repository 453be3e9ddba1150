"""Boxes of a file that overlap sideways by no more than its precision: of each two, the later one is cut."""

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

from stackdsl.importing.load import ImportedBox
from stackdsl.importing.plan import RIGHT_ANGLE, close_in_plan, outline


def trim(boxes: Sequence[ImportedBox], precision: Fraction) -> list[ImportedBox]:
    """The boxes without such overlaps; those that are turned by other than right angles stay as they are."""
    made = list(boxes)
    square = [box.turn[2] % RIGHT_ANGLE == 0 for box in boxes]
    low, high = [float(box.bottom) for box in boxes], [float(box.top) for box in boxes]
    for one, other in close_in_plan([outline(box) for box in boxes]):
        beside = min(high[one], high[other]) - max(low[one], low[other]) > precision
        if beside and square[one] and square[other]:
            made[other] = _cut(made[other], made[one], precision)
    return made


def _cut(box: ImportedBox, other: ImportedBox, precision: Fraction) -> ImportedBox:
    """A box, without what reaches into another one by no more than the precision along x or y."""
    own, its = outline(box), outline(other)
    overlaps = [own.half[i] + its.half[i] - abs(own.centre[i] - its.centre[i]) for i in (0, 1)]
    axis = 0 if overlaps[0] <= overlaps[1] else 1
    depth = overlaps[axis]
    if not 0 < depth <= precision or depth >= own.half[axis]:
        return box
    away = 1 if own.centre[axis] >= its.centre[axis] else -1
    centre, size = list(box.centre), list(box.size)
    centre[axis] += away * depth / 2
    size[axis if box.turn[2] % (2 * RIGHT_ANGLE) == 0 else 1 - axis] -= depth
    return replace(box, centre=(centre[0], centre[1], centre[2]), size=(size[0], size[1], size[2]))
