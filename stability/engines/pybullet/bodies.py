"""Creates the bodies and collision shapes of a PyBullet world: planes, bricks, rounded edges."""

import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import product
from math import dist, sqrt
from tempfile import NamedTemporaryFile

from stability.contact_law import Friction, GivenFriction, as_friction
from stability.dynamics.rigid_body import AppliedForce
from stability.dynamics.rigid_group import RigidGroup
from stability.engines.bodies import OwnBodies
from stability.engines.pybullet.binding import pybullet
from stability.engines.pybullet.client import ClientBodies
from stability.engines.pybullet.settings import PyBulletSettings
from stability.engines.pybullet.stepping import Anchors, Stepper, body_parameters
from stability.geometry.box import Box
from stability.geometry.placed_shape import corners_W, principal_turn
from stability.geometry.solid_making import inset_corners
from stability.geometry.vectors import add, add_scaled, body_axes, dot, inverse, rotate, scale, subtract
from stability.model import AT_REST, IDENTITY, BodyId, BodyState, Brick, ConvexShape, Plane, Pose, Quaternion, Vec3

# The collision shapes of a world: boxes, boxes with rounded edges, and rounded hulls. Lengths in engine metres.
#
# PyBullet gives two boxes that touch along an edge the normal of a face, and planks that lean on each other then need
# twice the friction that they should. The convex hull of eight corners does not suffer from this: they stand a small
# radius inside the box, and the collision margin of that radius makes the outer size exact (docs/design/engines.md).


# [engine m] What PyBullet gives the parts of a file as collision margin. It must stay: the tree of the parts' bounds is
# made with it, and parts whose margin grows later are not noticed before they have sunk into what they touch.
PART_MARGIN = 1e-3
CORNERS_OF_A_FACE = 4


@dataclass
class Solids:
    """The shapes that bodies of one client have in common."""

    client: int
    _half_space: int | None = field(default=None, init=False)
    _boxes: dict[Vec3, int] = field(default_factory=dict, init=False)
    _hulls: dict[tuple[Vec3, float], int] = field(default_factory=dict, init=False)
    _of_shapes: dict[tuple[ConvexShape, float], int] = field(default_factory=dict, init=False)

    def box(self, half_extents: Vec3) -> int:
        """The number of a box."""
        if half_extents not in self._boxes:
            self._boxes[half_extents] = pybullet.createCollisionShape(
                pybullet.GEOM_BOX, halfExtents=half_extents, physicsClientId=self.client
            )
        return self._boxes[half_extents]

    def half_space(self) -> int:
        """The number of the half-space below the origin."""
        if self._half_space is None:
            self._half_space = int(
                pybullet.createCollisionShape(
                    pybullet.GEOM_PLANE, planeNormal=(0.0, 0.0, 1.0), physicsClientId=self.client
                )
            )
        return self._half_space

    def rounded_box(self, half_extents: Vec3, radius: float) -> int:
        """The number of a box with rounded edges; its body must be given the radius as collision margin."""
        if (half_extents, radius) not in self._hulls:
            corners = [
                [side * (half - radius) for side, half in zip(sides, half_extents, strict=True)]
                for sides in product((-1.0, 1.0), repeat=3)
            ]
            self._hulls[half_extents, radius] = pybullet.createCollisionShape(
                pybullet.GEOM_MESH, vertices=corners, physicsClientId=self.client
            )
        return self._hulls[half_extents, radius]

    def rounded_hull(self, shape: ConvexShape, radius: float, times: float) -> int:
        """The number of a solid with rounded edges, so many times as large, in the axes of its inertia.

        Its body must be given the radius as collision margin.
        """
        if (shape, radius) not in self._of_shapes:
            turn = inverse(shape.principal_axes)
            corners = [scale(times, rotate(turn, corner)) for corner in inset_corners(shape, radius / times)]
            self._of_shapes[shape, radius] = pybullet.createCollisionShape(
                pybullet.GEOM_MESH, vertices=corners, physicsClientId=self.client
            )
        return self._of_shapes[shape, radius]

    def rounded_solids(self, solids: Iterable[tuple[ConvexShape, Pose]], times: float) -> int:
        """The number of several rounded solids in one shape, so many times as large, by their poses in it.

        PyBullet takes no more than 16 parts in a call, and drops the others without a word; from a file it takes any
        number of convex parts.
        """
        with NamedTemporaryFile("w", suffix=".obj", encoding="ascii", delete=False) as file:
            file.writelines(_obj(solids, times))
        try:
            return int(
                pybullet.createCollisionShape(pybullet.GEOM_MESH, fileName=file.name, physicsClientId=self.client)
            )
        finally:
            os.unlink(file.name)


# Corners of a box, in the order of the shape; PyBullet needs only that some face names each of them.
FACES = ((1, 2, 4, 3), (5, 6, 8, 7))


def _obj(solids: Iterable[tuple[ConvexShape, Pose]], times: float) -> Iterable[str]:
    """The lines of a Wavefront file with the hulls of solids with rounded edges."""
    before = 0
    for part, (shape, pose) in enumerate(solids):
        corners = _inner_corners(shape, pose, times)
        faces = FACES if isinstance(shape, Box) else _naming_all(len(corners))
        yield f"o {part}\n"
        yield from (f"v {x!r} {y!r} {z!r}\n" for x, y, z in corners)
        yield from (f"f {' '.join(str(before + corner) for corner in face)}\n" for face in faces)
        before += len(corners)


def _inner_corners(shape: ConvexShape, pose: Pose, times: float) -> Sequence[Vec3]:
    """The corners of a part without its margin, in engine metres."""
    if isinstance(shape, Box):
        a, b, c = scale(times, shape.size)
        inner = (a - 2.0 * PART_MARGIN, b - 2.0 * PART_MARGIN, c - 2.0 * PART_MARGIN)
        return corners_W(Box(inner), Pose(scale(times, pose.position_W), pose.orientation))
    corners = inset_corners(shape, PART_MARGIN / times)
    return [scale(times, add(pose.position_W, rotate(pose.orientation, corner))) for corner in corners]


def _naming_all(count: int) -> Iterator[Sequence[int]]:
    """Four corners at a time, by number from 1; the last four share some with those before."""
    for start in range(0, count, CORNERS_OF_A_FACE):
        begin = 1 + min(start, max(count - CORNERS_OF_A_FACE, 0))
        yield range(begin, min(begin + CORNERS_OF_A_FACE, count + 1))


# Makes the bodies that stand for planes, bricks and groups, and tells the engine all that matters of them.


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
        self.law = as_friction(self.friction)
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


# The planes of a PyBullet world.
#
# PyBullet's own half-spaces give a box one contact point a step, and a large box gives it all four at once, but
# contacts of hulls with it lose their precision. So a plane may be two bodies, told apart by collision groups.


# Half the side of the box that stands for a half-space [m]. A box, because PyBullet gives a box on a plane one contact
# point a step, and a box on a box all four at once.
HALF_SPACE = 1e5
# [engine m] The same beside bricks with rounded edges, about the place of the first: contacts with a larger box lose
# their precision. At twenty times as much a V stands with 10 % too little friction.
LEAST_REACH = 500.0
# How many times further than any brick is such a box must reach, or it is made anew, twice as large as that.
ROOM = 2.0
# A brick lies square if the cosine of an axis of it to the vertical, or to the normal of a slope, is more than this: by
# 0.1 deg.
SQUARE = 1.0 - 1.5e-6
UP: Vec3 = (0.0, 0.0, 1.0)


@dataclass
class Planes:
    """Ground and walls. They are made as bodies, and made anew where bricks come near their ends."""

    maker: BodyMaker
    planes: dict[BodyId, Plane]  # by name, as the world has them
    _half_spaces: list[int] = field(default_factory=list, init=False)  # the bodies that stand for planes beside hulls
    _reach: float = field(default=HALF_SPACE, init=False)  # half the side of the boxes that stand for planes [m]
    _middle_W: Vec3 = field(default=(0.0, 0.0, 0.0), init=False)  # their middles are right below it, or beside it [m]
    _lively: bool = field(default=False, init=False)  # whether something is fast

    def __post_init__(self) -> None:
        if self.maker.settings.edge_rounding:
            self._reach = LEAST_REACH / self.maker.settings.scale

    def add(self, plane: Plane) -> None:
        """Put up a plane that the world has taken in."""
        if self.maker.settings.half_spaces:
            self._put_up_half_space(plane)
        self._put_up(plane)
        self.choose(self._lively)

    def shape(self) -> Box:
        """The shape of each."""
        side = 2.0 * self._reach
        return Box((side, side, side))

    def begin_about(self, brick: Brick, position_W: Vec3) -> None:
        """Let the boxes that stand for planes lie about the first brick of all, if that is far from their middles."""
        if self._needed(brick, position_W) > self._reach:
            self._middle_W = position_W
            self._renew_boxes()

    def reach_beyond(self, brick: Brick, position_W: Vec3) -> None:
        """Let the boxes that stand for planes reach farther if a brick comes near their ends."""
        needed = self._needed(brick, position_W)
        if needed > self._reach:
            self._reach = 2.0 * needed
            self._renew_boxes()

    def choose(self, lively: bool) -> None:
        """Let rounded bricks meet half-spaces while all is slow, and boxes while something is fast.

        A half-space takes a brick that lands on an edge at one end of it, and throws it round; a box does not.
        """
        self._lively = lively
        if not self._half_spaces:
            return
        boxes = [self.maker.bodies.numbers[plane] for plane in self.planes]
        self.maker.meet(boxes, SHARP, SHARP | ROUNDED if lively else SHARP)
        self.maker.meet(self._half_spaces, HALF_SPACES, 0 if lively else ROUNDED)

    def lies_square(self, pose: Pose, shape: ConvexShape) -> bool:
        """Whether a brick lies square to the vertical or to a slope."""
        slopes = (plane.normal_W for plane in self.planes.values() if plane.normal_W[2] > 0.0)
        return lies_square(pose, shape, (UP, *slopes))

    def _needed(self, brick: Brick, position_W: Vec3) -> float:
        """How far the boxes that stand for planes must reach for a brick to be well within [m]."""
        return ROOM * (dist(self._middle_W, position_W) + brick.shape.length)

    def _renew_boxes(self) -> None:
        """PyBullet cannot change the size of a box: put up others."""
        for plane in self.planes.values():
            self.maker.bodies.remove(plane.id)
            self._put_up(plane)
        self.choose(self._lively)

    def _put_up(self, plane: Plane) -> None:
        """Put up the box that stands for a plane."""
        times = self.maker.bodies.scale
        depth = self._reach * times
        above = dot(subtract(self._middle_W, plane.point_W), plane.normal_W)
        nearest = add_scaled(self._middle_W, -above, plane.normal_W)  # of the plane
        centre = add_scaled(scale(times, nearest), -depth, plane.normal_W)
        box = self.maker.solids.box((depth, depth, depth))
        self.maker.plane(plane.id, box, plane.friction, centre, _turning_z_to(plane.normal_W))

    def _put_up_half_space(self, plane: Plane) -> None:
        """Put up what stands for a plane beside bricks with rounded edges; the box tells whether it is near."""
        position, turn = scale(self.maker.bodies.scale, plane.point_W), _turning_z_to(plane.normal_W)
        body = self.maker.plane(plane.id, self.maker.solids.half_space(), plane.friction, position, turn)
        self._half_spaces.append(body)
        self.maker.bodies.unseen.add(body)  # its bounds meet everything


def _turning_z_to(normal_W: Vec3) -> Quaternion:
    """The shortest turn that takes the z axis to a unit vector."""
    nx, ny, nz = normal_W
    if nz <= -1.0 + 1e-12:
        return (1.0, 0.0, 0.0, 0.0)
    half = sqrt(2.0 * (1.0 + nz))
    return (-ny / half, nx / half, 0.0, half / 2.0)


def lies_square(pose: Pose, shape: ConvexShape, ups_W: Iterable[Vec3] = (UP,)) -> bool:
    """Whether a face of a brick is level, or along a slope: it may touch others with its faces, not lean."""
    normals_W: Iterable[Vec3] = body_axes(pose.orientation)  # of a box
    if not isinstance(shape, Box):
        normals_W = [rotate(pose.orientation, face.normal) for face in shape.faces]
    return any(abs(dot(normal_W, up_W)) > SQUARE for normal_W in normals_W for up_W in ups_W)


# The bricks of a PyBullet world, each with a body of its own, with sharp or rounded edges.


@dataclass
class BrickBodies:
    """Bricks that come and go, are held and let go, and change their edges; none is joined to another here."""

    own: OwnBodies
    bodies: ClientBodies
    maker: BodyMaker
    planes: Planes
    stepper: Stepper
    anchors: Anchors = field(init=False)
    rounded: set[BodyId] = field(default_factory=set, init=False)  # those whose edges are rounded
    displaced: bool = field(
        default=True, init=False
    )  # whether one was put elsewhere since somebody looked how they lie
    let_go: dict[BodyId, None] = field(default_factory=dict, init=False)  # since somebody looked what touches them

    def __post_init__(self) -> None:
        self.anchors = Anchors(self.bodies, self.maker.settings.friction_anchor)

    def add(self, brick: Brick, pose: Pose, velocity_W: Vec3) -> None:
        """Set a brick down at rest, or let it go with a velocity of its centre [m/s]."""
        if not self.own.bricks:
            self.planes.begin_about(brick, pose.position_W)
        self.planes.reach_beyond(brick, pose.position_W)
        square = self.planes.lies_square(pose, brick.shape)
        position, turn = scale(self.bodies.scale, pose.position_W), principal_turn(brick.shape, pose.orientation)
        self.maker.brick(brick, position, turn, rounded=not square)
        self.own.add_brick(brick)
        if velocity_W != AT_REST:
            self.bodies.set_motion(brick.id, velocity_W, AT_REST)
        if square:
            self.anchors.add(brick.id)
        else:
            self.rounded.add(brick.id)
        self.comes_free(brick.id)

    def remove(self, brick: BodyId) -> None:
        """Take a brick out; its name is free again."""
        self.bodies.remove(brick)
        self.own.remove_brick(brick)
        self.stays(brick)
        self.anchors.remove(brick)
        self.rounded.discard(brick)

    def states(self, names: Iterable[BodyId]) -> dict[BodyId, BodyState]:
        """Pose and motion of bodies."""
        return self.stepper.fall.corrected(self.bodies.states(names))

    def freeze(self, brick: BodyId) -> None:
        """Hold a brick where it is."""
        self.bodies.hold(brick)
        self.stays(brick)

    def holds(self, brick: BodyId) -> bool:
        """Whether a brick is held."""
        return self.bodies.mass(brick) == 0.0

    def wake(self, brick: BodyId) -> None:
        """Let a brick go that was held."""
        self.bodies.let_go(brick, self.own.bricks[brick].mass)
        self.comes_free(brick)
        if self.maker.settings.edge_rounding:
            self.maker.weigh_brick(self.own.bricks[brick])

    def weigh(self, brick: BodyId, times: float) -> None:
        """Give a brick that is not held so many times its mass."""
        self.maker.weigh_brick(self.own.bricks[brick], times)

    def apply_forces(self, brick: BodyId, pressed: Sequence[AppliedForce]) -> None:
        """Let forces act on a brick that is not held."""
        self.stepper.presses.apply_forces(self.own.bricks[brick], self.states([brick])[brick], pressed)

    def put_at(self, brick: BodyId, pose: Pose) -> None:
        """Put a brick somewhere else."""
        self.bodies.put(brick, pose)
        self.displaced = True

    def set_state(self, brick: BodyId, state: BodyState) -> None:
        """Put a brick that is not held somewhere else, in motion."""
        self.put_at(brick, state.pose)
        self.stays(brick)  # as for falling: its speed is of this moment, whatever it touches
        self.bodies.set_motion(brick, state.velocity_W, state.angular_velocity_W)

    def collide_alone(self, brick: BodyId, body: int) -> None:
        """Let the body of a brick, which met nothing, meet all that it does by itself."""
        round_group = self.maker.settings.half_spaces and brick in self.rounded
        self.bodies.numbers[brick] = body
        self.maker.meet([body], ROUNDED if round_group else SHARP, ALL)

    def swap(self, brick: BodyId) -> None:
        """Give a brick a body with the other kind of edges: same place, motion, mass and name."""
        self.rounded ^= {brick}
        self.renew(brick)

    def renew(self, brick: BodyId) -> None:
        """Give a brick another body, to which nothing is known to touch: same place, motion, mass and name."""
        number, client = self.bodies.numbers[brick], self.bodies.client
        position, orientation = pybullet.getBasePositionAndOrientation(number, client)
        velocity, angular_velocity = self.bodies.raw_motion(brick)
        self.bodies.remove(brick)
        self.maker.brick(self.own.bricks[brick], position, orientation, rounded=brick in self.rounded)
        self.bodies.set_raw_motion(brick, velocity, angular_velocity)
        self.anchors.renew(brick)

    def comes_free(self, body: BodyId) -> None:
        """Note that a body is awake from now on."""
        self.stepper.look_again()
        self.stepper.fall.begin(body)
        self.let_go[body] = None

    def stays(self, body: BodyId) -> None:
        """Note that a body is not awake any more."""
        self.stepper.look_again()
        self.stepper.fall.end(body)
        self.stepper.presses.leave(body)
