"""A build whose bricks may lie beside their places: what stands of it with some bricks shifted in plan.

A brick that is shifted carries along what rests on it. Shifts are along the ground, or level where there is none.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import cos, inf, sin
from typing import TypeAlias

from stability.friction_law import GivenFriction
from stability.geometry.touching import reach_between
from stability.geometry.vectors import add, add_scaled, cross, unit
from stability.model import GROUND, BodyId, Plane, Vec3
from stability.shapes.apart import apart, apart_from_plane
from stability.statics.assembly import Assembly
from stability.statics.facts import UP, Placed, Stability, Tolerances, Verdict

EXACT = 1e-4  # of how near counts as touching: bodies that near lie on each other, but for rounding

Shift: TypeAlias = tuple[float, float]  # along the ground, towards +x and +y [m]


@dataclass(frozen=True, slots=True)
class Piling:
    """What is set down together, in order, on which fixed bodies, and what is pulled out again."""

    planes: Sequence[Plane]
    friction: GivenFriction
    gravity: float
    stages: Sequence[Sequence[Placed]]
    pulled: Mapping[int, Sequence[BodyId]] = field(default_factory=dict)  # by the number of the stage that comes next
    tolerances: Tolerances = Tolerances()  # noqa: RUF009 -- frozen

    @property
    def bricks(self) -> list[Placed]:
        """All that is ever set down."""
        return [placed for stage in self.stages for placed in stage]

    def states(self) -> Iterator[frozenset[BodyId]]:
        """What is there, after each time that something was set down or pulled out."""
        there: frozenset[BodyId] = frozenset()
        for turn, stage in enumerate(self.stages):
            if turn in self.pulled:
                there -= frozenset(self.pulled[turn])
                yield there
            if stage:
                there |= {placed.brick.id for placed in stage}
                yield there

    def there(self, turn: int) -> frozenset[BodyId]:
        """What is there with a stage, unless it is pulled out by then."""
        gone = {name for before, names in self.pulled.items() if before <= turn for name in names}
        return frozenset(placed.brick.id for stage in self.stages[: turn + 1] for placed in stage) - gone

    def carried(self) -> dict[BodyId, frozenset[BodyId]]:
        """Each brick, with all that rests on it."""
        whole = self.whole()
        return {name: frozenset(whole.with_all_above([name])) for name in whole.bricks}

    def whole(self) -> Assembly:
        """All that is ever set down, at once."""
        whole = self.assembly()
        whole.add_all(self.bricks, names_smallest=False)
        return whole

    def assembly(self) -> Assembly:
        """Nothing but what is fixed."""
        return Assembly(self.planes, self.friction, self.gravity, self.tolerances, overlap=inf)

    def shifted(self, shifts: Mapping[BodyId, Shift]) -> "Piling":
        """The same with each brick moved by its own sum of shifts."""
        along, across = self._axes()

        def moved(placed: Placed) -> Placed:
            if placed.brick.id not in shifts:
                return placed
            x, y = shifts[placed.brick.id]
            position = add_scaled(add_scaled(placed.pose.position_W, x, along), y, across)
            return replace(placed, pose=replace(placed.pose, position_W=position))

        return replace(self, stages=[[moved(placed) for placed in stage] for stage in self.stages])

    def way(self, shift: Shift) -> Vec3:
        """A shift as a vector in W [m]."""
        along, across = self._axes()
        return add(add_scaled((0.0, 0.0, 0.0), shift[0], along), add_scaled((0.0, 0.0, 0.0), shift[1], across))

    def _axes(self) -> tuple[Vec3, Vec3]:
        normal = next((plane.normal_W for plane in self.planes if plane.id == GROUND), UP)
        across = unit(cross(normal, (1.0, 0.0, 0.0)))
        return cross(across, normal), across

    def falls_at_once(self) -> bool:
        """Whether all that is there in the end is proven to fall if set down together: then it falls by then."""
        assembly = self.assembly()
        gone = {name for names in self.pulled.values() for name in names}
        last = [placed for placed in self.bricks if placed.brick.id not in gone]
        return assembly.add_all(last, names_smallest=False).stability is Stability.UNSTABLE

    def first_fall(self, upto: int | None = None, *, names_smallest: bool = False) -> tuple[int, Verdict] | None:
        """The first stage with which not all stands, of so many, and its verdict; None if all stand.

        With `names_smallest` as few bricks are named as are found to fall, which of a heap takes seconds.
        """
        assembly = self.assembly()
        for turn, stage in enumerate(self.stages[:upto]):
            if turn in self.pulled:
                verdict = assembly.remove(self.pulled[turn], names_smallest=names_smallest)
                if verdict.stability is not Stability.STABLE:
                    return turn, verdict
            if stage:
                verdict = assembly.add_all(stage, names_smallest=names_smallest)
                if verdict.stability is not Stability.STABLE:
                    return turn, verdict
        return None

    def touching(self) -> frozenset[tuple[BodyId, BodyId]]:
        """All pairs that touch, the lower first."""
        return frozenset((contact.lower, contact.upper) for contact in self.whole().all_contacts())

    def crowds(self, moved: frozenset[BodyId], touching: frozenset[tuple[BodyId, BodyId]]) -> bool:
        """Whether a brick that was moved is in another body, or grazes one that it did not touch before.

        What is so near counts as touching, and might hold by that alone.
        """
        moving = [placed for placed in self.bricks if placed.brick.id in moved]
        others = [placed for placed in self.bricks if placed.brick.id not in moved]
        times = self._times()

        def meet(one: Placed, other: Placed) -> bool:
            (come, go), (other_come, other_go) = times[one.brick.id], times[other.brick.id]
            return come < other_go and other_come < go

        return any(meet(a, b) and self._crowds(a, b, touching) for a in moving for b in others) or any(
            apart_from_plane(one.brick.shape, one.pose, plane).gap < -reach_between(one.brick.shape.least_thickness)
            for one in moving
            for plane in self.planes
        )

    def _times(self) -> dict[BodyId, tuple[int, int]]:
        """The stage with which each brick comes, and that before which it goes."""
        gone = {name: turn for turn, names in self.pulled.items() for name in names}
        return {
            placed.brick.id: (turn, gone.get(placed.brick.id, len(self.stages)))
            for turn, stage in enumerate(self.stages)
            for placed in stage
        }

    @staticmethod
    def _crowds(one: Placed, other: Placed, touching: frozenset[tuple[BodyId, BodyId]]) -> bool:
        reach = one.brick.shape.bounding_radius + other.brick.shape.bounding_radius
        near = zip(one.pose.position_W, other.pose.position_W, strict=True)
        if any(abs(a - b) > reach for a, b in near):
            return False
        deep = reach_between(one.brick.shape.least_thickness, other.brick.shape.least_thickness)
        gap = apart(one.brick.shape, one.pose, other.brick.shape, other.pose).gap
        pairs = {(one.brick.id, other.brick.id), (other.brick.id, one.brick.id)}
        return gap < -deep or (EXACT * deep < abs(gap) <= deep and not pairs & touching)


def bearing_shift(length: float, bearing: float) -> Shift:
    """So far along a bearing, from +x towards +y [rad]."""
    return length * cos(bearing), length * sin(bearing)
