"""Makes the bodies that stand for planes, bricks and groups, and tells the engine all that matters of them."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from math import sqrt

from stability.engines.pybullet.client_bodies import ClientBodies
from stability.engines.pybullet.parameters import body_parameters
from stability.engines.pybullet.pybullet_binding import pybullet
from stability.engines.pybullet.pybullet_settings import PyBulletSettings
from stability.engines.pybullet.shapes import PART_MARGIN, Solids
from stability.friction_law import Friction, GivenFriction, law_of
from stability.geometry.vectors import scale
from stability.mechanics.rigid_group import RigidGroup
from stability.model import IDENTITY, BodyId, Brick, ConvexShape, Quaternion, Vec3
from stability.shapes.box import Box

# Combined friction is the product of two bodies' own; this stands for "none" where a partner must still reach its own.
FRICTIONLESS = 1e-6
# Collision groups, and the mask of what meets all: PyBullet's own of what is made with mass, and two more.
SHARP, ROUNDED, HALF_SPACES, ALL = 1, 64, 128, -1
# Of soft contacts, of the root of stiffness times mass: 2 damps one alone critically. With 4 a V lands from 10 cm and
# stays; with 2 it slips with 5 % more friction than it needs.
DAMPING = 4.0
# Share of the least thickness by which the edges of a hull are rounded where no rounding is set: PyBullet keeps a
# collision margin around hulls, and takes a thousandth of a unit for it, which would lift what is small off its place.
HULL_ROUNDING = 0.02


@dataclass
class BodyMaker:
    """Makes bodies in a client. Places are in engine metres, masses and moments of inertia in units of the scene."""

    bodies: ClientBodies
    settings: PyBulletSettings
    gravity: float  # [m/s2]
    friction: GivenFriction  # of brick on brick
    law: Friction = field(init=False)
    solids: Solids = field(init=False)

    def __post_init__(self) -> None:
        self.law = law_of(self.friction)
        self.solids = Solids(self.bodies.client)

    def plane(self, name: BodyId, shape: int, friction: float, position: Vec3, orientation: Quaternion) -> int:
        """The number of a new body that never moves, with a Coulomb coefficient for all bricks."""
        body = self._body(0.0, shape, position, orientation)
        self._enter(body, name, friction / self.own_friction())
        return body

    def brick(self, brick: Brick, position: Vec3, orientation: Quaternion, rounded: bool) -> None:
        """A new body of a brick, with sharp or rounded edges."""
        radius = self.bodies.scale * self.edge_radius(brick)
        body = self._body(brick.mass, self._shape(brick.shape, radius, rounded), position, orientation)
        self._enter(body, brick.id, self.own_friction())
        if brick.shape.principal_axes != IDENTITY:
            self.bodies.inertia_turns[brick.id] = brick.shape.principal_axes
        if radius:
            pybullet.changeDynamics(body, -1, collisionMargin=radius, physicsClientId=self.bodies.client)
            self.bodies.margins[brick.id] = radius
            if isinstance(brick.shape, Box) and not rounded:
                self.bodies.sharp.add(brick.id)
            if rounded:
                self._round(body, brick.mass, brick.shape.least_thickness)
            self.weigh_brick(brick)

    def _shape(self, shape: ConvexShape, radius: float, rounded: bool) -> int:
        """The number of the collision shape of a brick; only a box may have sharp edges."""
        if not isinstance(shape, Box):
            return self.solids.rounded_hull(shape, radius, self.bodies.scale)
        half = scale(0.5 * self.bodies.scale, shape.size)
        return self.solids.rounded_box(half, radius) if radius and rounded else self.solids.box(half)

    def group(self, name: BodyId, group: RigidGroup) -> None:
        """A new body with the shapes of several bricks."""
        times = self.bodies.scale
        # PyBullet counts a shape as used for ever, so it goes only with the world.
        solids = ((group.bricks[brick].shape, place) for brick, place in group.places_G.items())
        shape = self.solids.rounded_solids(solids, times)
        body = self._body(group.mass, shape, scale(times, group.pose.position_W), group.pose.orientation)
        self._enter(body, name, self.own_friction())
        self.bodies.margins[name] = PART_MARGIN
        self._weigh(body, group.mass, group.moments)

    def edge_radius(self, brick: Brick) -> float:
        """How much the edges of a brick are rounded [m]: as much as is set, and those of a hull in any case."""
        rounding = self.settings.edge_rounding or (0.0 if isinstance(brick.shape, Box) else HULL_ROUNDING)
        return rounding * brick.shape.least_thickness

    def weigh_brick(self, brick: Brick, times: float = 1.0) -> None:
        """Give the body of a brick its mass and its moments of inertia, or so many times these."""
        mass = times * brick.mass
        self._weigh(self.bodies.numbers[brick.id], mass, brick.shape.moments(mass))

    def meet(self, bodies: Iterable[int], group: int, mask: int) -> None:
        """Put bodies into a collision group, and say which groups they meet."""
        for body in bodies:
            pybullet.setCollisionFilterGroupMask(body, -1, group, mask, self.bodies.client)

    def _body(self, mass: float, shape: int, position: Vec3, orientation: Quaternion) -> int:
        return int(
            pybullet.createMultiBody(
                baseMass=mass * self.bodies.mass_unit,
                baseCollisionShapeIndex=shape,
                basePosition=position,
                baseOrientation=orientation,
                useMaximalCoordinates=int(self.settings.maximal_coordinates),
                physicsClientId=self.bodies.client,
            )
        )

    def own_friction(self) -> float:
        """The factor of a brick as it is made: two of them give the usual coefficient."""
        return max(sqrt(self.law.usual), FRICTIONLESS)

    def _enter(self, body: int, name: BodyId, own_friction: float) -> None:
        parameters = body_parameters(self.settings, own_friction)
        pybullet.changeDynamics(body, -1, **parameters, physicsClientId=self.bodies.client)
        self.bodies.enter(name, body)

    def _round(self, body: int, mass: float, thickness: float) -> None:
        """Tell a body with rounded edges, of a mass [kg] and a smallest side [m], what it meets, and how softly."""
        if self.settings.half_spaces:
            self.meet([body], ROUNDED, ALL)
        if self.settings.sinking and self.gravity:
            weight = mass * self.bodies.mass_unit * self.gravity
            stiffness = weight / (self.settings.sinking * thickness * self.bodies.scale)
            pybullet.changeDynamics(
                body,
                -1,
                contactStiffness=stiffness,
                contactDamping=DAMPING * sqrt(stiffness * mass * self.bodies.mass_unit),
                physicsClientId=self.bodies.client,
            )

    def _weigh(self, body: int, mass: float, inertia: Vec3) -> None:
        """Give a body its moments of inertia [kg m2]: PyBullet takes those of a bounding box with margins.

        The mass must be said again, or a body in maximal coordinates loses it.
        """
        pybullet.changeDynamics(
            body,
            -1,
            mass=mass * self.bodies.mass_unit,
            localInertiaDiagonal=scale(self.bodies.mass_unit * self.bodies.scale**2, inertia),
            physicsClientId=self.bodies.client,
        )
