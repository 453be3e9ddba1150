"""Levels and names: by place, such as `L3.2`, unless the author gives his own."""

from collections import Counter
from collections.abc import Mapping, Sequence
from math import inf
from types import MappingProxyType

from stability.model import BodyId, Plane
from stackdsl.compiling.fitting import Fit, Sited, fits
from stackdsl.compiling.written_bricks import WrittenBrick


def footings_of(
    written: Sequence[WrittenBrick], planes: Sequence[Plane], removed_in: Mapping[int, int] = MappingProxyType({})
) -> list[Fit]:
    """What every brick stands on, for judging levels; nothing where layouts, which know theirs, are all there is.

    `removed_in` says of bricks, by number, in which step they are pulled out.
    """
    if all(brick.of_layout for brick in written):
        return [Fit() for _ in written]
    # What a brick stands on does not depend on the clock, only on what the author put before it or in the same step.
    sited = [
        Sited(float(brick.step), brick.shape, brick.pose, until=float(removed_in.get(index, inf)))
        for index, brick in enumerate(written)
    ]
    return fits(sited, planes)


def levels_of(written: Sequence[WrittenBrick], footings: Sequence[Fit]) -> list[int]:
    """The level of every brick: as written, or one above the highest that it stands on."""
    levels: dict[int, int] = {}
    for index in sorted(range(len(written)), key=lambda index: written[index].pose.position_W[2]):
        below = [levels[other] for other in footings[index].on_boxes if other in levels]
        levels[index] = written[index].level or max(below, default=0) + 1
    return [levels[index] for index in range(len(written))]


def names_of(written: Sequence[WrittenBrick], levels: Sequence[int]) -> list[BodyId]:
    """The author's names, and `L3.2` for the second brick of level 3 in the author's order."""
    counts: Counter[tuple[str, int]] = Counter()
    names = []
    for brick, level in zip(written, levels, strict=True):
        place = f"{brick.within}." if brick.within else ""
        counts[place, level] += 1
        names.append(brick.name or f"{place}L{level}.{counts[place, level]}")
    return names
