"""Groups of bricks in PyBullet: joined rigid groups, and bricks with prescribed motion."""

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

# Bricks that are joined, to move as one rigid body.
#
# A group is a body of its own with the shapes of its bricks. The bodies of the bricks stay where they were, without
# mass, and collide with nothing until they are parted: that costs less than to make them anew. The shape of a group
# that was parted stays with the client until it is closed: PyBullet counts it as used for good, and refuses to remove
# it.


NEVER = -1.0  # on the clock


@dataclass(frozen=True, slots=True, eq=False)
class Joined:
    """A group in the engine."""

    group: RigidGroup
    surfaces: GroupSurfaces
    name: BodyId  # of its body
    own_bodies: dict[BodyId, int]  # of its bricks


@dataclass
class JoinedGroups:
    """All groups, and what is asked of bricks where some may be in one: then an answer is of the brick all the same."""

    single: BrickBodies
    by_brick: dict[BodyId, Joined] = field(default_factory=dict, init=False)
    _by_name: dict[BodyId, Joined] = field(default_factory=dict, init=False)
    _told_at: float = field(default=NEVER, init=False)  # the clock when these were asked for [s]
    _told_points: dict[BodyId, list[ContactPoint]] = field(default_factory=dict, init=False)  # by body

    def weld(self, bricks: Collection[BodyId]) -> None:
        """Let these bricks move from now on as one, with the momentum and angular momentum that they have."""
        states, single = self.states(bricks), self.single
        group = grouped((single.own.bricks[brick], states[brick].pose) for brick in bricks)
        held = all(self.holds(brick) for brick in group.bricks)
        falls = held or single.stepper.fall.flying >= group.bricks.keys()
        for brick in group.bricks:
            self.freeze(brick)
        joined = self._added(group)
        if falls:
            single.comes_free(joined.name)
        single.bodies.set_motion(joined.name, *common_motion(group, states))

    def _added(self, group: RigidGroup) -> Joined:
        """A group of bricks that are held, in place of their own bodies."""
        bodies, maker = self.single.bodies, self.single.maker
        own = {brick: bodies.numbers.pop(brick) for brick in group.bricks}
        maker.meet(own.values(), 0, 0)
        joined = Joined(group, surfaces(group), f"group of {next(iter(own))}", own)
        maker.group(joined.name, group)
        self._by_name[joined.name] = joined
        self.by_brick |= dict.fromkeys(own, joined)
        self._told_at = NEVER
        return joined

    def unweld(self, brick: BodyId) -> tuple[BodyId, ...]:
        """Let all that a brick is joined to move one by one, each with the motion that it has; these are they."""
        joined, single = self.by_brick[brick], self.single
        states, flew = self.states(joined.group.bricks), joined.name in single.stepper.fall.flying
        self._remove(joined)
        for name, state in states.items():
            single.collide_alone(name, joined.own_bodies[name])
            single.put_at(name, state.pose)
            single.wake(name)
            if not flew:
                single.stays(name)  # as for falling: it does so already
            single.bodies.set_motion(name, state.velocity_W, state.angular_velocity_W)
        return tuple(states)

    def part_from_others(self, brick: BodyId) -> None:
        """Part a brick from what it is joined to, if it is."""
        if brick in self.by_brick:
            self.unweld(brick)

    def _remove(self, joined: Joined) -> None:
        self._told_at = NEVER
        self.single.bodies.remove(joined.name)
        self.single.stays(joined.name)
        del self._by_name[joined.name]
        for name in joined.group.bricks:
            del self.by_brick[name]

    def forget_contacts(self) -> None:
        """What was told of contacts may be of bodies that are gone."""
        self._told_at = NEVER

    def mass_ratio(self) -> float:
        """How many times the mass of the lightest body that is awake the heaviest has."""
        masses = self.single.own.masses.items()
        awake = [mass for name, mass in masses if name not in self.by_brick and not self.single.holds(name)]
        awake += [joined.group.mass for joined in self._by_name.values()]
        return max(awake) / min(awake) if awake else 1.0

    def freeze(self, brick: BodyId) -> None:
        """Hold a brick, parted from all others."""
        self.part_from_others(brick)
        self.single.freeze(brick)

    def holds(self, brick: BodyId) -> bool:
        """Whether a brick is held by itself."""
        return brick not in self.by_brick and self.single.holds(brick)

    def states(self, names: Collection[BodyId]) -> dict[BodyId, BodyState]:
        """Pose and motion of bricks and planes."""
        own = [body for body in names if body not in self.by_brick]
        found = self.single.states(own + sorted({self.by_brick[b].name for b in names if b in self.by_brick}))
        return {body: found[body] if body in found else self._member_state(found, body) for body in names}

    def _member_state(self, found: dict[BodyId, BodyState], brick: BodyId) -> BodyState:
        joined = self.by_brick[brick]
        return member_state(found[joined.name], joined.group.places_G[brick])

    def contacts(self, brick: BodyId, now: float) -> Sequence[ContactPoint]:
        """The contact points of a brick as of the last step, by the clock as it is now [s]."""
        if not self._by_name:
            return self.single.bodies.contacts(brick)
        asked = self.by_brick[brick].name if brick in self.by_brick else brick
        if self._told_at != now:
            self._told_at, self._told_points = now, {}
        if asked not in self._told_points:  # the members of a group have the same
            poses = {name: state.pose for name, state in self.single.states(self._by_name).items()}
            points = self.single.bodies.contacts(asked)
            self._told_points[asked] = [self._of_bricks(point, poses) for point in points]
        return [point for point in self._told_points[asked] if brick in (point.a, point.b)]

    def touching(self, brick: BodyId, now: float) -> Sequence[ContactPoint]:
        """The same points, maybe without their friction, which takes as long to find as all the rest."""
        return self.contacts(brick, now) if self._by_name else self.single.bodies.touching(brick)

    def _of_bricks(self, point: ContactPoint, poses: dict[BodyId, Pose]) -> ContactPoint:
        """A contact point by the names of bricks: PyBullet names groups."""
        on_a = add(point.position_W, scale(point.gap, point.normal_BA_W))
        a, b = self._brick_at(point.a, on_a, poses), self._brick_at(point.b, point.position_W, poses)
        return replace(point, a=a, b=b)

    def _brick_at(self, body: BodyId, point_W: Vec3, poses: dict[BodyId, Pose]) -> BodyId:
        if body not in self._by_name:
            return body
        return self._by_name[body].surfaces.brick_at(seen_from(poses[body], Pose(point_W)).position_W)

    def bricks_in(self, body: BodyId) -> Collection[BodyId]:
        """The bricks of a body of the engine: those of a group, or the one that it is."""
        return self._by_name[body].group.bricks if body in self._by_name else (body,)

    def neighbours(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        """The bodies that may be as close to a brick as this [m]; not those that it is joined to."""
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
        """Lowest and highest coordinates of a brick, and so much more [m]."""
        (low_W, high_W), around = bounds_W(self.single.own.bricks[brick].shape, pose), (within, within, within)
        return subtract(low_W, around), add(high_W, around)


# Bricks that somebody outside moves. A body of PyBullet without mass moves nothing, so what is carried gets much.
#
# In each engine step such a brick is given its speed anew, and what gravity adds to it in that step is taken off
# before.


@dataclass
class GuidedBricks:
    """Which bricks are guided, and how."""

    bricks: BrickBodies
    _guided: Mapping[BodyId, Guided] = field(default_factory=dict, init=False)

    def follow(self, guided: Mapping[BodyId, Guided]) -> None:
        """Guide these from now on, and no others."""
        before, self._guided = self._guided, dict(guided)
        for brick, was in before.items():
            left = brick not in guided and brick in self.bricks.own.bricks and not self.bricks.holds(brick)
            if left and was.carried:
                self.bricks.weigh(brick, 1.0)
                self.bricks.comes_free(brick)
        for brick, each in guided.items():
            if brick not in before:
                self.bricks.stays(brick)  # as for falling
            if each.carried:
                self.bricks.weigh(brick, FIRM)  # each time, for it may have got another body

    def exert(self, pull_W: Vec3, duration: float) -> None:
        """Give them their speeds before an engine step of a duration [s] in which all is pulled by so much [m/s2]."""
        states = self.bricks.bodies.states(self._guided)
        for brick, each in self._guided.items():
            velocity_W, angular_velocity_W = each.motion(states[brick])
            if each.carried:
                velocity_W = add_scaled(velocity_W, -duration, pull_W)
            self.bricks.bodies.set_motion(brick, velocity_W, angular_velocity_W)
