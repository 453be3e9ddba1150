"""The shell: after each step of the engine, read it, judge, and write back who is frozen and who is woken.

Source: the stack-stability thesis, section 3.3.1: collect contacts, test the bricks that may be at rest one by one,
add the stable ones, update what is above each brick, test the whole stack, wake what fails and all above it.
"""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf

from stability.contact import TOUCHING, ContactArea, contact_area, main_contact
from stability.contact_graph import with_all_above
from stability.engine import Engine
from stability.freezing import Activity, Evidence, RestLimits, next_activity
from stability.model import BodyId, BodyState, ContactPoint, Vec3
from stability.patch import face_patch
from stability.support import Load, StackedBrick, failing, lies_above, loads_above, tipping_margin

ROUNDING = 1e-9  # [s] clocks are sums of steps


@dataclass(frozen=True, slots=True)
class ContactLimits:
    """Which of the engine's contact points carry weight."""

    gap: float = TOUCHING  # [m] engines report points that do not touch yet; settled planks are within 0.1 mm
    # z of the normal towards the carried brick: steeper than 60 deg is a side touch, which the base model leaves out.
    upward: float = 0.5
    impact_speed: float = 0.05  # [m/s] a point that approaches faster is an impact, not a support


@dataclass(frozen=True, slots=True)
class Update:
    """What one pass changed; bricks by name."""

    frozen: tuple[BodyId, ...] = ()
    woken: tuple[BodyId, ...] = ()
    failed: tuple[BodyId, ...] = ()  # those of `woken` whose own test failed; the rest stood on them


@dataclass
class StackStability:
    """Watches the bricks of one engine. Call `update` after each of its steps."""

    engine: Engine
    rest: RestLimits = field(default_factory=RestLimits)
    contact: ContactLimits = field(default_factory=ContactLimits)
    # Look at every frozen brick and its supports each time, and wake what somebody else has moved. Without it, cheaper.
    guard: bool = True
    stack: dict[BodyId, StackedBrick] = field(default_factory=dict, init=False)
    loads: dict[BodyId, Load] = field(default_factory=dict, init=False)
    _activity: dict[BodyId, Activity] = field(default_factory=dict, init=False)
    _slow_since: dict[BodyId, float] = field(default_factory=dict, init=False)
    _held: dict[BodyId, BodyState] = field(default_factory=dict, init=False)  # as frozen; and their fixed supports
    _seen: tuple[object, object] = field(default=(None, None), init=False)  # the engine's bodies, last time

    def awake(self) -> list[BodyId]:
        """The bricks that the engine moves, by name."""
        return sorted(brick for brick in self.engine.masses() if brick not in self.stack)

    def least_margin(self) -> float | None:
        """The smallest tipping margin in the stack [m]; None if the stack is empty."""
        return min((tipping_margin(brick, self.loads[name]) for name, brick in self.stack.items()), default=None)

    def update(self) -> Update:
        """One pass of the published method over what the engine has just done."""
        lost = self._forget_removed() + self._wake_disturbed()
        awake = self.awake()
        if not awake:
            return Update(woken=lost)
        states = self.engine.states(awake)
        self._follow(awake, states)
        added = self._newly_stable(awake, states)
        if not added:
            return Update(woken=lost)
        self._freeze(added)
        self.loads = loads_above(self.stack)
        failed = failing(self.stack, self.loads)
        return Update(tuple(brick.id for brick in added), lost + self._wake(failed), failed)

    def wake(self, bricks: Iterable[BodyId]) -> tuple[BodyId, ...]:
        """Give these bricks and all that rests on them back to the engine (section 3.3.7); returns those woken."""
        return self._wake([brick for brick in bricks if brick in self.stack])

    def _forget_removed(self) -> tuple[BodyId, ...]:
        """Drop bricks that the engine no longer has, and wake what rested on them or on a fixed body that is gone."""
        bricks, fixed = self.engine.masses(), self.engine.fixed()
        if self._seen[0] is bricks and self._seen[1] is fixed:
            return ()
        self._seen = (bricks, fixed)
        for brick in [brick for brick in self.stack if brick not in bricks]:
            del self.stack[brick]
            self._held.pop(brick, None)
            self._activity.pop(brick, None)
        return self._wake(
            [
                name
                for name, brick in self.stack.items()
                if any(support not in self.stack and support not in fixed for support in brick.rests_on)
            ]
        )

    def _wake_disturbed(self) -> tuple[BodyId, ...]:
        """Wake what somebody else has moved or pushed since it was frozen, and what rests on it."""
        if not self.guard or not self._held:
            return ()
        fixed = self.engine.fixed()
        present = [body for body in self._held if body in self.stack or body in fixed]
        states = self.engine.states(present)
        disturbed = {body for body in present if states[body] != self._held[body]}
        for body in disturbed:
            self._held[body] = states[body]
        return self._wake(
            [name for name, brick in self.stack.items() if name in disturbed or disturbed.intersection(brick.rests_on)]
        )

    def _follow(self, awake: Collection[BodyId], states: Mapping[BodyId, BodyState]) -> None:
        now = self.engine.time()
        for brick in awake:
            if not self.rest.slow(states[brick]):
                self._slow_since.pop(brick, None)
                continue
            since = self._slow_since.setdefault(brick, now)
            self._step(brick, Evidence(slow_for=now - since))

    def _step(self, brick: BodyId, seen: Evidence) -> None:
        self._activity[brick] = next_activity(self._activity.get(brick, Activity.FREE), seen, self.rest)

    def _newly_stable(self, awake: Collection[BodyId], states: Mapping[BodyId, BodyState]) -> list[StackedBrick]:
        """The slow bricks that rest stably on what was in the stack before this pass."""
        slow_since = self.engine.time() - self.rest.dwell + ROUNDING
        potential = [
            brick
            for brick in awake
            if self._slow_since.get(brick, inf) <= slow_since and self._activity[brick] is not Activity.UNSTABLE
        ]
        if not potential:
            return []
        masses = self.engine.masses()
        points = self._supporting_points(potential, states)
        tested = (
            stacked_brick(brick, masses[brick], states[brick].pose.position_W, points[brick])
            for brick in potential
            if points[brick]
        )
        return [brick for brick in tested if lies_above((brick.com_W[0], brick.com_W[1]), brick.main)]

    def _supporting_points(
        self, potential: Collection[BodyId], states: Mapping[BodyId, BodyState]
    ) -> dict[BodyId, dict[BodyId, Sequence[Vec3]]]:
        """The points at which each potential brick rests on the stack or on something fixed, by support."""
        fixed = self.engine.fixed()
        reported: dict[BodyId, dict[BodyId, list[Vec3]]] = {brick: {} for brick in potential}
        for point in self.engine.contacts(potential):
            for upper, lower, upward in ((point.a, point.b, 1.0), (point.b, point.a, -1.0)):
                # Two bricks that are both outside the stack cannot be resting on a part of it.
                if upper not in reported or not (lower in self.stack or lower in fixed):
                    continue
                if point.gap > self.contact.gap:
                    continue
                if upward * point.normal_BA_W[2] < self.contact.upward:
                    continue
                if approach_speed(states[upper], point) <= self.contact.impact_speed:
                    reported[upper].setdefault(lower, []).append(point.position_W)
        return {
            upper: {lower: self._points_of(upper, lower, states[upper], points) for lower, points in supports.items()}
            for upper, supports in reported.items()
        }

    def _points_of(self, upper: BodyId, lower: BodyId, state: BodyState, reported: Sequence[Vec3]) -> Sequence[Vec3]:
        """The corners of the contact of two boxes face on face; of anything else, what the engine reported."""
        upper_size, lower_size = self.engine.box(upper), self.engine.box(lower)
        if upper_size is None or lower_size is None:
            return reported
        below = self.engine.states([lower])[lower].pose
        return face_patch(upper_size, state.pose, lower_size, below) or reported

    def _freeze(self, added: Sequence[StackedBrick]) -> None:
        for brick in added:
            self.engine.freeze(brick.id)
            self.stack[brick.id] = brick
            self._step(brick.id, Evidence(stands=True))
            if self.guard:
                self._held |= self.engine.states([brick.id, *(on for on in brick.rests_on if on not in self._held)])

    def _wake(self, failed: Sequence[BodyId]) -> tuple[BodyId, ...]:
        woken = sorted(with_all_above({name: brick.rests_on for name, brick in self.stack.items()}, failed))
        for brick in woken:
            self.engine.wake(brick)
            del self.stack[brick]
            self._held.pop(brick, None)
            self._slow_since.pop(brick, None)
            self._step(brick, Evidence(fails=True))
        if woken:
            self.loads = loads_above(self.stack)
        return tuple(woken)


def stacked_brick(brick: BodyId, mass: float, com_W: Vec3, points: Mapping[BodyId, Sequence[Vec3]]) -> StackedBrick:
    """A brick with its contact areas, supports by name."""
    areas: tuple[ContactArea, ...] = tuple(contact_area(on, points[on]) for on in sorted(points))
    return StackedBrick(brick, mass, com_W, areas, main_contact(areas))


def approach_speed(state: BodyState, point: ContactPoint) -> float:
    """Speed of a brick's material point along the contact normal [m/s], the other body being at rest."""
    vx, vy, vz = state.velocity_W
    ox, oy, oz = state.angular_velocity_W
    rx, ry, rz = (p - c for p, c in zip(point.position_W, state.pose.position_W, strict=True))
    point_velocity = (vx + oy * rz - oz * ry, vy + oz * rx - ox * rz, vz + ox * ry - oy * rx)
    return abs(sum(v * n for v, n in zip(point_velocity, point.normal_BA_W, strict=True)))
