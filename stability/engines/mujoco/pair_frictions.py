"""Friction that differs from pair to pair, in the terms of MuJoCo: priorities, and pairs that are named one by one.

Of two shapes the one with the higher priority says what friction they have, and of two with the same the larger
coefficient counts. So the lower of two is had by priorities, the smoother the higher. What they do not give is said of
the pair itself: that gives anything, at a price that grows with the number of pairs.
"""

from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement

from stability.contact_law import Friction, Surface
from stability.model import BodyId, Plane

ON_PLANES = 1  # the priority of planes: what has friction of its own has a higher one, all else a lower one


@dataclass(frozen=True, slots=True)
class Rubbing:
    """What MuJoCo is told of one shape."""

    friction: float
    priority: int = 0


@dataclass(frozen=True, slots=True)
class PairFrictions:
    """What is told of each shape, and of which pairs something else."""

    shapes: Mapping[BodyId, Rubbing]
    pairs: Sequence[tuple[BodyId, BodyId, float]]


def pair_frictions(law: Friction, planes: Collection[Plane], bricks: Sequence[BodyId]) -> PairFrictions:
    """How bricks and planes have the frictions of a law."""
    told: dict[BodyId, Rubbing] = {plane.id: Rubbing(plane.friction, ON_PLANES) for plane in planes}
    if not law.differs:
        return PairFrictions(told | dict.fromkeys(bricks, Rubbing(law.usual)), ())
    alike: dict[Surface, list[BodyId]] = defaultdict(list)
    for brick in bricks:
        alike[law.surface_of(brick)].append(brick)
    smoothest_last = sorted({surface.own for surface in alike if surface.own is not None}, reverse=True)
    for surface, members in alike.items():
        rubbing = Rubbing(law.usual)
        if surface.own is not None:
            rubbing = Rubbing(surface.own, ON_PLANES + 1 + smoothest_last.index(surface.own))
        told |= dict.fromkeys(members, rubbing)
    groups = list(alike.values())
    return PairFrictions(told, [*_between(law, groups, told), *_on_planes(law, groups, planes, told)])


def _between(
    law: Friction, groups: Sequence[Sequence[BodyId]], told: Mapping[BodyId, Rubbing]
) -> Iterator[tuple[BodyId, BodyId, float]]:
    for ones, others in combinations_with_replacement(groups, 2):
        if ones is others and len(ones) == 1:
            continue
        asked = law.of(ones[0], others[-1])
        if asked != _had(told[ones[0]], told[others[-1]]):
            yield from ((one, other, asked) for one in ones for other in others if ones is not others or one < other)


def _on_planes(
    law: Friction, groups: Sequence[Sequence[BodyId]], planes: Collection[Plane], told: Mapping[BodyId, Rubbing]
) -> Iterator[tuple[BodyId, BodyId, float]]:
    for plane in planes:
        for members in groups:
            asked = law.on(members[0], plane)
            if asked != _had(told[plane.id], told[members[0]]):
                yield from ((plane.id, brick, asked) for brick in members)


def _had(one: Rubbing, other: Rubbing) -> float:
    """What MuJoCo makes of two."""
    if one.priority == other.priority:
        return max(one.friction, other.friction)
    return max(one, other, key=lambda rubbing: rubbing.priority).friction
