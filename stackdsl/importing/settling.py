"""Boxes of a file brought into contact with what is below them: files are measured, and not ideal.

A box is above another one if their outlines in plan overlap by more than the precision of the file, and its lower face
is no more than that precision below the upper face of the other. Sideways nothing moves; of two that overlap by no more
than the precision, the later one is taken as so much shorter. What is deeper inside another box stays as it is.

`down` lowers each box, from the lowest on, until it touches. `within` a gap lets a box touch all that is that close
below it: these upper faces and its lower face come to one height, so boxes that were a little too low are taken as a
little higher than they are written, and nothing is lower than it stands on. Masses stay as they are.
"""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import inf
from typing import Final

from stackdsl.importing.load import ImportedBox, ImportedLoad
from stackdsl.importing.plan import close_in_plan, outline, overlap_in_plan
from stackdsl.importing.trimming import trim
from stackdsl.language.imports import Settle

GROUND: Final = -1  # the number of what is below all boxes
ROUNDED: Final = 1e-9  # [m] how far doubles may be off, of what is within 10 km


@dataclass(frozen=True, slots=True)
class Settled:
    """A load after it settled, and what that changed, box by box."""

    load: ImportedLoad
    moved: tuple[Fraction, ...]  # up, or down if negative [m]
    grown: tuple[Fraction, ...]  # how much higher each is than it is written [m]
    trimmed: tuple[Fraction, ...]  # how much its length or width is less than written [m]


@dataclass(frozen=True, slots=True)
class _Gap:
    """How far a box is above another one, or above the ground [m]; less than nothing within the file's precision."""

    upper: int
    lower: int
    size: Fraction


def settled(load: ImportedLoad, how: Settle) -> Settled:
    """The load as its boxes stand in the end; only upright boxes settle (see `cannot_settle`)."""
    if not how.lowered and how.within is None:
        still = tuple(Fraction(0) for _ in load.boxes)
        return Settled(load, still, still, still)
    trimmed = trim(load.boxes, load.precision)
    gaps = _gaps(trimmed, load.precision, inf if how.within is None else how.within)
    bottoms, tops = _lowered(trimmed, gaps) if how.within is None else _levelled(trimmed, gaps)
    boxes = tuple(_stood(box, low, high) for box, low, high in zip(trimmed, bottoms, tops, strict=True))
    return Settled(
        replace(load, boxes=boxes),
        tuple(new.bottom - old.bottom for new, old in zip(boxes, load.boxes, strict=True)),
        tuple(new.size[2] - old.size[2] for new, old in zip(boxes, load.boxes, strict=True)),
        tuple(sum(old.size[:2], -sum(new.size[:2], Fraction(0))) for new, old in zip(boxes, load.boxes, strict=True)),
    )


def cannot_settle(load: ImportedLoad, how: Settle) -> ImportedBox | None:
    """The first box that leans, where boxes are to settle: how it would touch is not known from its height."""
    if not how.lowered and how.within is None:
        return None
    return next((box for box in load.boxes if not box.is_upright), None)


def _stood(box: ImportedBox, bottom: Fraction, top: Fraction) -> ImportedBox:
    length, width, _ = box.size
    x, y, _ = box.centre
    return replace(box, size=(length, width, top - bottom), centre=(x, y, (bottom + top) / 2))


def _upwards(boxes: Sequence[ImportedBox]) -> list[int]:
    return sorted(range(len(boxes)), key=lambda number: (boxes[number].bottom, number))


def _gaps(boxes: Sequence[ImportedBox], precision: Fraction, widest: float | Fraction) -> list[_Gap]:
    """What each box is above, and by how much, if that is not more than `widest`; nothing of what is inside another."""
    outlines = [outline(box) for box in boxes]
    bottoms, tops = [box.bottom for box in boxes], [box.top for box in boxes]
    low, high = list(map(float, bottoms)), list(map(float, tops))
    found = [_Gap(upper, GROUND, bottom) for upper, bottom in enumerate(bottoms) if -precision <= bottom <= widest]
    inside, limit = set[int](), float(widest) + ROUNDED
    for one, other in close_in_plan(outlines):
        lower, upper = (one, other) if (low[one], one) < (low[other], other) else (other, one)
        if low[upper] - high[lower] > limit:  # the exact comparison is dear
            continue
        gap = bottoms[upper] - tops[lower]
        if gap <= widest and overlap_in_plan(outlines[upper], outlines[lower]) > precision:
            if gap < -precision:
                inside.add(upper)
            else:
                found.append(_Gap(upper, lower, gap))
    return [gap for gap in found if gap.upper not in inside]


def _lowered(boxes: Sequence[ImportedBox], gaps: Iterable[_Gap]) -> tuple[list[Fraction], list[Fraction]]:
    """Lower and upper faces when each box lies on the highest that it is above."""
    below: defaultdict[int, list[int]] = defaultdict(list)
    for gap in gaps:
        below[gap.upper].append(gap.lower)
    bottoms, tops = [box.bottom for box in boxes], [box.top for box in boxes]
    for number in _upwards(boxes):
        if below[number]:
            bottoms[number] = max(Fraction(0) if lower == GROUND else tops[lower] for lower in below[number])
            tops[number] = bottoms[number] + boxes[number].size[2]
    return bottoms, tops


# --- levelling --------------------------------------------------------------------------------------------------------


class _Levels:
    """Heights that are one: those of faces that touch. The ground is one, and no box may end where it begins."""

    def __init__(self, boxes: Sequence[ImportedBox]) -> None:
        self._boxes = boxes
        self._level: dict[tuple[int, str], tuple[int, str]] = {}

    def of(self, face: tuple[int, str]) -> tuple[int, str]:
        """The face that stands for all of its height."""
        while (other := self._level.get(face, face)) != face:
            face = other
        return face

    def join(self, gap: _Gap) -> tuple[int, str] | None:
        """Let an upper face and the lower face above it be of one height; what `part` takes apart again."""
        one, other = self.of((gap.lower, "top")), self.of((gap.upper, "bottom"))
        if one == other:
            return None
        self._level[other] = one
        return other

    def part(self, joined: tuple[int, str]) -> None:
        """Undo the last `join`."""
        del self._level[joined]

    def order(self) -> list[tuple[tuple[int, str], list[int]]] | None:
        """The heights from the lowest on, and the boxes that end there; None if they go round in a circle."""
        ending: defaultdict[tuple[int, str], list[int]] = defaultdict(list)
        rising: defaultdict[tuple[int, str], list[int]] = defaultdict(list)
        for number in range(len(self._boxes)):
            ending[self.of((number, "top"))].append(number)
            rising[self.of((number, "bottom"))].append(number)
        left = {level: len(ending[level]) for level in {*ending, *rising}}
        free = sorted(level for level, count in left.items() if not count)
        found = []
        while free:
            level = free.pop()
            found.append((level, ending[level]))
            for number in rising[level]:
                above = self.of((number, "top"))
                left[above] -= 1
                if not left[above]:
                    free.append(above)
        return found if len(found) == len(left) else None


def _levelled(boxes: Sequence[ImportedBox], contacts: Sequence[_Gap]) -> tuple[list[Fraction], list[Fraction]]:
    """Lower and upper faces when all that touch are of one height, as low as that can be."""
    levels = _joined(boxes, contacts)
    held: dict[tuple[int, str], Fraction] = {levels.of((GROUND, "top")): Fraction(0)}
    touching = {gap.upper for gap in contacts}
    for number, box in enumerate(boxes):
        if number not in touching:  # it stays where it is written
            level = levels.of((number, "bottom"))
            held[level] = max(held.get(level, box.bottom), box.bottom)
    heights = _heights(boxes, levels, held)
    faces = range(len(boxes))
    return [heights[levels.of((n, "bottom"))] for n in faces], [heights[levels.of((n, "top"))] for n in faces]


def _joined(boxes: Sequence[ImportedBox], contacts: Sequence[_Gap]) -> _Levels:
    """The heights when all touch that can: not those whose box would have to be flat, the widest gaps first."""
    levels = _Levels(boxes)
    for gap in contacts:
        levels.join(gap)
    if levels.order() is not None:
        return levels
    levels = _Levels(boxes)  # boxes as thin as the gaps are there, so one contact after the other
    for gap in sorted(contacts, key=lambda gap: (gap.size, gap.upper, gap.lower)):
        joined = levels.join(gap)
        if joined is not None and levels.order() is None:
            levels.part(joined)
    return levels


def _heights(
    boxes: Sequence[ImportedBox], levels: _Levels, held: Mapping[tuple[int, str], Fraction]
) -> dict[tuple[int, str], Fraction]:
    heights: dict[tuple[int, str], Fraction] = {}
    for level, ending in levels.order() or ():
        reached = [heights[levels.of((number, "bottom"))] + boxes[number].size[2] for number in ending]
        heights[level] = max([*reached, *([held[level]] if level in held else [])])
    return heights
