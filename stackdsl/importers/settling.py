"""Brings imported boxes into contact with the boxes or the ground below them, and trims small overlaps."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import cos, hypot, inf, radians, sin
from typing import Final

from stability.geometry.spatial_grid import Neighbours
from stability.model import Vec3
from stackdsl.importers.load import ImportedBox, ImportedLoad, digits
from stackdsl.language.imports import Settle

# Outlines of upright boxes in plan, and their overlaps.


RIGHT_ANGLE: Final = 90  # [deg]


@dataclass(frozen=True, slots=True)
class PlanRectangle:
    """A rectangle in plan."""

    centre: tuple[Fraction, Fraction]  # [m]
    half: tuple[Fraction, Fraction]  # half of the sides [m]
    axis: tuple[float, float] | None  # direction of the first side; None if the sides are along x and y


def outline(box: ImportedBox) -> PlanRectangle:
    """Return the outline of an upright box."""
    length, width, _ = (side / 2 for side in box.size)
    yaw = box.turn[2]
    centre = box.centre[:2]
    if yaw % RIGHT_ANGLE == 0:
        return PlanRectangle(centre, (length, width) if yaw % (2 * RIGHT_ANGLE) == 0 else (width, length), None)
    return PlanRectangle(centre, (length, width), (cos(radians(yaw)), sin(radians(yaw))))


def overlap_in_plan(one: PlanRectangle, other: PlanRectangle) -> Fraction:
    """Return the least translation that separates two rectangles [m]; at most zero if they are separate."""
    if one.axis is None and other.axis is None:
        return min(one.half[i] + other.half[i] - abs(one.centre[i] - other.centre[i]) for i in (0, 1))
    apart = [float(one.centre[i] - other.centre[i]) for i in (0, 1)]
    overlaps = []
    for x, y in (*_axes(one), *_axes(other)):
        overlaps.append(_reach(one, x, y) + _reach(other, x, y) - abs(apart[0] * x + apart[1] * y))
    return Fraction(min(overlaps))


def close_in_plan(
    outlines: Sequence[PlanRectangle], on_share: Callable[[float], None] = lambda _: None
) -> Iterator[tuple[int, int]]:
    """Yield the pairs of indices whose bounding boxes overlap in plan, each once: a superset of those that overlap."""
    grid: Neighbours[int] = Neighbours()
    for number, one in enumerate(outlines):
        low, high = _bounds(one)
        yield from ((other, number) for other in grid.around(low, high, 0.0))
        on_share((number + 1) / len(outlines))
        grid.add(number, low, high)


def _bounds(rectangle: PlanRectangle) -> tuple[Vec3, Vec3]:
    x, y = (float(part) for part in rectangle.centre)
    along_x, along_y = _reach(rectangle, 1.0, 0.0), _reach(rectangle, 0.0, 1.0)
    return (x - along_x, y - along_y, 0.0), (x + along_x, y + along_y, along_x)  # heights that all overlap


def _axes(rectangle: PlanRectangle) -> tuple[tuple[float, float], tuple[float, float]]:
    x, y = rectangle.axis or (1.0, 0.0)
    return (x, y), (-y, x)


def _reach(rectangle: PlanRectangle, x: float, y: float) -> float:
    """Return half the extent of a rectangle along a direction [m]."""
    return sum(
        float(half) * abs(x * ax + y * ay) / hypot(x, y)
        for half, (ax, ay) in zip(rectangle.half, _axes(rectangle), strict=True)
    )


# Horizontal overlaps of at most the precision of the file. Of two such boxes, the later one is shortened.


def trim(
    boxes: Sequence[ImportedBox], precision: Fraction, on_share: Callable[[float], None] = lambda _: None
) -> list[ImportedBox]:
    """Return the boxes without such overlaps; boxes that are not turned by a right angle stay unchanged."""
    trimmed = list(boxes)
    square = [box.turn[2] % RIGHT_ANGLE == 0 for box in boxes]
    low, high = [float(box.bottom) for box in boxes], [float(box.top) for box in boxes]
    for one, other in close_in_plan([outline(box) for box in boxes], on_share):
        beside = min(high[one], high[other]) - max(low[one], low[other]) > precision
        if beside and square[one] and square[other]:
            trimmed[other] = _cut(trimmed[other], trimmed[one], precision)
    return trimmed


def _cut(box: ImportedBox, other: ImportedBox, precision: Fraction) -> ImportedBox:
    """Shorten a box by its overlap with another along x or y, if that is at most the precision."""
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


# Contact between boxes whose heights were measured, so that gaps and small overlaps occur.
#
# A box is above another if their outlines in plan overlap by more than the precision of the file, and its lower face is
# at most that precision below the upper face of the other. A box that is deeper inside another stays unchanged. No box
# moves sideways.
#
# `down` lowers each box, from the lowest on, until it touches a box or the ground. `within` a gap lets a box touch all
# boxes that are that close below it: it gives these upper faces and its lower face one height, by making boxes that end
# too low a little taller. No box is then lower than one of its supports. Masses do not change.


GROUND: Final = -1  # index of the ground
ROUNDED: Final = 1e-9  # [m] rounding error of doubles up to 10 km


@dataclass(frozen=True, slots=True)
class SettledLoad:
    """A settled load, and the changes of each box."""

    load: ImportedLoad
    moved: tuple[Fraction, ...]  # upwards [m]
    grown: tuple[Fraction, ...]  # increase of the height [m]
    trimmed: tuple[Fraction, ...]  # decrease of the length or width [m]


@dataclass(frozen=True, slots=True)
class _Gap:
    """The gap between a box and another box or the ground below it."""

    upper: int
    lower: int
    size: Fraction  # [m]; negative for an overlap of at most the precision


def settled(
    load: ImportedLoad,
    settle: Settle,
    on_share: Callable[[float], None] = lambda _: None,
    supports: Sequence[ImportedBox] = (),
) -> SettledLoad:
    """Settle a load on the ground and on upright boxes that stay where they are, such as the deck of its pallet.

    All boxes must be upright (see `first_unsettleable`). `on_share` is called with the share of the boxes that are
    compared with their neighbours.
    """
    if not settle.lowered and settle.within is None:
        still = tuple(Fraction(0) for _ in load.boxes)
        return SettledLoad(load, still, still, still)
    trimmed = trim(load.boxes, load.precision, lambda share: on_share(share / 2))
    widest = inf if settle.within is None else settle.within
    every, count = [*trimmed, *supports], len(trimmed)
    gaps = _gaps(every, count, load.precision, widest, lambda share: on_share((1 + share) / 2))
    bottoms, tops = _lowered(every, gaps) if settle.within is None else _levelled(every, count, gaps)
    heights = zip(trimmed, bottoms[:count], tops[:count], strict=True)
    boxes = tuple(_between(box, low, high) for box, low, high in heights)
    return SettledLoad(
        replace(load, boxes=boxes),
        tuple(new.bottom - old.bottom for new, old in zip(boxes, load.boxes, strict=True)),
        tuple(new.size[2] - old.size[2] for new, old in zip(boxes, load.boxes, strict=True)),
        tuple(sum(old.size[:2], -sum(new.size[:2], Fraction(0))) for new, old in zip(boxes, load.boxes, strict=True)),
    )


def first_unsettleable(load: ImportedLoad, settle: Settle) -> ImportedBox | None:
    """Return the first box that is not upright, if boxes shall settle: its contacts do not follow from its height."""
    if not settle.lowered and settle.within is None:
        return None
    return next((box for box in load.boxes if not box.is_upright), None)


def _between(box: ImportedBox, bottom: Fraction, top: Fraction) -> ImportedBox:
    length, width, _ = box.size
    x, y, _ = box.centre
    return replace(box, size=(length, width, top - bottom), centre=(x, y, (bottom + top) / 2))


def _upwards(boxes: Sequence[ImportedBox]) -> list[int]:
    return sorted(range(len(boxes)), key=lambda number: (boxes[number].bottom, number))


def _gaps(
    boxes: Sequence[ImportedBox],
    count: int,
    precision: Fraction,
    widest: float | Fraction,
    on_share: Callable[[float], None],
) -> list[_Gap]:
    """Return the gaps of at most `widest` below each of the first `count` boxes; none for a box inside another.

    The boxes from `count` on are supports.
    """
    outlines = [outline(box) for box in boxes]
    bottoms, tops = [box.bottom for box in boxes], [box.top for box in boxes]
    low, high = list(map(float, bottoms)), list(map(float, tops))
    gaps = [
        _Gap(upper, GROUND, bottom) for upper, bottom in enumerate(bottoms[:count]) if -precision <= bottom <= widest
    ]
    inside, limit = set[int](), float(widest) + ROUNDED
    for one, other in close_in_plan(outlines, on_share):
        lower, upper = (one, other) if (low[one], one) < (low[other], other) else (other, one)
        if upper >= count or low[upper] - high[lower] > limit:  # saves the slow exact comparison
            continue
        gap = bottoms[upper] - tops[lower]
        if gap <= widest and overlap_in_plan(outlines[upper], outlines[lower]) > precision:
            if gap < -precision:
                inside.add(upper)
            else:
                gaps.append(_Gap(upper, lower, gap))
    return [gap for gap in gaps if gap.upper not in inside]


def _lowered(boxes: Sequence[ImportedBox], gaps: Iterable[_Gap]) -> tuple[list[Fraction], list[Fraction]]:
    """Return the heights of lower and upper faces when each box rests on the highest upper face below it."""
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
    """Sets of faces at one height (union-find): faces in contact share a level. The ground is one of these faces."""

    def __init__(self, boxes: Sequence[ImportedBox]) -> None:
        self._boxes = boxes
        self._level: dict[tuple[int, str], tuple[int, str]] = {}

    def of(self, face: tuple[int, str]) -> tuple[int, str]:
        """Return the representative face of the level of a face."""
        while (other := self._level.get(face, face)) != face:
            face = other
        return face

    def join(self, gap: _Gap) -> tuple[int, str] | None:
        """Merge the levels of the two faces of a gap; return the token that undoes it, None if they were one level."""
        one, other = self.of((gap.lower, "top")), self.of((gap.upper, "bottom"))
        if one == other:
            return None
        self._level[other] = one
        return other

    def part(self, joined: tuple[int, str]) -> None:
        """Undo the last `join`."""
        del self._level[joined]

    def order(self) -> list[tuple[tuple[int, str], list[int]]] | None:
        """Return the levels from the lowest on, with the boxes whose tops are there; None if they form a cycle.

        In a cycle, some box would have no height.
        """
        ending: defaultdict[tuple[int, str], list[int]] = defaultdict(list)
        rising: defaultdict[tuple[int, str], list[int]] = defaultdict(list)
        for number in range(len(self._boxes)):
            ending[self.of((number, "top"))].append(number)
            rising[self.of((number, "bottom"))].append(number)
        remaining = {level: len(ending[level]) for level in {*ending, *rising}}
        ready = sorted(level for level, count in remaining.items() if not count)
        ordered = []
        while ready:
            level = ready.pop()
            ordered.append((level, ending[level]))
            for number in rising[level]:
                above = self.of((number, "top"))
                remaining[above] -= 1
                if not remaining[above]:
                    ready.append(above)
        return ordered if len(ordered) == len(remaining) else None


def _levelled(
    boxes: Sequence[ImportedBox], count: int, contacts: Sequence[_Gap]
) -> tuple[list[Fraction], list[Fraction]]:
    """Return the lowest heights of lower and upper faces at which all faces in contact are level.

    The boxes from `count` on are supports, which keep their heights.
    """
    # Of several supports below a box, the highest carries it.
    highest: dict[int, Fraction] = {}
    for gap in contacts:
        if not 0 <= gap.lower < count:
            highest[gap.upper] = min(highest.get(gap.upper, gap.size), gap.size)
    kept = [gap for gap in contacts if 0 <= gap.lower < count or gap.size == highest[gap.upper]]
    levels = _joined(boxes, count, kept)
    heights = _heights(boxes, levels, _least(boxes, levels, kept))
    faces = range(len(boxes))
    return [heights[levels.of((n, "bottom"))] for n in faces], [heights[levels.of((n, "top"))] for n in faces]


def _least(boxes: Sequence[ImportedBox], levels: _Levels, contacts: Sequence[_Gap]) -> dict[tuple[int, str], Fraction]:
    """Return the least heights of levels: those of the ground and of boxes that touch nothing below them."""
    least: dict[tuple[int, str], Fraction] = {levels.of((GROUND, "top")): Fraction(0)}
    touching = {gap.upper for gap in contacts}
    for number, box in enumerate(boxes):
        if number not in touching:  # it keeps its written height
            level = levels.of((number, "bottom"))
            least[level] = max(least.get(level, box.bottom), box.bottom)
    return least


def _joined(boxes: Sequence[ImportedBox], count: int, contacts: Sequence[_Gap]) -> _Levels:
    """Close all gaps; if that is impossible, close gaps from the smallest on where possible.

    It is impossible if some box would have no height then, or if a support from `count` on would have to grow.
    """
    levels = _Levels(boxes)
    for gap in contacts:
        levels.join(gap)
    if _is_possible(boxes, count, levels, contacts):
        return levels
    levels = _Levels(boxes)  # some box is as thin as a gap
    for gap in sorted(contacts, key=lambda gap: (gap.size, gap.upper, gap.lower)):
        joined = levels.join(gap)
        if joined is not None and not _is_possible(boxes, count, levels, contacts):
            levels.part(joined)
    return levels


def _is_possible(boxes: Sequence[ImportedBox], count: int, levels: _Levels, contacts: Sequence[_Gap]) -> bool:
    """Return whether all boxes have a height, and the supports that of their boxes."""
    if levels.order() is None:
        return False
    if count == len(boxes):
        return True
    heights = _heights(boxes, levels, _least(boxes, levels, contacts))
    supports = range(count, len(boxes))
    return all(heights[levels.of((number, "top"))] == boxes[number].top for number in supports)


def _heights(
    boxes: Sequence[ImportedBox], levels: _Levels, least: Mapping[tuple[int, str], Fraction]
) -> dict[tuple[int, str], Fraction]:
    heights: dict[tuple[int, str], Fraction] = {}
    for level, ending in levels.order() or ():
        reached = [heights[levels.of((number, "bottom"))] + boxes[number].size[2] for number in ending]
        heights[level] = max([*reached, *([least[level]] if level in least else [])])
    return heights


# Text about the changes made by settling.


def moved_lines(settled: SettledLoad) -> Iterator[str]:
    """Yield one line per kind of change, with the box that changed most."""
    boxes = settled.load.boxes
    names = [box.name or f"the box in line {box.span.line}" for box in boxes]
    lowered, raised = (
        [max(-amount, Fraction(0)) for amount in settled.moved],
        [max(amount, Fraction(0)) for amount in settled.moved],
    )
    changes = {"lowered": lowered, "raised": raised, "increased in height": settled.grown}
    for change, amounts in {**changes, "reduced in length or width": settled.trimmed}.items():
        if any(amounts):
            yield _line(change, amounts, names)
    if not any(any(amounts) for amounts in (*changes.values(), settled.trimmed)):
        yield f"no box was moved ({len(boxes)} boxes)"


def _line(change: str, amounts: Sequence[Fraction], names: Sequence[str]) -> str:
    most = max(amounts)
    count = sum(amount > 0 for amount in amounts)
    changed = f"{count} of {len(amounts)} boxes {'was' if count == 1 else 'were'} {change}"
    return f"{changed}, by at most {digits(1000 * most)} mm ({names[list(amounts).index(most)]})"
