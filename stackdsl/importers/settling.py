"""Brings imported boxes into contact with what is below them, and trims small overlaps."""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import cos, hypot, inf, radians, sin
from typing import Final

from stability.geometry.spatial_grid import Neighbours
from stability.model import Vec3
from stackdsl.importers.load import ImportedBox, ImportedLoad, digits
from stackdsl.language.imports import Settle

# Outlines of upright boxes seen from above, and by how much two of them overlap.


RIGHT_ANGLE: Final = 90  # [deg]


@dataclass(frozen=True, slots=True)
class PlanRectangle:
    """A rectangle in plan: centre, half its sides, and the direction of the first of them."""

    centre: tuple[Fraction, Fraction]  # [m]
    half: tuple[Fraction, Fraction]  # [m]
    axis: tuple[float, float] | None  # None if sides are along x and y


def outline(box: ImportedBox) -> PlanRectangle:
    """The outline of an upright box."""
    length, width, _ = (side / 2 for side in box.size)
    yaw = box.turn[2]
    centre = box.centre[:2]
    if yaw % RIGHT_ANGLE == 0:
        return PlanRectangle(centre, (length, width) if yaw % (2 * RIGHT_ANGLE) == 0 else (width, length), None)
    return PlanRectangle(centre, (length, width), (cos(radians(yaw)), sin(radians(yaw))))


def overlap_in_plan(one: PlanRectangle, other: PlanRectangle) -> Fraction:
    """How far one would have to move to lie beside the other [m]; not more than zero if it does."""
    if one.axis is None and other.axis is None:
        return min(one.half[i] + other.half[i] - abs(one.centre[i] - other.centre[i]) for i in (0, 1))
    apart = [float(one.centre[i] - other.centre[i]) for i in (0, 1)]
    overlaps = []
    for x, y in (*_axes(one), *_axes(other)):
        overlaps.append(_reach(one, x, y) + _reach(other, x, y) - abs(apart[0] * x + apart[1] * y))
    return Fraction(min(overlaps))


def close_in_plan(outlines: Sequence[PlanRectangle]) -> Iterator[tuple[int, int]]:
    """The pairs whose bounds overlap in plan, by number, each once: a superset of those that overlap."""
    there: Neighbours[int] = Neighbours()
    for number, one in enumerate(outlines):
        low, high = _bounds(one)
        yield from ((other, number) for other in there.around(low, high, 0.0))
        there.add(number, low, high)


def _bounds(one: PlanRectangle) -> tuple[Vec3, Vec3]:
    x, y = (float(part) for part in one.centre)
    along_x, along_y = _reach(one, 1.0, 0.0), _reach(one, 0.0, 1.0)
    return (x - along_x, y - along_y, 0.0), (x + along_x, y + along_y, along_x)  # all at one height


def _axes(one: PlanRectangle) -> tuple[tuple[float, float], tuple[float, float]]:
    x, y = one.axis or (1.0, 0.0)
    return (x, y), (-y, x)


def _reach(one: PlanRectangle, x: float, y: float) -> float:
    """How far an outline reaches from its centre along a direction."""
    return sum(
        float(half) * abs(x * ax + y * ay) / hypot(x, y) for half, (ax, ay) in zip(one.half, _axes(one), strict=True)
    )


# Boxes of a file that overlap sideways by no more than its precision: of each two, the later one is cut.


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


# Boxes of a file brought into contact with what is below them: files are measured, and not ideal.
#
# A box is above another one if their outlines in plan overlap by more than the precision of the file, and its lower
# face is no more than that precision below the upper face of the other. Sideways nothing moves; of two that overlap by
# no more than the precision, the later one is taken as so much shorter. What is deeper inside another box stays as it
# is.
#
# `down` lowers each box, from the lowest on, until it touches. `within` a gap lets a box touch all that is that close
# below it: these upper faces and its lower face come to one height, so boxes that were a little too low are taken as a
# little higher than they are written, and nothing is lower than it stands on. Masses stay as they are.


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


# What settling changed, in words.


def moved_lines(settled: Settled) -> Iterator[str]:
    """A line for each kind of change, with the box that it changed most."""
    boxes = settled.load.boxes
    names = [box.name or f"the box of line {box.span.line}" for box in boxes]
    lowered, raised = [max(-way, Fraction(0)) for way in settled.moved], [max(w, Fraction(0)) for w in settled.moved]
    changes = {"lowered": lowered, "raised": raised, "taken as higher": settled.grown}
    for done, ways in {**changes, "taken as shorter sideways": settled.trimmed}.items():
        if any(ways):
            yield _line(done, ways, names)
    if not any(any(ways) for ways in (*changes.values(), settled.trimmed)):
        yield f"none of {len(boxes)} boxes was moved"


def _line(done: str, ways: Sequence[Fraction], names: Sequence[str]) -> str:
    most = max(ways)
    count = sum(way > 0 for way in ways)
    what = f"{count} of {len(ways)} boxes {'was' if count == 1 else 'were'} {done}"
    return f"{what}, {names[list(ways).index(most)]} most: by {digits(1000 * most)} mm"
