"""A build whose bricks may be shifted in plan: its stages, and its falls with shifts."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf
from typing import TypeAlias

import numpy as np

from stability.contact_law import GivenFriction, as_friction
from stability.contacts.bodies import solid
from stability.contacts.detection import contacts_between, contacts_with_plane
from stability.geometry.box_distance import gap_bridged, reach_between
from stability.geometry.placed_shape import apart, apart_from_plane
from stability.geometry.vectors import add, add_scaled, cross, dot, subtract, unit
from stability.joints import DRY, Joints
from stability.model import GROUND, BodyId, Plane, Vec3
from stability.problem import UP, ZERO, Contact, Motion, Placed, Problem, Stability, Tolerances, Verdict, Wrench
from stability.statics.assembly import Assembly
from stability.statics.proof import check_motion, power

# A build whose bricks may be shifted in plan: which of it stands with given shifts.
#
# A shifted brick carries the bricks on it along. Shifts are parallel to the ground, or horizontal without ground.


EXACT = 1e-4  # share of the contact distance: bodies this near lie on each other, within rounding

Shift: TypeAlias = tuple[float, float]  # parallel to the ground, towards +x and +y [m]


@dataclass(frozen=True, slots=True)
class Piling:
    """Build: groups of bricks placed together in order, fixed bodies, and removals."""

    planes: Sequence[Plane]
    friction: GivenFriction
    gravity: float
    stages: Sequence[Sequence[Placed]]
    pulled: Mapping[int, Sequence[BodyId]] = field(default_factory=dict)  # by the number of the next stage
    tolerances: Tolerances = Tolerances()  # noqa: RUF009 -- frozen
    joints: Joints = DRY

    @property
    def bricks(self) -> list[Placed]:
        """Return all bricks of all stages."""
        return [placed for stage in self.stages for placed in stage]

    def states(self) -> Iterator[frozenset[BodyId]]:
        """Yield the present bricks after each placement or removal."""
        there: frozenset[BodyId] = frozenset()
        for turn, stage in enumerate(self.stages):
            if turn in self.pulled:
                there -= frozenset(self.pulled[turn])
                yield there
            if stage:
                there |= {placed.brick.id for placed in stage}
                yield there

    def there(self, turn: int) -> frozenset[BodyId]:
        """Return the bricks present at a stage."""
        removed = {name for before, names in self.pulled.items() if before <= turn for name in names}
        return frozenset(placed.brick.id for stage in self.stages[: turn + 1] for placed in stage) - removed

    def carried(self) -> dict[BodyId, frozenset[BodyId]]:
        """Return each brick with all bricks that rest on it."""
        whole = self.whole()
        return {name: frozenset(whole.with_all_above([name])) for name in whole.bricks}

    def whole(self) -> Assembly:
        """Return an assembly of all bricks of all stages."""
        whole = self.assembly()
        whole.add_all(self.bricks, names_smallest=False)
        return whole

    def assembly(self) -> Assembly:
        """Return an assembly of the fixed bodies only."""
        site = self.planes, self.friction, self.gravity, self.tolerances
        return Assembly(*site, overlap=inf, joints=self.joints)

    def shifted(self, shifts: Mapping[BodyId, Shift]) -> "Piling":
        """Return the same build with each brick moved by the sum of its shifts."""
        along, across = self._axes()

        def moved(placed: Placed) -> Placed:
            if placed.brick.id not in shifts:
                return placed
            x, y = shifts[placed.brick.id]
            position = add_scaled(add_scaled(placed.pose.position_W, x, along), y, across)
            return replace(placed, pose=replace(placed.pose, position_W=position))

        return replace(self, stages=[[moved(placed) for placed in stage] for stage in self.stages])

    def way(self, shift: Shift) -> Vec3:
        """Return a shift as a vector in W [m]."""
        along, across = self._axes()
        return add(add_scaled((0.0, 0.0, 0.0), shift[0], along), add_scaled((0.0, 0.0, 0.0), shift[1], across))

    def _axes(self) -> tuple[Vec3, Vec3]:
        normal = next((plane.normal_W for plane in self.planes if plane.id == GROUND), UP)
        across = unit(cross(normal, (1.0, 0.0, 0.0)))
        return cross(across, normal), across

    def verdict_at_once(self) -> Verdict:
        """Return the verdict on the final bricks, placed together.

        If they fall, the build falls at the last stage or before.
        """
        last = self.there(len(self.stages))
        return self.assembly().add_all([p for p in self.bricks if p.brick.id in last], names_smallest=False)

    def first_fall(self, upto: int | None = None, *, names_smallest: bool = False) -> tuple[int, Verdict] | None:
        """Return the first of `upto` stages at which not all bricks stand, and its verdict; None if all stand.

        With `names_smallest` the verdict names the smallest falling set that is found, which takes seconds for a heap.
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
        """Return all touching pairs, the lower body first."""
        return frozenset((contact.lower, contact.upper) for contact in self.whole().all_contacts())

    def times(self) -> dict[BodyId, tuple[int, int]]:
        """Return the stage at which each brick is placed, and the stage before which it is removed."""
        removal_of = {name: turn for turn, names in self.pulled.items() for name in names}
        return {
            placed.brick.id: (turn, removal_of.get(placed.brick.id, len(self.stages)))
            for turn, stage in enumerate(self.stages)
            for placed in stage
        }


# Falls with shifts.
#
# A search tries thousands of shifts, and nearly all builds fall as one before did. So the motions of former falls are
# checked first, by arithmetic. Only the contacts between bricks that shift differently are detected again.


MOST_MOTIONS = 4  # of former falls, the last one first


@dataclass(frozen=True, slots=True)
class ShiftedFall:
    """A proven fall of a build with shifts."""

    turn: int  # the stage
    shifts: Mapping[BodyId, Vec3]  # [m]
    motion: Motion


class ShiftedBuild:
    """Build with shifted bricks: which bodies they would run into, and whether it falls as it fell before."""

    def __init__(self, piling: Piling) -> None:
        """Store the bounds of the unshifted bricks."""
        self._piling = piling
        self._touching = piling.touching()
        self._placed = {placed.brick.id: placed for placed in piling.bricks}
        self._names = list(self._placed)
        solids = [solid(placed) for placed in self._placed.values()]
        self._low = np.array([each.low_W for each in solids]).reshape(-1, 3)
        self._high = np.array([each.high_W for each in solids]).reshape(-1, 3)
        shares = (Tolerances().gap, piling.tolerances.gap)
        self._reach = max((reach_between(each.shortest, share=max(shares)) for each in solids), default=0.0)
        self._law, self._times = as_friction(piling.friction), piling.times()
        # [m] by how much an unshifted brick may be nearer to a plane
        self._clearance = {
            (name, plane.id): apart_from_plane(placed.brick.shape, placed.pose, plane).gap
            + reach_between(placed.brick.shape.least_thickness)
            for name, placed in self._placed.items()
            for plane in piling.planes
        }
        self._contacts: dict[tuple[BodyId, BodyId], tuple[Contact, ...]] = {}  # of unshifted bodies, as far as detected
        self.falls: tuple[ShiftedFall, ...] = ()

    def add_fall(self, turn: int, shifts: Mapping[BodyId, Vec3], motion: Motion | None) -> None:
        """Store the motion of a fall with shifts at a stage."""
        if motion is not None:
            self.falls = (ShiftedFall(turn, shifts, motion), *self.falls[: MOST_MOTIONS - 1])

    def crowds(self, group: frozenset[BodyId], shifts: Mapping[BodyId, Vec3]) -> bool:
        """Return whether a brick of a group overlaps another body or grazes one that it did not touch before.

        A grazing contact counts as contact and might be the only support of the brick.
        """
        return any(
            other not in group and self._meet(name, other) and self._collide(name, other, shifts)
            for name, other in self._near(group, shifts)
        ) or any(
            self._clearance[name, plane.id] + dot(plane.normal_W, shifts.get(name, ZERO)) < 0.0
            for name in group
            for plane in self._piling.planes
        )

    def falls_again(self, shifts: Mapping[BodyId, Vec3], upto: int) -> bool:
        """Return whether the build is proven to fall up to a stage along the motion of a former fall.

        A motion is a field of velocities, which a brick meets at its new place; or it moves with the brick. False for
        bricks with joints, which take power from a motion.
        """
        if self._piling.joints.rules:
            return False
        problems: dict[int, Problem] = {}
        for fall in self.falls:
            for motion in (_carried_over(fall, shifts), fall.motion) if fall.turn <= upto else ():
                if fall.turn not in problems:
                    problems[fall.turn] = self._problem(shifts, fall.turn)
                problem = problems[fall.turn]
                if power(problem.loads, motion) > 0.0 and check_motion(problem, motion, self._piling.tolerances).holds:
                    others = tuple(each for each in self.falls if each is not fall)
                    self.falls = (ShiftedFall(fall.turn, shifts, motion), *others)
                    return True
        return False

    def end_of_fall(self, group: frozenset[BodyId], way: Vec3) -> float:
        """Return how much further along a unit way a group shifts until the last fall gains no power [m], or inf."""
        motion = self.falls[0].motion.velocity
        weight = {name: self._placed[name].brick.mass for name in motion}
        gained = -sum(weight[name] * velocity[2] for name, (velocity, _) in motion.items())
        lost = sum(weight[name] * cross(spin, way)[2] for name, (_, spin) in motion.items() if name in group)
        return gained / lost if lost > 0.0 else inf

    def _problem(self, shifts: Mapping[BodyId, Vec3], turn: int) -> Problem:
        """Return the bricks of a stage with their loads and contacts, of which no gap counts as filled."""
        there = self._piling.there(turn)
        bricks = {name: self._moved(name, shifts) for name in self._names if name in there}
        pairs = sorted({(min(pair), max(pair)) for pair in self._near(there, shifts) if pair[1] in there})
        contacts = [contact for pair in pairs for contact in self._between(*pair, shifts)]
        contacts += [c for name in bricks for plane in self._piling.planes for c in self._on_plane(name, plane, shifts)]
        weights = {name: placed.brick.mass * self._piling.gravity for name, placed in bricks.items()}
        loads = {name: Wrench((0.0, 0.0, -weight)) for name, weight in weights.items()}
        return Problem(bricks, contacts, loads)

    def _between(self, one: BodyId, other: BodyId, shifts: Mapping[BodyId, Vec3]) -> tuple[Contact, ...]:
        """Return the contacts of two bricks, which move with them if they shift alike."""

        def detected(shifts: Mapping[BodyId, Vec3]) -> tuple[Contact, ...]:
            first, second = (solid(self._moved(name, shifts)) for name in (one, other))
            return contacts_between(first, second, self._law.of(one, other), self._piling.tolerances)

        shift = shifts.get(one, ZERO)
        return self._kept((one, other), shift, detected) if shift == shifts.get(other, ZERO) else detected(shifts)

    def _on_plane(self, name: BodyId, plane: Plane, shifts: Mapping[BodyId, Vec3]) -> tuple[Contact, ...]:
        def detected(shifts: Mapping[BodyId, Vec3]) -> tuple[Contact, ...]:
            moved, friction = solid(self._moved(name, shifts)), self._law.on(name, plane)
            return contacts_with_plane(moved, plane, self._piling.tolerances, friction)

        shift = shifts.get(name, ZERO)
        along = dot(shift, plane.normal_W) == 0.0
        return self._kept((plane.id, name), shift, detected) if along else detected(shifts)

    def _kept(
        self, pair: tuple[BodyId, BodyId], shift: Vec3, detected: Callable[[Mapping[BodyId, Vec3]], tuple[Contact, ...]]
    ) -> tuple[Contact, ...]:
        """Return the contacts of two unshifted bodies, moved by a shift; they are detected once."""
        if pair not in self._contacts:
            self._contacts[pair] = detected({})
        contacts = self._contacts[pair]
        if shift == ZERO:
            return contacts
        return tuple(replace(c, points_W=tuple(add(point, shift) for point in c.points_W)) for c in contacts)

    def _near(self, group: Collection[BodyId], shifts: Mapping[BodyId, Vec3]) -> Iterator[tuple[BodyId, BodyId]]:
        """Yield the pairs of a brick of a group and another brick whose bounding boxes are within reach."""
        rows = [number for number, name in enumerate(self._names) if name in group]
        shift = np.array([shifts.get(name, ZERO) for name in self._names]).reshape(-1, 3)
        low, high = self._low + shift - self._reach, self._high + shift + self._reach
        near = (low[rows, None] <= high) & (low <= high[rows, None])
        for row, other in np.argwhere(near.all(axis=2)).tolist():
            if rows[row] != other:
                yield self._names[rows[row]], self._names[other]

    def _moved(self, name: BodyId, shifts: Mapping[BodyId, Vec3]) -> Placed:
        placed = self._placed[name]
        if name not in shifts:
            return placed
        return replace(placed, pose=replace(placed.pose, position_W=add(placed.pose.position_W, shifts[name])))

    def _meet(self, name: BodyId, other: BodyId) -> bool:
        """Return whether two bricks are present at the same time."""
        (come, go), (other_come, other_go) = self._times[name], self._times[other]
        return come < other_go and other_come < go

    def _collide(self, name: BodyId, other: BodyId, shifts: Mapping[BodyId, Vec3]) -> bool:
        a, b = self._moved(name, shifts), self._moved(other, shifts)
        deep = reach_between(a.brick.shape.least_thickness, b.brick.shape.least_thickness)
        between = apart(a.brick.shape, a.pose, b.brick.shape, b.pose)
        # less beside a brick than below it
        bridged = gap_bridged(deep, between.normal_BA_W[2], self._piling.tolerances.within)
        grazes = abs(between.gap) > EXACT * deep and between.gap <= bridged
        return between.gap < -deep or (grazes and not {(name, other), (other, name)} & self._touching)


def _carried_over(fall: ShiftedFall, shifts: Mapping[BodyId, Vec3]) -> Motion:
    """Return the motion of a fall with other shifts: each brick has the velocity of the place to which it moved."""
    velocity = {}
    for name, (along, spin) in fall.motion.velocity.items():
        further = subtract(shifts.get(name, ZERO), fall.shifts.get(name, ZERO))
        velocity[name] = add(along, cross(spin, further)), spin
    return Motion(velocity)
