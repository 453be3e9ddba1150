"""Levels and names: by place, such as `L3.2`, unless the author gives his own."""

from collections import Counter
from collections.abc import Mapping, Sequence
from math import inf
from types import MappingProxyType

from stability.model import BodyId, Plane
from stackdsl.compiling.fitting import CrowdedError, Fit, Sited, fits
from stackdsl.compiling.written_bricks import WrittenBrick


class CrowdedBrickError(Exception):
    """A brick has so many others near it that it takes too long to say on what it stands."""

    def __init__(self, brick: WrittenBrick) -> None:
        super().__init__(brick.path)
        self.brick = brick


def footings_of(
    written: Sequence[WrittenBrick], planes: Sequence[Plane], removed_in: Mapping[int, int] = MappingProxyType({})
) -> list[Fit]:
    """What every brick stands on, for judging levels; nothing where layouts, which know theirs, are all there is.

    `removed_in` says of bricks, by number, in which step they are pulled out. Raises CrowdedBrickError.
    """
    if all(brick.of_layout for brick in written):
        return [Fit() for _ in written]
    # What a brick stands on does not depend on the clock, only on what the author put before it or in the same step.
    sited = [
        Sited(float(brick.step), brick.shape, brick.pose, until=float(removed_in.get(index, inf)))
        for index, brick in enumerate(written)
    ]
    try:
        return fits(sited, planes)
    except CrowdedError as error:
        raise CrowdedBrickError(written[error.index]) from error


def levels_of(written: Sequence[WrittenBrick], footings: Sequence[Fit]) -> list[int]:
    """The level of every brick: as written, or one above the highest that it stands on."""
    levels: dict[int, int] = {}
    for index in sorted(range(len(written)), key=lambda index: written[index].pose.position_W[2]):
        levels[index] = written[index].level or level_above(index, footings[index], written, levels)
    return [levels[index] for index in range(len(written))]


def level_above(
    index: int, footing: Fit, written: Sequence[WrittenBrick], levels: Mapping[int, int] | Sequence[int]
) -> int:
    """The level above the highest of those that a brick stands on, as far as their centres are lower than its own."""
    height = written[index].pose.position_W[2]
    below = (other for other in footing.on_boxes if (written[other].pose.position_W[2], other) < (height, index))
    return max((levels[other] for other in below), default=0) + 1


def names_of(
    written: Sequence[WrittenBrick], levels: Sequence[int], counts: Counter[tuple[str, int]] | None = None
) -> list[BodyId]:
    """The author's names, and `L3.2` for the second brick of level 3 in the author's order."""
    counted = Counter() if counts is None else counts
    return [name_by_place(brick, level, counted) for brick, level in zip(written, levels, strict=True)]


def name_by_place(brick: WrittenBrick, level: int, counts: Counter[tuple[str, int]]) -> BodyId:
    """The name of a brick that comes after those that are counted, by step and level; it is counted, too."""
    place = f"{brick.within}." if brick.within else ""
    counts[place, level] += 1 + brick.passed
    return brick.name or f"{place}L{level}.{counts[place, level]}"
