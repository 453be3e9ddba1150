"""Friction that differs from pair to pair, in an engine that takes the mean of two coefficients.

A body has a shape for each surface that it may meet, and these two shapes, which meet each other and nothing else, both
have the coefficient of the pair. Which meet is said by collision groups: a bit for each two surfaces.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TypeAlias

from stability.friction_law import Friction, Surface
from stability.model import BodyId, Plane

Groups: TypeAlias = list[int]  # what a shape is, and what it meets
Shapes: TypeAlias = list[tuple[float, Groups]]  # of one body, each with its coefficient

BITS = 32


@dataclass
class PairShapes:
    """The shapes that bodies have so that each two of them rub as they should."""

    law: Friction
    _planes: dict[BodyId, Plane] = field(default_factory=dict, init=False)
    _known: dict[Surface, BodyId] = field(default_factory=dict, init=False)  # with one brick of each
    _bits: dict[frozenset[Surface | BodyId], int] = field(default_factory=dict, init=False)

    def of_plane(self, plane: Plane) -> Shapes:
        """Those of a plane that comes; those that it needs for what comes later are told then."""
        self._planes[plane.id] = plane
        return [(self.law.on(brick, plane), self._meets(plane.id, surface)) for surface, brick in self._known.items()]

    def of_brick(self, brick: BodyId) -> Shapes:
        """Those of a brick that comes."""
        own = self.law.surface_of(brick)
        self._known.setdefault(own, brick)
        on_bricks = [(self.law.of(brick, other), self._meets(own, each)) for each, other in self._known.items()]
        return on_bricks + [(self.law.on(brick, p), self._meets(own, p.id)) for p in self._planes.values()]

    def is_known(self, brick: BodyId) -> bool:
        """Whether something with the surface of this brick has been there."""
        return self.law.surface_of(brick) in self._known

    def for_new(self, brick: BodyId, others: Iterator[BodyId]) -> Iterator[tuple[BodyId, float, Groups]]:
        """The shapes that bodies which are there get as well, for a brick with a surface that nothing had."""
        own = self.law.surface_of(brick)
        yield from ((p.id, self.law.on(brick, p), self._meets(own, p.id)) for p in self._planes.values())
        for other in others:
            yield other, self.law.of(brick, other), self._meets(own, self.law.surface_of(other))

    def _meets(self, one: Surface | BodyId, other: Surface | BodyId) -> Groups:
        number = self._bits.setdefault(frozenset((one, other)), len(self._bits))
        if number >= BITS:
            raise ValueError(f"SAPIEN tells {BITS} pairs of surfaces apart, and here there are more")
        return [1 << number, 1 << number, 0, 0]
