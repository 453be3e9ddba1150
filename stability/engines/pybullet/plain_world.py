"""A PyBullet world of one's own, with every setting that matters made explicit; every brick moves by itself."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from math import log10, sqrt
from types import MappingProxyType
from typing import Self

from stability.engines.pybullet.parameters import engine_parameters, step_parameters
from stability.engines.pybullet.planes import ALL, ROUNDED, PlanesWorld
from stability.engines.pybullet.pybullet_binding import pybullet
from stability.engines.settings import EngineSettings
from stability.engines.stepping import Awake, Stepping, stepping
from stability.geometry.vectors import add, scale
from stability.mechanics.impulse import pushed
from stability.model import AT_REST, BodyId, BodyState, Brick, Pose, Quaternion, Shape, Vec3
from stability.shapes.box import Box, as_box

# Of soft contacts, of the root of stiffness times mass: 2 damps one alone critically. With 4 a V lands from 10 cm and
# stays; with 2 it slips with 5 % more friction than it needs.
DAMPING = 4.0
# [engine kg] for the heaviest brick: far above the thresholds, and even ten thousand press far below the cap of 1e10.
HEAVIEST = 1e4


@dataclass
class PlainWorld(PlanesWorld):
    """A world of its own for bricks and planes; close it after use."""

    gravity: float = field(default=0.0, init=False)  # [m/s2] along -z
    _fastest: float = field(default=0.0, init=False)  # [m/s]
    _stepping: Stepping | None = field(default=None, init=False)  # None: something else is awake, look again
    _told_stepping: Stepping = field(init=False)  # what the engine knows
    _last_step: float = field(default=0.0, init=False)  # how long the last engine step was [s]
    _let_go: set[BodyId] = field(default_factory=set, init=False)  # since the last step
    _flying: set[BodyId] = field(default_factory=set, init=False)  # let go, and not seen to touch anything since
    _eased: int = field(default=0, init=False)  # steps to come in which bodies begin to press
    _anchored: set[BodyId] = field(default_factory=set, init=False)  # bricks held by springs while all is quiet
    _bricks: dict[BodyId, Brick] = field(default_factory=dict, init=False)
    _masses_view: Mapping[BodyId, float] = field(default_factory=dict, init=False)  # what `masses` answers with

    def __post_init__(self) -> None:
        super().__post_init__()
        self._told_stepping = stepping(self.settings, Awake())

    @classmethod
    def opened(cls, settings: EngineSettings, gravity: float, friction: float, heaviest: float | None = None) -> Self:
        """A new, empty world with gravity [m/s2] along -z.

        Nothing depends on the unit of mass but the solver's absolute thresholds and its cap on impulses, so with scaled
        settings it is chosen by the mass of the heaviest brick to come [kg].
        """
        client = pybullet.connect(pybullet.DIRECT)
        if client < 0:
            raise RuntimeError("PyBullet accepts no more clients in this process")
        world = cls(client, settings=settings, friction=friction)
        world.scale = settings.scale
        if heaviest is not None and settings.scale != 1.0:
            world._mass_unit = 10.0 ** round(log10(HEAVIEST / heaviest))
        world.gravity = gravity
        pybullet.setGravity(0.0, 0.0, -gravity, client)
        pybullet.setPhysicsEngineParameter(**engine_parameters(settings), physicsClientId=client)
        return world

    def close(self) -> None:
        """End the world; nothing of it is left."""
        pybullet.disconnect(self.client)

    def step(self) -> None:
        parts = self._suited().parts
        self._first_step(self.settings.time_step / parts)
        for _ in range(parts - 1):
            pybullet.stepSimulation(self.client)
        if self._eased:
            self._eased -= 1
            self._stepping = self._stepping if self._eased else None
        self._clock += self.settings.time_step

    def _first_step(self, duration: float) -> None:
        """Take an engine step of a duration [s], the first after what was let go since the last.

        PyBullet moves a body on by the speed that it will have. So speeds belong to the middle of a step, and gravity
        acts from there to the middle of the next: for half a step on what was let go, and for the mean of two steps
        where they change.
        """
        last, self._last_step = self._last_step or duration, duration
        if self._let_go:
            self._lift(0.5 * self.gravity * last)
        if last == duration or not self.settings.exact_fall:
            pybullet.stepSimulation(self.client)
            return
        pybullet.setGravity(0.0, 0.0, -0.5 * self.gravity * (last + duration) / duration, self.client)
        pybullet.stepSimulation(self.client)
        pybullet.setGravity(0.0, 0.0, -self.gravity, self.client)

    def limit_travel(self, fastest: float) -> None:
        """Say how fast the bodies of the coming steps are at most [m/s]; steps are taken to suit that."""
        self._fastest, self._stepping = fastest, None

    def ease_in(self) -> None:
        """Say that bodies which did not press on each other begin to: split the first steps, as the settings say."""
        self._eased, self._stepping = self.settings.first_steps, None

    def _suited(self) -> Stepping:
        """How to step what is awake; the engine knows it."""
        if self._stepping is None:
            self._stepping = stepping(self.settings, Awake(self._fastest, self._mass_ratio(), self._eased > 0))
            if self._stepping != self._told_stepping:
                parameters = step_parameters(self.settings, self._stepping)
                pybullet.setPhysicsEngineParameter(**parameters, physicsClientId=self.client)
                turned = self._stepping.lively != self._told_stepping.lively
                self._told_stepping = self._stepping
                if turned:
                    self._anchor(sorted(self._anchored), not self._stepping.lively)
                    self._choose_planes(self._stepping.lively)
        return self._stepping

    def _anchor(self, bricks: Collection[BodyId], held: bool) -> None:
        """Hold the resting contacts of these bricks by springs, or do so no more."""
        for brick in bricks:
            pybullet.changeDynamics(self._bodies[brick], -1, frictionAnchor=int(held), physicsClientId=self.client)

    def _mass_ratio(self) -> float:
        """How many times the mass of the lightest body that is awake the heaviest has."""
        if self.settings.most_mass_ratio is None:
            return 1.0
        masses = self._awake_masses()
        return max(masses) / min(masses) if masses else 1.0

    def _awake_masses(self) -> list[float]:
        return [mass for name, mass in self._masses.items() if not self.holds(name)]

    def _lift(self, speed: float) -> None:
        """Throw what was let go upwards [m/s]."""
        for name in sorted(self._let_go):
            body = self._bodies[name]
            (vx, vy, vz), angular_velocity = pybullet.getBaseVelocity(body, self.client)
            lifted = (vx, vy, vz + speed * sqrt(self.scale))
            pybullet.resetBaseVelocity(body, lifted, angular_velocity, physicsClientId=self.client)
        self._flying |= self._let_go
        self._let_go.clear()

    def states(self, bodies: Collection[BodyId]) -> dict[BodyId, BodyState]:
        found = super().states(bodies)
        for name in self._flying & found.keys():
            if pybullet.getContactPoints(bodyA=self._bodies[name], physicsClientId=self.client):
                self._flying.discard(name)
            else:  # its speed is that of the middle of the last step
                since = (0.0, 0.0, -0.5 * self.gravity * self._last_step)
                found[name] = replace(found[name], velocity_W=add(found[name].velocity_W, since))
        return found

    def _stays(self, body: BodyId) -> None:
        """Note that a body is not awake any more."""
        self._stepping = None
        self._let_go.discard(body)
        self._flying.discard(body)

    def _comes_free(self, body: BodyId) -> None:
        """Note that a body is awake from now on."""
        self._stepping = None
        if self.settings.exact_fall:
            self._let_go.add(body)

    def skip(self, duration: float) -> None:
        """Let time pass in which nothing can move."""
        self._clock += duration

    def masses(self) -> Mapping[BodyId, float]:
        return self._masses_view

    def _notice_bodies(self) -> None:
        """Nobody else brings bodies into this world."""

    def shape(self, body: BodyId) -> Shape:
        if body in self._bricks:
            return self._bricks[body].shape
        side = 2.0 * self._reach
        return Box((side, side, side))

    def holds(self, brick: BodyId) -> bool:
        return float(pybullet.getDynamicsInfo(self._bodies[brick], -1, self.client)[0]) == 0.0

    def add_brick(self, brick: Brick, pose: Pose, velocity_W: Vec3 = AT_REST) -> None:
        """Set a brick down at rest, or let it go with a velocity of its centre [m/s]."""
        if not self._bricks:
            self._begin_about(brick, pose.position_W)
        self._reach_beyond(brick, pose.position_W)
        square = self._square(pose)
        body = self._brick_body(brick, scale(self.scale, pose.position_W), pose.orientation, rounded=not square)
        self._bricks[brick.id] = brick
        self._masses[brick.id] = brick.mass
        self._masses_view = MappingProxyType(self._masses)  # another object says that a brick has come
        if velocity_W != AT_REST:
            self._set_motion(body, velocity_W, AT_REST)
        if square and self.settings.friction_anchor:  # those that lean stand where they should slip if they are held
            self._anchored.add(brick.id)
            self._anchor([brick.id], not self._told_stepping.lively)
        self._comes_free(brick.id)

    def _brick_body(self, brick: Brick, position: Vec3, orientation: Quaternion, rounded: bool) -> int:
        """The number of a new body of a brick, at a place in engine metres, with sharp or rounded edges."""
        half = scale(0.5 * self.scale, as_box(brick.shape, "PyBullet").size)
        radius = self.scale * self._edge_radius(brick)
        shape = self._solids.rounded_box(half, radius) if radius and rounded else self._solids.box(half)
        body = self._body(brick.mass, shape, position, orientation)
        self._name(body, brick.id, self._own_friction())
        if radius:
            pybullet.changeDynamics(body, -1, collisionMargin=radius, physicsClientId=self.client)
            if rounded:
                self._round(body, brick.mass, brick.shape.least_thickness)
            self._weigh(body, brick.mass, brick.shape.moments(brick.mass))
        return body

    def _round(self, body: int, mass: float, thickness: float) -> None:
        """Tell a body with rounded edges, of a mass [kg] and a smallest side [m], what it meets, and how softly."""
        if self.settings.half_spaces:
            self._meets(body, ROUNDED, ALL)
        if self.settings.sinking and self.gravity:
            weight = mass * self._mass_unit * self.gravity
            stiffness = weight / (self.settings.sinking * thickness * self.scale)
            pybullet.changeDynamics(
                body,
                -1,
                contactStiffness=stiffness,
                contactDamping=DAMPING * sqrt(stiffness * mass * self._mass_unit),
                physicsClientId=self.client,
            )

    def freeze(self, brick: BodyId) -> None:
        super().freeze(brick)
        self._stays(brick)

    def _edge_radius(self, brick: Brick) -> float:
        """How much the edges of a brick are rounded [m]."""
        return self.settings.edge_rounding * brick.shape.least_thickness

    def wake(self, brick: BodyId) -> None:
        super().wake(brick)
        self._comes_free(brick)
        if self.settings.edge_rounding:
            shape, mass = self._bricks[brick].shape, self._bricks[brick].mass
            self._weigh(self._bodies[brick], mass, shape.moments(mass))

    def _weigh(self, body: int, mass: float, inertia: Vec3) -> None:
        """Give a body its moments of inertia [kg m2]: PyBullet takes those of a bounding box with margins.

        The mass must be said again, or a body in maximal coordinates loses it.
        """
        pybullet.changeDynamics(
            body,
            -1,
            mass=mass * self._mass_unit,
            localInertiaDiagonal=scale(self._mass_unit * self.scale**2, inertia),
            physicsClientId=self.client,
        )

    def push(self, brick: BodyId, impulse_W: Vec3, at_W: Vec3) -> None:
        """Give a brick that is not frozen an impulse [N s] at a point [m]."""
        after = pushed(self.states([brick])[brick], self._bricks[brick], impulse_W, at_W)
        self._set_motion(self._bodies[brick], after.velocity_W, after.angular_velocity_W)
        if brick in self._flying:
            self._comes_free(brick)

    def set_state(self, brick: BodyId, state: BodyState) -> None:
        """Put a brick that is not frozen somewhere else, in motion."""
        self.put_at(brick, state.pose)
        self._stays(brick)  # as for falling: its speed is of this moment, whatever it touches
        self._set_motion(self._bodies[brick], state.velocity_W, state.angular_velocity_W)

    def _set_motion(self, body: int, velocity_W: Vec3, angular_velocity_W: Vec3) -> None:
        rate = sqrt(self.scale)
        pybullet.resetBaseVelocity(
            body, scale(rate, velocity_W), scale(1.0 / rate, angular_velocity_W), physicsClientId=self.client
        )

    def remove_brick(self, brick: BodyId) -> None:
        """Take a brick out; its name is free again."""
        body = self._bodies.pop(brick)
        pybullet.removeBody(body, self.client)
        del self.names[body], self._bricks[brick], self._masses[brick]
        self._stays(brick)
        self._anchored.discard(brick)
        self._masses_view = MappingProxyType(self._masses)
