"""The planes and bricks of a world and their states, kept without asking an engine."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING

from stability.engines.protocol import World
from stability.model import AT_REST, BodyId, BodyState, Brick, HalfSpace, Plane, Pose, Shape, Vec3

if TYPE_CHECKING:
    from stability.geometry.bounding_boxes import BoundingBoxes


# The planes and bricks of a world, known without asking an engine.


@dataclass
class OwnBodies:
    """The planes and bricks of a world by name, in the order in which they came."""

    planes: dict[BodyId, Plane] = field(default_factory=dict)
    bricks: dict[BodyId, Brick] = field(default_factory=dict)
    # As `Engine` promises, these are other objects once something has come or gone.
    masses: Mapping[BodyId, float] = field(default_factory=dict, init=False)  # of bricks [kg]
    fixed: frozenset[BodyId] = field(default=frozenset(), init=False)  # the planes
    _masses: dict[BodyId, float] = field(default_factory=dict, init=False)

    def add_plane(self, plane: Plane) -> None:
        """Know a plane from now on."""
        self.planes[plane.id] = plane
        self.fixed = frozenset(self.planes)

    def add_brick(self, brick: Brick) -> None:
        """Know a brick from now on."""
        self.bricks[brick.id] = brick
        self._masses[brick.id] = brick.mass
        self.masses = MappingProxyType(self._masses)

    def remove_brick(self, brick: BodyId) -> None:
        """Forget a brick."""
        del self.bricks[brick], self._masses[brick]
        self.masses = MappingProxyType(self._masses)

    def shape(self, body: BodyId) -> Shape:
        """The shape of a body, as it was asked for."""
        return HalfSpace(self.planes[body].normal_W) if body in self.planes else self.bricks[body].shape

    def neighbours(self, brick: BodyId, boxes: "BoundingBoxes", within: float) -> Sequence[BodyId]:
        """The bodies that may be as close to a brick as this [m], by the boxes around all bricks as they are now."""
        planes = [name for name, plane in self.planes.items() if boxes.reaches_plane(brick, plane, within)]
        return sorted([*boxes.neighbours(brick, within), *planes])


# The states of bodies that no engine steps.


@dataclass
class PutBodies:
    """What was put where, and what of it was let go, put in motion or frozen since."""

    own: OwnBodies = field(default_factory=OwnBodies, init=False)
    frozen: set[BodyId] = field(default_factory=set, init=False)
    loose: dict[BodyId, None] = field(default_factory=dict, init=False)  # all others, in the order of coming loose
    _ranks: dict[BodyId, int] = field(default_factory=dict, init=False)  # who came before whom
    _poses: dict[BodyId, Pose] = field(default_factory=dict, init=False)  # of bricks
    _let_go: dict[BodyId, Vec3] = field(default_factory=dict, init=False)  # those that came with a velocity [m/s]
    _moving: dict[BodyId, BodyState] = field(default_factory=dict, init=False)  # those put somewhere in motion
    _came: int = field(default=0, init=False)

    def add(self, brick: Brick, pose: Pose, velocity_W: Vec3) -> None:
        """Know a brick from now on, at rest or with a velocity of its centre [m/s]."""
        self.own.add_brick(brick)
        self._came += 1
        self._ranks[brick.id], self._poses[brick.id], self.loose[brick.id] = self._came, pose, None
        if velocity_W != AT_REST:
            self._let_go[brick.id] = velocity_W

    def remove(self, brick: BodyId) -> None:
        """Forget a brick."""
        self.own.remove_brick(brick)
        del self._poses[brick], self._ranks[brick]
        self._stop(brick)
        self.frozen.discard(brick)
        self.loose.pop(brick, None)

    def absorb(self, other: "PutBodies") -> None:
        """Know all bricks of another one, as they are there."""
        for name in other.in_order(other.own.bricks):
            self.own.add_brick(other.own.bricks[name])
            self._came += 1
            self._ranks[name] = self._came
        self._poses |= other._poses
        self._let_go |= other._let_go
        self._moving |= other._moving
        self.frozen |= other.frozen
        self.loose |= other.loose

    def put(self, brick: BodyId, pose: Pose) -> None:
        """Put a brick somewhere else; nothing else of it changes."""
        self._poses[brick] = pose

    def set_state(self, brick: BodyId, state: BodyState) -> None:
        """Put a brick somewhere else, in motion."""
        self._poses[brick] = state.pose
        self._let_go.pop(brick, None)
        self._moving[brick] = state

    def freeze(self, brick: BodyId) -> None:
        """Hold a brick where it is."""
        self.frozen.add(brick)
        self.loose.pop(brick, None)
        self._stop(brick)

    def loosen(self, brick: BodyId) -> None:
        """Let a brick go that was held."""
        self.frozen.discard(brick)
        self.loose[brick] = None

    def _stop(self, brick: BodyId) -> None:
        self._let_go.pop(brick, None)
        self._moving.pop(brick, None)

    def state(self, body: BodyId) -> BodyState:
        """Pose and motion of a brick or a plane, as it was put."""
        if body in self.own.planes:
            return BodyState(Pose(self.own.planes[body].point_W))
        return self._moving.get(body) or BodyState(self._poses[body], self._let_go.get(body, AT_REST))

    def in_order(self, bricks: Iterable[BodyId]) -> list[BodyId]:
        """These bricks in the order in which they came."""
        return sorted(bricks, key=self._ranks.__getitem__)

    def enter(self, world: World, bricks: Iterable[BodyId]) -> None:
        """Put bricks into a world that does not know them."""
        entering = self.in_order(bricks)
        for name in entering:
            world.add_brick(self.own.bricks[name], self._poses[name], self._let_go.get(name, AT_REST))
        for name in entering:
            if name in self._moving:
                world.set_state(name, self._moving[name])
        for name in entering:
            if name in self.frozen:
                world.freeze(name)
