"""A MuJoCo world of one's own; bricks can be joined in it, to move as one rigid body."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace
from typing import Self

from stability.engines.mujoco.mujoco_model import Body, Model, Scene, made
from stability.engines.mujoco.mujoco_settings import MuJoCoSettings
from stability.engines.own_bodies import KeptBodies
from stability.geometry.bounding_boxes import BoundingBoxes
from stability.mechanics.impulse import pushed
from stability.mechanics.rigid_group import RigidGroup, grouped, member_state
from stability.model import AT_REST, BodyId, BodyState, Brick, ContactPoint, Plane, Pose, Vec3

CENTRED = Pose((0.0, 0.0, 0.0))


@dataclass
class MuJoCoWorld(KeptBodies):
    """A world of its own for bricks and planes."""

    settings: MuJoCoSettings = field(kw_only=True)
    _bodies: dict[BodyId, Body] = field(default_factory=dict, init=False)  # as they were when the model was made
    _groups: dict[BodyId, tuple[BodyId, RigidGroup]] = field(default_factory=dict, init=False)  # by joined brick
    _model: Model | None = field(default=None, init=False)  # None when it has to be made anew
    _stepped: Model | None = field(default=None, init=False)  # the one that took the last step

    @classmethod
    def opened(cls, settings: MuJoCoSettings, gravity: float, friction: float) -> Self:
        """A new, empty world with gravity [m/s2] along -z."""
        return cls(gravity, friction, settings=settings)

    def close(self) -> None:
        self._model = self._stepped = None

    def step(self) -> None:
        self._stepped = self._made()
        self._stepped.step(self.settings.time_step, self._count_step())

    def states(self, bodies: Collection[BodyId]) -> dict[BodyId, BodyState]:
        return {body: self._state(body) for body in bodies}

    def _state(self, body: BodyId) -> BodyState:
        if body in self._planes:
            return BodyState(Pose(self._planes[body].point_W))
        if body in self._groups:
            name, group = self._groups[body]
            return member_state(self._state(name), group.places_G[body])
        if self._model is not None and body in self._model.free:
            return self._model.state(body)
        return self._bodies[body].state

    def contacts(self, brick: BodyId) -> Sequence[ContactPoint]:
        points = self._stepped.contacts(brick) if self._stepped is not None else ()
        return [point for point in points if self._is_there(point.a) and self._is_there(point.b)]

    def _is_there(self, body: BodyId) -> bool:
        return body in self._bricks or body in self._planes

    def near(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        fellows = self._groups[brick][1].bricks.keys() if brick in self._groups else ()
        return [other for other in super().near(brick, within) if other not in fellows]

    def _boxes(self) -> BoundingBoxes:
        return self._made().bounds(planes=len(self._planes))

    # --- what changes the model ---------------------------------------------------------------------------------------

    def add_plane(self, plane: Plane) -> None:
        self._unmake()
        self._keep_plane(plane)

    def add_brick(self, brick: Brick, pose: Pose, velocity_W: Vec3 = AT_REST) -> None:
        self._unmake()
        self._keep_brick(brick)
        self._bodies[brick.id] = Body(((brick, CENTRED),), BodyState(pose, velocity_W))

    def remove_brick(self, brick: BodyId) -> None:
        if brick in self._groups:
            self.part(brick)
        self._unmake()
        self._forget_brick(brick)
        del self._bodies[brick]

    def push(self, brick: BodyId, impulse_W: Vec3, at_W: Vec3) -> None:
        size, mass = self._bricks[brick].size, self._bricks[brick].mass
        self.set_state(brick, pushed(self._state(brick), size, mass, impulse_W, at_W))

    def set_state(self, brick: BodyId, state: BodyState) -> None:
        if brick in self._groups:
            self.part(brick)
        self._put(brick, state, held=False)

    def freeze(self, brick: BodyId) -> None:
        if brick in self._groups:
            self.part(brick)
        self._put(brick, BodyState(self._state(brick).pose), held=True)

    def holds(self, brick: BodyId) -> bool:
        return brick in self._bodies and self._bodies[brick].held

    def wake(self, brick: BodyId) -> None:
        self._put(brick, self._state(brick), held=False)

    def put_at(self, brick: BodyId, pose: Pose) -> None:
        self._put(brick, BodyState(pose), held=True)

    def join(self, bricks: Collection[BodyId]) -> None:
        group = grouped((self._bricks[brick], self._state(brick).pose) for brick in bricks)
        self._unmake()
        for brick in group.bricks:
            del self._bodies[brick]
        name = f"group of {next(iter(group.bricks))}"
        members = tuple((brick, group.places_G[brick.id]) for brick in group.bricks.values())
        self._bodies[name] = Body(members, BodyState(group.pose))
        self._groups |= dict.fromkeys(group.bricks, (name, group))

    def part(self, brick: BodyId) -> tuple[BodyId, ...]:
        name, group = self._groups[brick]
        states = self.states(group.bricks)
        self._unmake()
        del self._bodies[name]
        for member, state in states.items():
            del self._groups[member]
            self._bodies[member] = Body(((self._bricks[member], CENTRED),), state)
        return tuple(states)

    def _put(self, brick: BodyId, state: BodyState, held: bool) -> None:
        self._unmake()
        self._bodies[brick] = replace(self._bodies[brick], state=state, held=held)

    def _unmake(self) -> None:
        """Take over what the model knows, before it is made anew."""
        if self._model is not None:
            for name in self._model.free:
                self._bodies[name] = replace(self._bodies[name], state=self._model.state(name))
            self._model = None

    def _made(self) -> Model:
        if self._model is None:
            scene = Scene(self.settings, self.gravity, self.friction, list(self._planes.values()), self._bodies)
            self._model = made(scene)
        return self._model
