"""Friction by pair in MuJoCo: priorities of geoms, and explicit pairs.

The geom with the higher priority sets the friction of two geoms; with equal priorities the larger coefficient counts.
So a law that takes the lower coefficient needs priorities that rise with smoothness. Explicit pairs set all other
coefficients, at a cost that grows with their number.
"""

from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement

from stability.contact_law import Friction, Surface
from stability.model import BodyId, Plane

ON_PLANES = 1  # priority of planes: bricks with their own friction have a higher one, other bricks a lower one


@dataclass(frozen=True, slots=True)
class GeomFriction:
    """Friction and priority of a geom."""

    friction: float
    priority: int = 0


@dataclass(frozen=True, slots=True)
class PairFrictions:
    """Friction of all geoms, and the explicit pairs."""

    shapes: Mapping[BodyId, GeomFriction]
    pairs: Sequence[tuple[BodyId, BodyId, float]]


def pair_frictions(law: Friction, planes: Collection[Plane], bricks: Sequence[BodyId]) -> PairFrictions:
    """Return the friction of geoms and pairs that gives bricks and planes the coefficients of a law."""
    geoms: dict[BodyId, GeomFriction] = {plane.id: GeomFriction(plane.friction, ON_PLANES) for plane in planes}
    if not law.differs:
        return PairFrictions(geoms | dict.fromkeys(bricks, GeomFriction(law.usual)), ())
    by_surface: dict[Surface, list[BodyId]] = defaultdict(list)
    for brick in bricks:
        by_surface[law.surface_of(brick)].append(brick)
    smoothest_last = sorted({surface.own for surface in by_surface if surface.own is not None}, reverse=True)
    for surface, members in by_surface.items():
        rubbing = GeomFriction(law.usual)
        if surface.own is not None:
            rubbing = GeomFriction(surface.own, ON_PLANES + 1 + smoothest_last.index(surface.own))
        geoms |= dict.fromkeys(members, rubbing)
    groups = list(by_surface.values())
    return PairFrictions(geoms, [*_between(law, groups, geoms), *_on_planes(law, groups, planes, geoms)])


def _between(
    law: Friction, groups: Sequence[Sequence[BodyId]], geoms: Mapping[BodyId, GeomFriction]
) -> Iterator[tuple[BodyId, BodyId, float]]:
    for ones, others in combinations_with_replacement(groups, 2):
        if ones is others and len(ones) == 1:
            continue
        requested = law.of(ones[0], others[-1])
        if requested != _combined(geoms[ones[0]], geoms[others[-1]]):
            yield from (
                (first, second, requested)
                for first in ones
                for second in others
                if ones is not others or first < second
            )


def _on_planes(
    law: Friction, groups: Sequence[Sequence[BodyId]], planes: Collection[Plane], geoms: Mapping[BodyId, GeomFriction]
) -> Iterator[tuple[BodyId, BodyId, float]]:
    for plane in planes:
        for members in groups:
            requested = law.on(members[0], plane)
            if requested != _combined(geoms[plane.id], geoms[members[0]]):
                yield from ((plane.id, brick, requested) for brick in members)


def _combined(first: GeomFriction, second: GeomFriction) -> float:
    """Return the coefficient that MuJoCo uses for two geoms."""
    if first.priority == second.priority:
        return max(first.friction, second.friction)
    return max(first, second, key=lambda rubbing: rubbing.priority).friction
