"""A PyBullet world of one's own in which bricks can be joined, to move as one rigid body.

A group is a body of its own with the shapes of its bricks. The bodies of the bricks stay where they were, without mass,
and collide with nothing until they are parted: that costs less than to make them anew. The shape of a group that was
parted stays with the client until it is closed: PyBullet counts it as used for good, and refuses to remove it.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field

from stability.engines.pybullet.friction_cones import ConeWorld
from stability.engines.pybullet.planes import ALL
from stability.engines.pybullet.pybullet_binding import pybullet
from stability.geometry.boxes import box_corners
from stability.geometry.vectors import add, scale, subtract
from stability.mechanics.rigid_group import (
    RigidGroup,
    Surfaces,
    common_motion,
    grouped,
    member_state,
    seen_from,
    surfaces,
)
from stability.model import BodyId, BodyState, ContactPoint, Pose, Vec3


@dataclass(frozen=True, slots=True, eq=False)
class Joined:
    """A group in the engine."""

    group: RigidGroup
    surfaces: Surfaces
    name: BodyId  # of its body
    own_bodies: dict[BodyId, int]  # of its bricks


@dataclass
class PyBulletWorld(ConeWorld):
    """A world of its own for bricks and planes; close it after use."""

    _joined: dict[BodyId, Joined] = field(default_factory=dict, init=False)  # by brick
    _groups: dict[BodyId, Joined] = field(default_factory=dict, init=False)  # by the name of the group's body

    _told_at: float = field(default=-1.0, init=False)  # the clock when these were asked for [s]
    _told_points: dict[BodyId, list[ContactPoint]] = field(default_factory=dict, init=False)  # by body

    def join(self, bricks: Collection[BodyId]) -> None:
        states = self.states(bricks)
        group = grouped((self._bricks[brick], states[brick].pose) for brick in bricks)
        awake = [not self.holds(brick) for brick in group.bricks]
        flew = self._flying >= group.bricks.keys()
        for brick in group.bricks:
            self.freeze(brick)
        own = {brick: self._bodies.pop(brick) for brick in group.bricks}
        for body in own.values():
            pybullet.setCollisionFilterGroupMask(body, -1, 0, 0, self.client)
        joined = Joined(group, surfaces(group), f"group of {next(iter(own))}", own)
        self._add_group(joined)
        self._groups[joined.name] = joined
        if not any(awake) or flew:
            self._comes_free(joined.name)
        self._told_at = -1.0
        self._joined |= dict.fromkeys(own, joined)
        self._set_motion(self._bodies[joined.name], *common_motion(group, states))

    def _add_group(self, joined: Joined) -> None:
        group = joined.group
        # PyBullet counts a shape as used for ever, so it goes only with the world.
        shape = self._solids.rounded_boxes(
            (scale(self.scale, group.bricks[brick].size), _scaled(self.scale, place))
            for brick, place in group.places_G.items()
        )
        body = self._body(group.mass, shape, scale(self.scale, group.pose.position_W), group.pose.orientation)
        self._name(body, joined.name, self._own_friction())
        self._weigh(body, group.mass, group.moments)

    def part(self, brick: BodyId) -> tuple[BodyId, ...]:
        joined = self._joined[brick]
        states, flew = self.states(joined.group.bricks), joined.name in self._flying
        self._remove_group(joined)
        for name, state in states.items():
            body = self._bodies[name] = joined.own_bodies[name]
            pybullet.setCollisionFilterGroupMask(body, -1, self._kind(name), ALL, self.client)
            self.put_at(name, state.pose)
            self.wake(name)
            if not flew:
                self._stays(name)  # as for falling: it does so already
            self._set_motion(body, state.velocity_W, state.angular_velocity_W)
        return tuple(states)

    def _remove_group(self, joined: Joined) -> None:
        self._told_at = -1.0
        body = self._bodies.pop(joined.name)
        pybullet.removeBody(body, self.client)
        self._stays(joined.name)
        del self.names[body], self._groups[joined.name]
        for name in joined.group.bricks:
            del self._joined[name]

    def _awake_masses(self) -> list[float]:
        free = [mass for name, mass in self._masses.items() if name not in self._joined and not self.holds(name)]
        return free + [joined.group.mass for joined in self._groups.values()]

    def freeze(self, brick: BodyId) -> None:
        if brick in self._joined:
            self.part(brick)
        super().freeze(brick)

    def remove_brick(self, brick: BodyId) -> None:
        if brick in self._joined:
            self.part(brick)
        super().remove_brick(brick)
        self._told_at = -1.0

    def set_state(self, brick: BodyId, state: BodyState) -> None:
        if brick in self._joined:
            self.part(brick)
        super().set_state(brick, state)

    def holds(self, brick: BodyId) -> bool:
        return brick not in self._joined and super().holds(brick)

    def states(self, bodies: Collection[BodyId]) -> dict[BodyId, BodyState]:
        own = [body for body in bodies if body not in self._joined]
        found = super().states(own + sorted({self._joined[b].name for b in bodies if b in self._joined}))
        return {body: found[body] if body in found else self._member_state(found, body) for body in bodies}

    def _member_state(self, found: dict[BodyId, BodyState], brick: BodyId) -> BodyState:
        joined = self._joined[brick]
        return member_state(found[joined.name], joined.group.places_G[brick])

    def contacts(self, brick: BodyId) -> Sequence[ContactPoint]:
        if not self._groups:
            return super().contacts(brick)
        asked = self._joined[brick].name if brick in self._joined else brick
        if self._told_at != self._clock:
            self._told_at, self._told_points = self._clock, {}
        if asked not in self._told_points:  # the members of a group have the same
            poses = {name: state.pose for name, state in super().states(self._groups).items()}
            self._told_points[asked] = [self._of_bricks(point, poses) for point in super().contacts(asked)]
        points = self._told_points[asked]
        return [point for point in points if brick in (point.a, point.b)]

    def _of_bricks(self, point: ContactPoint, poses: dict[BodyId, Pose]) -> ContactPoint:
        """A contact point by the names of bricks: PyBullet names groups."""
        on_a = add(point.position_W, scale(point.gap, point.normal_BA_W))
        return ContactPoint(
            self._brick_at(point.a, on_a, poses),
            self._brick_at(point.b, point.position_W, poses),
            point.position_W,
            point.normal_BA_W,
            point.gap,
            point.normal_force,
            point.friction_W,
        )

    def _brick_at(self, body: BodyId, point_W: Vec3, poses: dict[BodyId, Pose]) -> BodyId:
        if body not in self._groups:
            return body
        return self._groups[body].surfaces.brick_at(seen_from(poses[body], Pose(point_W)).position_W)

    def near(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        if not self._groups:
            return super().near(brick, within)
        low, high = self._bounds(brick, self.states([brick])[brick].pose, within)
        names = self._around(scale(self.scale, low), scale(self.scale, high))
        others = {name for name in names if name in self._bodies} - self._groups.keys()
        members = {member for name in names & self._groups.keys() for member in self._groups[name].group.bricks}
        if brick in self._joined:
            members -= self._joined[brick].group.bricks.keys()
        return sorted((others | set(self._overlapping(members, low, high, within))) - {brick})

    def _overlapping(self, bricks: Collection[BodyId], low: Vec3, high: Vec3, within: float) -> Iterator[BodyId]:
        for brick, state in self.states(sorted(bricks)).items():
            lowest, highest = self._bounds(brick, state.pose, within)
            if max(subtract(lowest, high)) <= 0.0 and max(subtract(low, highest)) <= 0.0:
                yield brick

    def _bounds(self, brick: BodyId, pose: Pose, within: float) -> tuple[Vec3, Vec3]:
        """Lowest and highest coordinates of a brick, and so much more [m]."""
        corners, around = box_corners(self._bricks[brick].size, pose), (within, within, within)
        (a, b, c), (d, e, f) = map(min, zip(*corners, strict=True)), map(max, zip(*corners, strict=True))
        return subtract((a, b, c), around), add((d, e, f), around)


def _scaled(factor: float, pose: Pose) -> Pose:
    return Pose(scale(factor, pose.position_W), pose.orientation)
