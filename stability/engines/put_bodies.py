"""What a world of one's own knows of its bodies while no engine steps them: where they are and how they move."""

from collections.abc import Iterable
from dataclasses import dataclass, field

from stability.engines.own_bodies import OwnBodies
from stability.engines.protocol import World
from stability.model import AT_REST, BodyId, BodyState, Brick, Pose, Vec3


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
