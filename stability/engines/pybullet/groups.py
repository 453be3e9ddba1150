"""Welded groups and bricks with prescribed motion in PyBullet."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from stability.dynamics.rigid_group import (
    GroupSurfaces,
    RigidGroup,
    common_motion,
    grouped,
    member_state,
    seen_from,
    surfaces,
)
from stability.engines.protocol import FIRM, Guided
from stability.engines.pybullet.bodies import BrickBodies
from stability.geometry.placed_shape import bounds_W
from stability.geometry.vectors import add, add_scaled, scale, subtract
from stability.model import BodyId, BodyState, ContactPoint, Pose, Vec3

# Bricks welded into one rigid body.
#
# A group is a body with the shapes of its bricks. The bricks' own bodies stay in place, without mass and collisions,
# until the group is unwelded, which is cheaper than creating them again. The shape of an unwelded group remains in the
# client, as PyBullet refuses to remove a shape once it was used.


NEVER = -1.0  # [s] before any time on the clock


@dataclass(frozen=True, slots=True, eq=False)
class WeldedGroup:
    """Welded group in the engine."""

    group: RigidGroup
    surfaces: GroupSurfaces
    name: BodyId  # of its body
    own_bodies: dict[BodyId, int]  # of its bricks


@dataclass
class WeldedGroups:
    """All welded groups, and the queries of bricks, which return values of single bricks inside groups too."""

    single: BrickBodies
    by_brick: dict[BodyId, WeldedGroup] = field(default_factory=dict, init=False)
    _by_name: dict[BodyId, WeldedGroup] = field(default_factory=dict, init=False)
    _cache_time: float = field(default=NEVER, init=False)  # time of the cached points [s]
    _cached_points: dict[BodyId, list[ContactPoint]] = field(default_factory=dict, init=False)  # by body

    def weld(self, bricks: Collection[BodyId]) -> None:
        """Weld bricks into one rigid body that keeps their momentum and angular momentum."""
        states, single = self.states(bricks), self.single
        group = grouped((single.own.bricks[brick], states[brick].pose) for brick in bricks)
        all_frozen = all(self.holds(brick) for brick in group.bricks)
        falls = all_frozen or single.stepper.fall.flying >= group.bricks.keys()
        for brick in group.bricks:
            self.freeze(brick)
        joined = self._added(group)
        if falls:
            single.on_woken(joined.name)
        single.bodies.set_motion(joined.name, *common_motion(group, states))

    def _added(self, group: RigidGroup) -> WeldedGroup:
        """Replace the bodies of frozen bricks by the body of a group."""
        bodies, maker = self.single.bodies, self.single.maker
        own = {brick: bodies.numbers.pop(brick) for brick in group.bricks}
        maker.set_collision_group(own.values(), 0, 0)
        joined = WeldedGroup(group, surfaces(group), f"group of {next(iter(own))}", own)
        maker.group(joined.name, group)
        self._by_name[joined.name] = joined
        self.by_brick |= dict.fromkeys(own, joined)
        self._cache_time = NEVER
        return joined

    def unweld(self, brick: BodyId) -> tuple[BodyId, ...]:
        """Split the group of a brick into single bricks that keep their motions; return their names."""
        joined, single = self.by_brick[brick], self.single
        states, flew = self.states(joined.group.bricks), joined.name in single.stepper.fall.flying
        self._remove(joined)
        for name, state in states.items():
            single.collide_alone(name, joined.own_bodies[name])
            single.put_at(name, state.pose)
            single.wake(name)
            if not flew:
                single.on_stopped(name)  # no correction for the start of a fall
            single.bodies.set_motion(name, state.velocity_W, state.angular_velocity_W)
        return tuple(states)

    def part_from_others(self, brick: BodyId) -> None:
        """Unweld the group of a brick, if it is in one."""
        if brick in self.by_brick:
            self.unweld(brick)

    def _remove(self, joined: WeldedGroup) -> None:
        self._cache_time = NEVER
        self.single.bodies.remove(joined.name)
        self.single.on_stopped(joined.name)
        del self._by_name[joined.name]
        for name in joined.group.bricks:
            del self.by_brick[name]

    def forget_contacts(self) -> None:
        """Drop the cached contact points after a body was removed."""
        self._cache_time = NEVER

    def mass_ratio(self) -> float:
        """Return the ratio of the largest to the smallest mass of the awake bodies."""
        masses = self.single.own.masses.items()
        awake = [mass for name, mass in masses if name not in self.by_brick and not self.single.holds(name)]
        awake += [joined.group.mass for joined in self._by_name.values()]
        return max(awake) / min(awake) if awake else 1.0

    def freeze(self, brick: BodyId) -> None:
        """Unweld a brick and freeze it."""
        self.part_from_others(brick)
        self.single.freeze(brick)

    def holds(self, brick: BodyId) -> bool:
        """Check that a brick is frozen and in no group."""
        return brick not in self.by_brick and self.single.holds(brick)

    def states(self, names: Collection[BodyId]) -> dict[BodyId, BodyState]:
        """Return the poses and motions of bricks and planes."""
        own = [body for body in names if body not in self.by_brick]
        states = self.single.states(own + sorted({self.by_brick[b].name for b in names if b in self.by_brick}))
        return {body: states[body] if body in states else self._member_state(states, body) for body in names}

    def _member_state(self, states: dict[BodyId, BodyState], brick: BodyId) -> BodyState:
        joined = self.by_brick[brick]
        return member_state(states[joined.name], joined.group.places_G[brick])

    def contacts(self, brick: BodyId, now: float) -> Sequence[ContactPoint]:
        """Return the contact points of a brick as of the last step; `now` is the current time [s]."""
        if not self._by_name:
            return self.single.bodies.contacts(brick)
        body = self.by_brick[brick].name if brick in self.by_brick else brick
        if self._cache_time != now:
            self._cache_time, self._cached_points = now, {}
        if body not in self._cached_points:  # the bricks of a group share these points
            poses = {name: state.pose for name, state in self.single.states(self._by_name).items()}
            points = self.single.bodies.contacts(body)
            self._cached_points[body] = [self._of_bricks(point, poses) for point in points]
        return [point for point in self._cached_points[body] if brick in (point.a, point.b)]

    def touching(self, brick: BodyId, now: float) -> Sequence[ContactPoint]:
        """Return the contact points of a brick, without friction where that halves the time."""
        return self.contacts(brick, now) if self._by_name else self.single.bodies.touching(brick)

    def _of_bricks(self, point: ContactPoint, poses: dict[BodyId, Pose]) -> ContactPoint:
        """Replace the names of groups in a contact point by names of bricks."""
        on_a = add(point.position_W, scale(point.gap, point.normal_BA_W))
        a, b = self._brick_at(point.a, on_a, poses), self._brick_at(point.b, point.position_W, poses)
        return replace(point, a=a, b=b)

    def _brick_at(self, body: BodyId, point_W: Vec3, poses: dict[BodyId, Pose]) -> BodyId:
        if body not in self._by_name:
            return body
        return self._by_name[body].surfaces.brick_at(seen_from(poses[body], Pose(point_W)).position_W)

    def bricks_in(self, body: BodyId) -> Collection[BodyId]:
        """Return the bricks of a group, or the single brick of a body."""
        return self._by_name[body].group.bricks if body in self._by_name else (body,)

    def neighbours(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        """Return the bodies that may be within a distance [m] of a brick, outside its group."""
        bodies = self.single.bodies
        if not self._by_name:
            return sorted(bodies.neighbours(brick, within))
        low, high = self._bounds(brick, self.states([brick])[brick].pose, within)
        names = bodies.around(scale(bodies.scale, low), scale(bodies.scale, high))
        others = {name for name in names if name in bodies.numbers} - self._by_name.keys()
        members = {member for name in names & self._by_name.keys() for member in self._by_name[name].group.bricks}
        if brick in self.by_brick:
            members -= self.by_brick[brick].group.bricks.keys()
        return sorted((others | set(self._overlapping(members, low, high, within))) - {brick})

    def _overlapping(self, bricks: Collection[BodyId], low: Vec3, high: Vec3, within: float) -> Iterator[BodyId]:
        for brick, state in self.states(sorted(bricks)).items():
            lowest, highest = self._bounds(brick, state.pose, within)
            if max(subtract(lowest, high)) <= 0.0 and max(subtract(low, highest)) <= 0.0:
                yield brick

    def _bounds(self, brick: BodyId, pose: Pose, within: float) -> tuple[Vec3, Vec3]:
        """Return the lowest and highest coordinates of a brick, extended by a margin [m]."""
        (low_W, high_W), around = bounds_W(self.single.own.bricks[brick].shape, pose), (within, within, within)
        return subtract(low_W, around), add(high_W, around)


# Bricks with prescribed motion. A PyBullet body without mass pushes nothing, so a carried brick gets a large mass.
#
# Before each engine step it gets its prescribed velocity, minus the change that gravity makes in the step.


@dataclass
class GuidedBricks:
    """The bricks with prescribed motion."""

    bricks: BrickBodies
    _guided: Mapping[BodyId, Guided] = field(default_factory=dict, init=False)

    def follow(self, guided: Mapping[BodyId, Guided]) -> None:
        """Replace the prescribed motions."""
        before, self._guided = self._guided, dict(guided)
        for brick, motion in before.items():
            released = brick not in guided and brick in self.bricks.own.bricks and not self.bricks.holds(brick)
            if released and motion.carried:
                self.bricks.scale_mass(brick, 1.0)
                self.bricks.on_woken(brick)
        for brick, motion in guided.items():
            if brick not in before:
                self.bricks.on_stopped(brick)  # no free-fall correction
            if motion.carried:
                self.bricks.scale_mass(brick, FIRM)  # each time, as the brick may have a new body

    def exert(self, pull_W: Vec3, duration: float) -> None:
        """Set the prescribed velocities before an engine step of a duration [s] under a gravity [m/s2]."""
        states = self.bricks.bodies.states(self._guided)
        for brick, motion in self._guided.items():
            velocity_W, angular_velocity_W = motion.motion(states[brick])
            if motion.carried:
                velocity_W = add_scaled(velocity_W, -duration, pull_W)
            self.bricks.bodies.set_motion(brick, velocity_W, angular_velocity_W)
