"""Planes, bricks and states of a world, stored outside the engine."""

from collections.abc import Collection, Iterable, Mapping, Sequence, Set
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING

from stability.dynamics.rigid_body import AppliedForce
from stability.engines.protocol import Clock, World, WrongFriction
from stability.model import AT_REST, BodyId, BodyState, Brick, HalfSpace, Plane, Pose, Shape, Vec3

if TYPE_CHECKING:
    from stability.geometry.bounding_boxes import BoundingBoxes


@dataclass
class OwnBodies:
    """The planes and bricks of a world by name, in the order of their addition."""

    planes: dict[BodyId, Plane] = field(default_factory=dict)
    bricks: dict[BodyId, Brick] = field(default_factory=dict)
    # As `Engine` promises, a change of the bodies replaces these objects.
    masses: Mapping[BodyId, float] = field(default_factory=dict, init=False)  # of bricks [kg]
    fixed: frozenset[BodyId] = field(default=frozenset(), init=False)  # the planes
    _masses: dict[BodyId, float] = field(default_factory=dict, init=False)

    def add_plane(self, plane: Plane) -> None:
        """Add a plane."""
        self.planes[plane.id] = plane
        self.fixed = frozenset(self.planes)

    def add_brick(self, brick: Brick) -> None:
        """Add a brick."""
        self.bricks[brick.id] = brick
        self._masses[brick.id] = brick.mass
        self.masses = MappingProxyType(self._masses)

    def remove_brick(self, brick: BodyId) -> None:
        """Remove a brick."""
        del self.bricks[brick], self._masses[brick]
        self.masses = MappingProxyType(self._masses)

    def shape(self, body: BodyId) -> Shape:
        """Return the shape of a body, as it was declared."""
        return HalfSpace(self.planes[body].normal_W) if body in self.planes else self.bricks[body].shape

    def neighbours(self, brick: BodyId, boxes: "BoundingBoxes", within: float) -> Sequence[BodyId]:
        """Return the bodies that may be within a distance [m] of a brick, by the bricks' current bounding boxes."""
        planes = [name for name, plane in self.planes.items() if boxes.reaches_plane(brick, plane, within)]
        return sorted([*boxes.neighbours(brick, within), *planes])


@dataclass
class StoredBodies:
    """Poses and motions of the bodies that no engine steps, with the set of frozen bricks."""

    own: OwnBodies = field(default_factory=OwnBodies, init=False)
    frozen: set[BodyId] = field(default_factory=set, init=False)
    loose: dict[BodyId, None] = field(default_factory=dict, init=False)  # all others, in the order of release
    _ranks: dict[BodyId, int] = field(default_factory=dict, init=False)  # the order of addition
    _poses: dict[BodyId, Pose] = field(default_factory=dict, init=False)  # of bricks
    _initial_velocities: dict[BodyId, Vec3] = field(default_factory=dict, init=False)  # [m/s], if not 0
    _moving: dict[BodyId, BodyState] = field(default_factory=dict, init=False)  # states given by `set_state`
    _added: int = field(default=0, init=False)

    def add(self, brick: Brick, pose: Pose, velocity_W: Vec3) -> None:
        """Add a brick, at rest or with a velocity of its centre [m/s]."""
        self.own.add_brick(brick)
        self._added += 1
        self._ranks[brick.id], self._poses[brick.id], self.loose[brick.id] = self._added, pose, None
        if velocity_W != AT_REST:
            self._initial_velocities[brick.id] = velocity_W

    def remove(self, brick: BodyId) -> None:
        """Remove a brick."""
        self.own.remove_brick(brick)
        del self._poses[brick], self._ranks[brick]
        self._stop(brick)
        self.frozen.discard(brick)
        self.loose.pop(brick, None)

    def absorb(self, other: "StoredBodies") -> None:
        """Add all bricks of another instance, with their states."""
        for name in other.in_order(other.own.bricks):
            self.own.add_brick(other.own.bricks[name])
            self._added += 1
            self._ranks[name] = self._added
        self._poses |= other._poses
        self._initial_velocities |= other._initial_velocities
        self._moving |= other._moving
        self.frozen |= other.frozen
        self.loose |= other.loose

    def put(self, brick: BodyId, pose: Pose) -> None:
        """Move a brick to a pose; its velocity does not change."""
        self._poses[brick] = pose

    def set_state(self, brick: BodyId, state: BodyState) -> None:
        """Set the pose and the velocities of a brick."""
        self._poses[brick] = state.pose
        self._initial_velocities.pop(brick, None)
        self._moving[brick] = state

    def freeze(self, brick: BodyId) -> None:
        """Freeze a brick in its pose, at rest."""
        self.frozen.add(brick)
        self.loose.pop(brick, None)
        self._stop(brick)

    def release(self, brick: BodyId) -> None:
        """Release a frozen brick."""
        self.frozen.discard(brick)
        self.loose[brick] = None

    def _stop(self, brick: BodyId) -> None:
        self._initial_velocities.pop(brick, None)
        self._moving.pop(brick, None)

    def state(self, body: BodyId) -> BodyState:
        """Return the pose and motion of a brick or a plane."""
        if body in self.own.planes:
            return BodyState(Pose(self.own.planes[body].point_W))
        return self._moving.get(body) or BodyState(self._poses[body], self._initial_velocities.get(body, AT_REST))

    def in_order(self, bricks: Iterable[BodyId]) -> list[BodyId]:
        """Sort bricks in the order of their addition."""
        return sorted(bricks, key=self._ranks.__getitem__)

    def enter(self, world: World, bricks: Iterable[BodyId]) -> None:
        """Add bricks to a world that does not have them, with their states."""
        entering = self.in_order(bricks)
        for name in entering:
            world.add_brick(self.own.bricks[name], self._poses[name], self._initial_velocities.get(name, AT_REST))
        for name in entering:
            if name in self._moving:
                world.set_state(name, self._moving[name])
        for name in entering:
            if name in self.frozen:
                world.freeze(name)


class EngineWorld:
    """Base of an engine's world, with the methods that depend on its clock and on the declared bodies only.

    The operations of hands and stabilizers raise NotImplementedError here. An engine without them can play scenarios
    in which it moves all bricks.
    """

    own: OwnBodies
    clock: Clock

    def time(self) -> float:
        return self.clock.time

    def skip(self, duration: float) -> None:
        self.clock.time += duration

    def set_max_speed(self, fastest: float) -> None:
        self.clock.set_max_speed(fastest)

    def substep_next_contact(self) -> None:
        """Do nothing: settings with enough steps for impacts need no sub-steps for new contacts."""
        return

    def masses(self) -> Mapping[BodyId, float]:
        return self.own.masses

    def fixed(self) -> Set[BodyId]:
        return self.own.fixed

    def shape(self, body: BodyId) -> Shape:
        return self.own.shape(body)

    def gravity_W(self) -> Vec3 | None:
        """Return None: the caller that opens the world knows its gravity."""
        return None

    def wrong_friction(self) -> WrongFriction | None:
        """Return None: the engine has the requested coefficients."""
        return None

    # Operations that only hands and stabilizers need.

    def freeze(self, brick: BodyId) -> None:
        raise self._not_implemented("freeze", "a hand or a stabilizer")

    def holds(self, brick: BodyId) -> bool:
        raise self._not_implemented("holds", "a hand or a stabilizer")

    def wake(self, brick: BodyId) -> None:
        raise self._not_implemented("wake", "a hand or a stabilizer")

    def put_at(self, brick: BodyId, pose: Pose) -> None:
        raise self._not_implemented("put_at", "a stabilizer")

    def set_state(self, brick: BodyId, state: BodyState) -> None:
        raise self._not_implemented("set_state", "a stabilizer")

    def weld(self, bricks: Collection[BodyId]) -> None:
        raise self._not_implemented("weld", "a stabilizer with a joiner")

    def unweld(self, brick: BodyId) -> tuple[BodyId, ...]:
        raise self._not_implemented("unweld", "a stabilizer with a joiner")

    def apply_forces(self, brick: BodyId, forces: Sequence[AppliedForce]) -> None:
        raise self._not_implemented("apply_forces", "a stabilizer with a presser")

    def _not_implemented(self, operation: str, caller: str) -> NotImplementedError:
        return NotImplementedError(f"{type(self).__name__} does not implement `{operation}`, which {caller} needs")
