"""A PyBullet world of one's own, with every setting that matters made explicit; every brick moves by itself."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import log10, sqrt
from types import MappingProxyType
from typing import Self

from stability.engine_settings import EngineSettings
from stability.geometry import body_axes
from stability.impulse import moments, pushed
from stability.model import AT_REST, BodyId, BodyState, Box, Brick, Plane, Pose, Quaternion, Shape, Vec3
from stability.pybullet_engine.binding import pybullet
from stability.pybullet_engine.bodies import PyBulletBodies
from stability.pybullet_engine.parameters import body_parameters, engine_parameters, step_parameters
from stability.pybullet_engine.solids import Solids
from stability.stepping import Awake, Stepping, stepping
from stability.vectors import dot, plus, times

# Combined friction is the product of two bodies' own; this stands for "none" where a partner must still reach its own.
FRICTIONLESS = 1e-6
# Of soft contacts, of the root of stiffness times mass: 2 damps one alone critically. With 4 a V lands from 10 cm and
# stays; with 2 it slips with 5 % more friction than it needs.
DAMPING = 4.0
# Half the side of the box that stands for a half-space [m]. A box, because PyBullet gives a box on a plane one contact
# point a step, and a box on a box all four at once.
HALF_SPACE = 1e5
# [m] The same beside bricks with rounded edges: contacts with a larger box lose their precision. At 1e5 a ladder stands
# 1 deg lower than it should; at 1e3 bricks that are joined stick to a slope.
HALF_SPACE_BESIDE_HULLS = 1e2
# How many times further than any brick was set down such a box must reach, or it is made anew.
ROOM = 10.0
# Collision groups, and the mask of what meets all: PyBullet's own of what is made with mass, and two more.
SHARP, ROUNDED, HALF_SPACES, ALL = 1, 64, 128, -1
# Edges are not rounded by more than this share of a brick's smallest side, however small it is.
MOST_ROUNDED = 0.013
# A brick lies square if the cosine of an axis of it to the vertical, or to the normal of a slope, is more than this: by
# 0.1 deg.
SQUARE = 1.0 - 1.5e-6
UP: Vec3 = (0.0, 0.0, 1.0)
# [engine kg] for the heaviest brick: far above the thresholds, and even ten thousand press far below the cap of 1e10.
HEAVIEST = 1e4


@dataclass
class PlainWorld(PyBulletBodies):
    """A world of its own for bricks and planes; close it after use."""

    settings: EngineSettings = field(kw_only=True)
    friction: float = field(kw_only=True)  # Coulomb coefficient of brick on brick
    gravity: float = field(default=0.0, init=False)  # [m/s2] along -z
    _fastest: float = field(default=0.0, init=False)  # [m/s]
    _stepping: Stepping | None = field(default=None, init=False)  # None: something else is awake, look again
    _told_stepping: Stepping = field(init=False)  # what the engine knows
    _last_step: float = field(default=0.0, init=False)  # how long the last engine step was [s]
    _let_go: set[BodyId] = field(default_factory=set, init=False)  # since the last step
    _flying: set[BodyId] = field(default_factory=set, init=False)  # let go, and not seen to touch anything since
    _eased: int = field(default=0, init=False)  # steps to come in which bodies begin to press
    _anchored: set[BodyId] = field(default_factory=set, init=False)  # bricks held by springs while all is quiet
    _solids: Solids = field(init=False)
    _planes: dict[BodyId, Plane] = field(default_factory=dict, init=False)
    _half_spaces: list[int] = field(default_factory=list, init=False)  # the bodies that stand for planes beside hulls
    _reach: float = field(default=HALF_SPACE, init=False)  # half the side of the boxes that stand for planes [m]
    _bricks: dict[BodyId, Brick] = field(default_factory=dict, init=False)
    _told: Mapping[BodyId, float] = field(default_factory=dict, init=False)  # what `masses` answers with

    def __post_init__(self) -> None:
        self._solids = Solids(self.client)
        self._told_stepping = stepping(self.settings, Awake())
        if self.settings.edge_radius:
            self._reach = HALF_SPACE_BESIDE_HULLS

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
                    self._choose_planes()
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
            (vx, vy, vz), turning = pybullet.getBaseVelocity(body, self.client)
            lifted = (vx, vy, vz + speed * sqrt(self.scale))
            pybullet.resetBaseVelocity(body, lifted, turning, physicsClientId=self.client)
        self._flying |= self._let_go
        self._let_go.clear()

    def states(self, bodies: Collection[BodyId]) -> dict[BodyId, BodyState]:
        found = super().states(bodies)
        for name in self._flying & found.keys():
            if pybullet.getContactPoints(bodyA=self._bodies[name], physicsClientId=self.client):
                self._flying.discard(name)
            else:  # its speed is that of the middle of the last step
                since = (0.0, 0.0, -0.5 * self.gravity * self._last_step)
                found[name] = replace(found[name], velocity_W=plus(found[name].velocity_W, since))
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
        return self._told

    def _notice_bodies(self) -> None:
        """Nobody else brings bodies into this world."""

    def shape(self, body: BodyId) -> Shape:
        if body in self._bricks:
            return Box(self._bricks[body].size)
        side = 2.0 * self._reach
        return Box((side, side, side))

    def holds(self, brick: BodyId) -> bool:
        return float(pybullet.getDynamicsInfo(self._bodies[brick], -1, self.client)[0]) == 0.0

    def add_plane(self, plane: Plane) -> None:
        """Put up the ground or a wall."""
        self._planes[plane.id] = plane
        self._fixed |= {plane.id}
        if self.settings.half_spaces:
            self._put_up_half_space(plane)
        self._put_up(plane)
        self._choose_planes()

    def _around(self, low: Sequence[float], high: Sequence[float]) -> set[BodyId]:
        # The bounds of a half-space meet everything; the box that also stands for it tells whether it is near.
        around = pybullet.getOverlappingObjects(low, high, physicsClientId=self.client)
        return {self.names[body] for body, _ in around or () if body not in self._half_spaces}

    def _reach_beyond(self, brick: Brick, pose: Pose) -> None:
        """Make the boxes that stand for planes anew if a brick comes near their ends."""
        needed = ROOM * (max(map(abs, pose.position_W)) + max(brick.size))
        if needed <= self._reach or not self.settings.edge_radius:
            return
        self._reach = 2.0 * needed
        for plane in self._planes.values():
            body = self._bodies.pop(plane.id)
            pybullet.removeBody(body, self.client)
            del self.names[body]
            self._put_up(plane)
        self._choose_planes()

    def _put_up(self, plane: Plane) -> None:
        """Put up the box that stands for a plane."""
        depth = self._reach * self.scale
        centre = plus(times(self.scale, plane.point_W), times(-depth, plane.normal_W))
        body = self._body(0.0, self._solids.box((depth, depth, depth)), centre, _turning_z_to(plane.normal_W))
        self._name(body, plane.id, plane.friction / self._own_friction())

    def _put_up_half_space(self, plane: Plane) -> None:
        """Put up what stands for a plane beside bricks with rounded edges."""
        position = times(self.scale, plane.point_W)
        body = self._body(0.0, self._solids.half_space(), position, _turning_z_to(plane.normal_W))
        self._name(body, plane.id, plane.friction / self._own_friction())
        self._half_spaces.append(body)

    def _choose_planes(self) -> None:
        """Let rounded bricks meet half-spaces while all is slow, and boxes while something is fast.

        A half-space takes a brick that lands on an edge at one end of it, and throws it round; a box does not.
        """
        if not self._half_spaces:
            return
        lively = self._told_stepping.lively
        for plane in self._planes:
            self._meets(self._bodies[plane], SHARP, SHARP | ROUNDED if lively else SHARP)
        for body in self._half_spaces:
            self._meets(body, HALF_SPACES, 0 if lively else ROUNDED)

    def _meets(self, body: int, group: int, mask: int) -> None:
        """Put a body into a collision group, and say which groups it meets."""
        pybullet.setCollisionFilterGroupMask(body, -1, group, mask, self.client)

    def add_brick(self, brick: Brick, pose: Pose, velocity_W: Vec3 = AT_REST) -> None:
        """Set a brick down at rest, or let it go with a velocity of its centre [m/s]."""
        self._reach_beyond(brick, pose)
        square = self._square(pose)
        body = self._brick_body(brick, times(self.scale, pose.position_W), pose.orientation, rounded=not square)
        self._bricks[brick.id] = brick
        self._masses[brick.id] = brick.mass
        self._told = MappingProxyType(self._masses)  # another object says that a brick has come
        if velocity_W != AT_REST:
            self._set_motion(body, velocity_W, AT_REST)
        if square and self.settings.friction_anchor:  # those that lean stand where they should slip if they are held
            self._anchored.add(brick.id)
            self._anchor([brick.id], not self._told_stepping.lively)
        self._comes_free(brick.id)

    def _square(self, pose: Pose) -> bool:
        """Whether a brick lies square to the vertical or to a slope."""
        slopes = (plane.normal_W for plane in self._planes.values() if plane.normal_W[2] > 0.0)
        return lies_square(pose, (UP, *slopes))

    def _brick_body(self, brick: Brick, position: Vec3, orientation: Quaternion, rounded: bool) -> int:
        """The number of a new body of a brick, at a place in engine metres, with sharp or rounded edges."""
        half = times(0.5 * self.scale, brick.size)
        radius = self.scale * self._edge_radius(brick)
        shape = self._solids.rounded_box(half, radius) if radius and rounded else self._solids.box(half)
        body = self._body(brick.mass, shape, position, orientation)
        self._name(body, brick.id, self._own_friction())
        if radius:
            pybullet.changeDynamics(body, -1, collisionMargin=radius, physicsClientId=self.client)
            if rounded:
                self._round(body, brick.mass, min(brick.size))
            self._weigh(body, brick.mass, moments(brick.size, brick.mass))
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
        return min(self.settings.edge_radius, MOST_ROUNDED * min(brick.size))

    def wake(self, brick: BodyId) -> None:
        super().wake(brick)
        self._comes_free(brick)
        if self.settings.edge_radius:
            size, mass = self._bricks[brick].size, self._bricks[brick].mass
            self._weigh(self._bodies[brick], mass, moments(size, mass))

    def _body(self, mass: float, shape: int, position: Vec3, orientation: Quaternion) -> int:
        """The number of a new body of a mass [kg], at a place in engine metres."""
        return int(
            pybullet.createMultiBody(
                baseMass=mass * self._mass_unit,
                baseCollisionShapeIndex=shape,
                basePosition=position,
                baseOrientation=orientation,
                useMaximalCoordinates=int(self.settings.maximal_coordinates),
                physicsClientId=self.client,
            )
        )

    def _weigh(self, body: int, mass: float, inertia: Vec3) -> None:
        """Give a body its moments of inertia [kg m2]: PyBullet takes those of a bounding box with margins.

        The mass must be said again, or a body in maximal coordinates loses it.
        """
        pybullet.changeDynamics(
            body,
            -1,
            mass=mass * self._mass_unit,
            localInertiaDiagonal=times(self._mass_unit * self.scale**2, inertia),
            physicsClientId=self.client,
        )

    def push(self, brick: BodyId, impulse_W: Vec3, at_W: Vec3) -> None:
        """Give a brick that is not frozen an impulse [N s] at a point [m]."""
        size, mass = self._bricks[brick].size, self._bricks[brick].mass
        after = pushed(self.states([brick])[brick], size, mass, impulse_W, at_W)
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
            body, times(rate, velocity_W), times(1.0 / rate, angular_velocity_W), physicsClientId=self.client
        )

    def remove_brick(self, brick: BodyId) -> None:
        """Take a brick out; its name is free again."""
        body = self._bodies.pop(brick)
        pybullet.removeBody(body, self.client)
        del self.names[body], self._bricks[brick], self._masses[brick]
        self._stays(brick)
        self._anchored.discard(brick)
        self._told = MappingProxyType(self._masses)

    def _own_friction(self) -> float:
        return max(sqrt(self.friction), FRICTIONLESS)

    def _name(self, body: int, name: BodyId, own_friction: float) -> None:
        parameters = body_parameters(self.settings, own_friction)
        pybullet.changeDynamics(body, -1, **parameters, physicsClientId=self.client)
        self.names[body] = name
        self._bodies[name] = body


def _turning_z_to(normal_W: Vec3) -> Quaternion:
    """The shortest turn that takes the z axis to a unit vector."""
    nx, ny, nz = normal_W
    if nz <= -1.0 + 1e-12:
        return (1.0, 0.0, 0.0, 0.0)
    half = sqrt(2.0 * (1.0 + nz))
    return (-ny / half, nx / half, 0.0, half / 2.0)


def lies_square(pose: Pose, ups_W: Iterable[Vec3] = (UP,)) -> bool:
    """Whether an axis of a brick is vertical, or square to a slope: it may touch others with its faces, not lean."""
    axes_W = body_axes(pose.orientation)
    return any(abs(dot(axis_W, up_W)) > SQUARE for axis_W in axes_W for up_W in ups_W)
