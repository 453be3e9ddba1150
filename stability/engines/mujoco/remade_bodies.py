"""The bodies of a MuJoCo world, through all models that are made of them.

A model cannot be changed, so what it knows is taken over when something else changes, and another is made when it is
needed.
"""

from collections.abc import Collection, Container
from dataclasses import dataclass, field, replace

from stability.engines.mujoco.mujoco_model import Body, Model, Scene, made
from stability.engines.mujoco.mujoco_settings import MuJoCoSettings
from stability.engines.own_bodies import OwnBodies
from stability.friction_law import GivenFriction
from stability.mechanics.rigid_group import RigidGroup, grouped, member_state
from stability.model import BodyId, BodyState, Brick, Pose

CENTRED = Pose((0.0, 0.0, 0.0))


@dataclass
class RemadeBodies:
    """Bricks and groups of bricks, each with its state."""

    settings: MuJoCoSettings
    gravity: float  # [m/s2], along -z
    friction: GivenFriction  # of brick on brick
    own: OwnBodies
    _bodies: dict[BodyId, Body] = field(default_factory=dict, init=False)  # as they were when the model was made
    _groups: dict[BodyId, tuple[BodyId, RigidGroup]] = field(default_factory=dict, init=False)  # by joined brick
    _model: Model | None = field(default=None, init=False)  # None when it has to be made anew

    def model(self) -> Model:
        """A model of all that is there."""
        if self._model is None:
            planes = list(self.own.planes.values())
            self._model = made(Scene(self.settings, self.gravity, self.friction, planes, self._bodies))
        return self._model

    def take_over(self) -> None:
        """Take over what the model knows, before it is made anew."""
        if self._model is not None:
            for name in self._model.free:
                self._bodies[name] = replace(self._bodies[name], state=self._model.state(name))
            self._model = None

    def add(self, brick: Brick, state: BodyState) -> None:
        """Let a brick come."""
        self.take_over()
        self._bodies[brick.id] = Body(((brick, CENTRED),), state)

    def remove(self, brick: BodyId) -> None:
        """Let a brick go, parted from all others."""
        self.part_from_others(brick)
        self.take_over()
        del self._bodies[brick]

    def put(self, brick: BodyId, state: BodyState, held: bool) -> None:
        """Put a brick somewhere, or hold it there."""
        self.take_over()
        self._bodies[brick] = replace(self._bodies[brick], state=state, held=held)

    def carry(self, bricks: Container[BodyId]) -> None:
        """Let somebody outside carry these from now on, and no others."""
        changed = [name for name, body in self._bodies.items() if body.carried != (name in bricks)]
        if changed:
            self.take_over()
        for name in changed:
            self._bodies[name] = replace(self._bodies[name], carried=name in bricks)

    def holds(self, brick: BodyId) -> bool:
        """Whether a brick is held by itself."""
        return brick in self._bodies and self._bodies[brick].held

    def state(self, body: BodyId) -> BodyState:
        """Pose and motion of a brick or a plane."""
        if body in self.own.planes:
            return BodyState(Pose(self.own.planes[body].point_W))
        if body in self._groups:
            name, group = self._groups[body]
            return member_state(self.state(name), group.places_G[body])
        if self._model is not None and body in self._model.free:
            return self._model.state(body)
        return self._bodies[body].state

    def fellows(self, brick: BodyId) -> Collection[BodyId]:
        """The bricks of the group that a brick is in; none if it is by itself."""
        return self._groups[brick][1].bricks.keys() if brick in self._groups else ()

    def join(self, bricks: Collection[BodyId]) -> None:
        """Let bricks that are held be one body from now on, at rest."""
        group = grouped((self.own.bricks[brick], self.state(brick).pose) for brick in bricks)
        self.take_over()
        for brick in group.bricks:
            del self._bodies[brick]
        name = f"group of {next(iter(group.bricks))}"
        members = tuple((brick, group.places_G[brick.id]) for brick in group.bricks.values())
        self._bodies[name] = Body(members, BodyState(group.pose))
        self._groups |= dict.fromkeys(group.bricks, (name, group))

    def part(self, brick: BodyId) -> tuple[BodyId, ...]:
        """Let all that a brick is joined to be bodies by themselves; these are they."""
        name, group = self._groups[brick]
        states = {member: self.state(member) for member in group.bricks}
        self.take_over()
        del self._bodies[name]
        for member, state in states.items():
            del self._groups[member]
            self._bodies[member] = Body(((self.own.bricks[member], CENTRED),), state)
        return tuple(states)

    def part_from_others(self, brick: BodyId) -> None:
        """Part a brick from what it is joined to, if it is."""
        if brick in self._groups:
            self.part(brick)
