"""MuJoCo world, in which bricks can be welded into rigid groups."""

from collections.abc import Collection, Container, Sequence
from dataclasses import dataclass, field, replace
from typing import Self

from stability.contact_law import GivenFriction
from stability.dynamics.rigid_body import AppliedForce, pushed
from stability.dynamics.rigid_group import RigidGroup, grouped, member_state
from stability.engines.bodies import EngineWorld, OwnBodies
from stability.engines.mujoco.model import MjBody, MjScene, Model, build_model
from stability.engines.mujoco.settings import MuJoCoSettings
from stability.engines.pressing import AppliedLoads
from stability.engines.protocol import NOTHING_PRESCRIBED, PrescribedMotion, StepClock
from stability.model import AT_REST, BodyId, BodyState, Brick, ContactPoint, Plane, Pose, Vec3

# The bodies of a MuJoCo world, across its models.
#
# A model cannot be changed. So a change copies the states out of the model, and the next use builds a new one.


CENTRED = Pose((0.0, 0.0, 0.0))


@dataclass
class RemadeBodies:
    """Bricks and welded groups with their states."""

    settings: MuJoCoSettings
    gravity: float  # [m/s2], along -z
    friction: GivenFriction  # of brick on brick
    own: OwnBodies
    _bodies: dict[BodyId, MjBody] = field(default_factory=dict, init=False)  # as of the creation of the model
    _groups: dict[BodyId, tuple[BodyId, RigidGroup]] = field(default_factory=dict, init=False)  # by joined brick
    _model: Model | None = field(default=None, init=False)  # None after a change

    def model(self) -> Model:
        """Return the model of all bodies and planes."""
        if self._model is None:
            planes = list(self.own.planes.values())
            self._model = build_model(MjScene(self.settings, self.gravity, self.friction, planes, self._bodies))
        return self._model

    def take_over(self) -> None:
        """Copy the states out of the model, and drop it."""
        if self._model is not None:
            for name in self._model.free:
                self._bodies[name] = replace(self._bodies[name], state=self._model.state(name))
            self._model = None

    def add(self, brick: Brick, state: BodyState) -> None:
        """Add a brick."""
        self.take_over()
        self._bodies[brick.id] = MjBody(((brick, CENTRED),), state)

    def remove(self, brick: BodyId) -> None:
        """Unweld a brick and remove it."""
        self.part_from_others(brick)
        self.take_over()
        del self._bodies[brick]

    def put(self, brick: BodyId, state: BodyState, held: bool) -> None:
        """Set the state of a brick, and whether it is frozen."""
        self.take_over()
        self._bodies[brick] = replace(self._bodies[brick], state=state, held=held)

    def carry(self, bricks: Container[BodyId]) -> None:
        """Replace the set of carried bricks."""
        changed = [name for name, body in self._bodies.items() if body.carried != (name in bricks)]
        if changed:
            self.take_over()
        for name in changed:
            self._bodies[name] = replace(self._bodies[name], carried=name in bricks)

    def holds(self, brick: BodyId) -> bool:
        """Check that a brick is frozen and in no group."""
        return brick in self._bodies and self._bodies[brick].held

    def state(self, body: BodyId) -> BodyState:
        """Return pose and motion of a brick or a plane."""
        if body in self.own.planes:
            return BodyState(Pose(self.own.planes[body].point_W))
        if body in self._groups:
            name, group = self._groups[body]
            return member_state(self.state(name), group.places_G[body])
        if self._model is not None and body in self._model.free:
            return self._model.state(body)
        return self._bodies[body].state

    def group_members(self, brick: BodyId) -> Collection[BodyId]:
        """Return the bricks of a brick's group; none for a single brick."""
        return self._groups[brick][1].bricks.keys() if brick in self._groups else ()

    def weld(self, bricks: Collection[BodyId]) -> None:
        """Weld frozen bricks into one body, at rest."""
        group = grouped((self.own.bricks[brick], self.state(brick).pose) for brick in bricks)
        self.take_over()
        for brick in group.bricks:
            del self._bodies[brick]
        name = f"group of {next(iter(group.bricks))}"
        members = tuple((brick, group.places_G[brick.id]) for brick in group.bricks.values())
        self._bodies[name] = MjBody(members, BodyState(group.pose))
        self._groups |= dict.fromkeys(group.bricks, (name, group))

    def unweld(self, brick: BodyId) -> tuple[BodyId, ...]:
        """Split the group of a brick into single bodies; return their names."""
        name, group = self._groups[brick]
        states = {member: self.state(member) for member in group.bricks}
        self.take_over()
        del self._bodies[name]
        for member, state in states.items():
            del self._groups[member]
            self._bodies[member] = MjBody(((self.own.bricks[member], CENTRED),), state)
        return tuple(states)

    def part_from_others(self, brick: BodyId) -> None:
        """Unweld the group of a brick, if it is in one."""
        if brick in self._groups:
            self.unweld(brick)


@dataclass
class MuJoCoWorld(EngineWorld):
    """MuJoCo world of bricks and planes; create it by `opened`."""

    settings: MuJoCoSettings
    own: OwnBodies
    bodies: RemadeBodies
    clock: StepClock
    presses: AppliedLoads = field(default_factory=AppliedLoads, init=False)
    _stepped: Model | None = field(default=None, init=False)  # model of the last step

    @classmethod
    def opened(
        cls, settings: MuJoCoSettings, gravity: float, friction: GivenFriction, heaviest: float | None = None
    ) -> Self:
        """Open an empty world with gravity [m/s2] along -z; `heaviest` has no effect."""
        own = OwnBodies()
        return cls(settings, own, RemadeBodies(settings, gravity, friction, own), StepClock(settings))

    def close(self) -> None:
        self.bodies.take_over()
        self._stepped = None

    def step(self, prescribed: PrescribedMotion = NOTHING_PRESCRIBED) -> None:
        self.bodies.carry({name for name, motion in prescribed.guided.items() if motion.carried})
        self._stepped = self.bodies.model()
        self._stepped.pull(self.bodies.gravity, prescribed.acceleration_W)
        parts = self.clock.pass_step()
        self._stepped.step(self.settings.time_step, parts, self.presses, prescribed.guided)

    def states(self, bodies: Collection[BodyId]) -> dict[BodyId, BodyState]:
        return {body: self.bodies.state(body) for body in bodies}

    def contacts(self, brick: BodyId) -> Sequence[ContactPoint]:
        points = self._stepped.contacts(brick) if self._stepped is not None else ()
        bodies = self.own.bricks.keys() | self.own.planes.keys()
        return [point for point in points if point.a in bodies and point.b in bodies]

    def neighbours(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        boxes, group_members = self.bodies.model().bounds(planes=len(self.own.planes)), self.bodies.group_members(brick)
        return [other for other in self.own.neighbours(brick, boxes, within) if other not in group_members]

    def add_plane(self, plane: Plane) -> None:
        self.bodies.take_over()
        self.own.add_plane(plane)

    def add_brick(self, brick: Brick, pose: Pose, velocity_W: Vec3 = AT_REST) -> None:
        self.own.add_brick(brick)
        self.bodies.add(brick, BodyState(pose, velocity_W))

    def remove_brick(self, brick: BodyId) -> None:
        self.presses.leave(brick)
        self.bodies.remove(brick)
        self.own.remove_brick(brick)

    def push(self, brick: BodyId, impulse_W: Vec3, at_W: Vec3) -> None:
        self.set_state(brick, pushed(self.bodies.state(brick), self.own.bricks[brick], impulse_W, at_W))

    def apply_forces(self, brick: BodyId, forces: Sequence[AppliedForce]) -> None:
        self.presses.apply_forces(self.own.bricks[brick], self.bodies.state(brick), forces)

    def set_state(self, brick: BodyId, state: BodyState) -> None:
        self.bodies.part_from_others(brick)
        self.bodies.put(brick, state, held=False)

    def freeze(self, brick: BodyId) -> None:
        self.presses.leave(brick)
        self.bodies.part_from_others(brick)
        self.bodies.put(brick, BodyState(self.bodies.state(brick).pose), held=True)

    def holds(self, brick: BodyId) -> bool:
        return self.bodies.holds(brick)

    def wake(self, brick: BodyId) -> None:
        self.bodies.put(brick, self.bodies.state(brick), held=False)

    def put_at(self, brick: BodyId, pose: Pose) -> None:
        self.bodies.put(brick, BodyState(pose), held=True)

    def weld(self, bricks: Collection[BodyId]) -> None:
        for brick in bricks:
            self.presses.leave(brick)
        self.bodies.weld(bricks)

    def unweld(self, brick: BodyId) -> tuple[BodyId, ...]:
        return self.bodies.unweld(brick)
