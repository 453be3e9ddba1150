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
from stability.geometry.round_solid import RoundSolid, is_straight
from stability.geometry.solid_making import inset_corners
from stability.geometry.vectors import add, add_scaled, body_axes, dot, inverse, rotate, scale, subtract
from stability.model import AT_REST, IDENTITY, BodyId, BodyState, Brick, ConvexShape, Plane, Pose, Quaternion, Vec3

# Collision shapes: boxes, boxes with rounded edges, and rounded hulls. Lengths are in engine metres.
#
# PyBullet gives two boxes that touch along an edge the normal of a face, so that leaning planks need twice the true
# friction. The convex hull of eight corners avoids this: the corners lie a small radius inside the box, and a collision
# margin of that radius restores the outer size (docs/design/engines.md).


# [engine m] PyBullet's collision margin of shapes from a file. It must not change: PyBullet builds the tree of bounding
# boxes with it, and detects contacts of parts with a larger margin only after they have sunk in.
PART_MARGIN = 1e-3
CORNERS_OF_A_FACE = 4


@dataclass
class Solids:
    """Cache of the collision shapes that bodies of one client share."""

    client: int
    _half_space: int | None = field(default=None, init=False)
    _boxes: dict[Vec3, int] = field(default_factory=dict, init=False)
    _hulls: dict[tuple[Vec3, float], int] = field(default_factory=dict, init=False)
    _rounded_hulls: dict[tuple[ConvexShape, float], int] = field(default_factory=dict, init=False)
    _round: dict[RoundSolid, int] = field(default_factory=dict, init=False)

    def box(self, half_extents: Vec3) -> int:
        """Return the number of a box."""
        if half_extents not in self._boxes:
            self._boxes[half_extents] = pybullet.createCollisionShape(
                pybullet.GEOM_BOX, halfExtents=half_extents, physicsClientId=self.client
            )
        return self._boxes[half_extents]

    def half_space(self) -> int:
        """Return the number of the half-space below the origin."""
        if self._half_space is None:
            self._half_space = int(
                pybullet.createCollisionShape(
                    pybullet.GEOM_PLANE, planeNormal=(0.0, 0.0, 1.0), physicsClientId=self.client
                )
            )
        return self._half_space

    def rounded_box(self, half_extents: Vec3, radius: float) -> int:
        """Return the number of a box with rounded edges; its body needs the radius as collision margin."""
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
        """Return the number of a solid with rounded edges, scaled by `times`, in its principal axes.

        Its body needs the radius as collision margin.
        """
        if (shape, radius) not in self._rounded_hulls:
            turn = inverse(shape.principal_axes)
            corners = [scale(times, rotate(turn, corner)) for corner in inset_corners(shape, radius / times)]
            self._rounded_hulls[shape, radius] = pybullet.createCollisionShape(
                pybullet.GEOM_MESH, vertices=corners, physicsClientId=self.client
            )
        return self._rounded_hulls[shape, radius]

    def round_solid(self, solid: RoundSolid, times: float) -> int:
        """Return the number of a cylinder, sphere or capsule, scaled by `times`; a bore has no effect on contacts."""
        if solid not in self._round:
            kind = pybullet.GEOM_CAPSULE if solid.rounding else pybullet.GEOM_CYLINDER
            self._round[solid] = pybullet.createCollisionShape(
                kind if solid.height else pybullet.GEOM_SPHERE,
                radius=times * solid.widest,
                height=times * solid.height,
                collisionFramePosition=scale(-times, solid.centre_of_mass),
                physicsClientId=self.client,
            )
        return self._round[solid]

    def rounded_solids(self, solids: Iterable[tuple[ConvexShape, Pose]], times: float) -> int:
        """Return the number of a compound of rounded solids with poses, scaled by `times`.

        PyBullet accepts 16 parts per call and silently drops the others; from a file it accepts any number of convex
        parts.
        """
        with NamedTemporaryFile("w", suffix=".obj", encoding="ascii", delete=False) as file:
            file.writelines(_obj(solids, times))
        try:
            return int(
                pybullet.createCollisionShape(pybullet.GEOM_MESH, fileName=file.name, physicsClientId=self.client)
            )
        finally:
            os.unlink(file.name)


# Corner numbers of a box. PyBullet ignores corners that no face refers to, so these faces refer to all.
FACES = ((1, 2, 4, 3), (5, 6, 8, 7))


def _obj(solids: Iterable[tuple[ConvexShape, Pose]], times: float) -> Iterable[str]:
    """Yield the lines of a Wavefront file with the inset hulls of solids."""
    before = 0
    for part, (shape, pose) in enumerate(solids):
        corners = _inner_corners(shape, pose, times)
        faces = FACES if isinstance(shape, Box) else _covering_faces(len(corners))
        yield f"o {part}\n"
        yield from (f"v {x!r} {y!r} {z!r}\n" for x, y, z in corners)
        yield from (f"f {' '.join(str(before + corner) for corner in face)}\n" for face in faces)
        before += len(corners)


def _inner_corners(shape: ConvexShape, pose: Pose, times: float) -> Sequence[Vec3]:
    """Return the corners of a part without its margin, in engine metres."""
    if isinstance(shape, Box):
        a, b, c = scale(times, shape.size)
        inner = (a - 2.0 * PART_MARGIN, b - 2.0 * PART_MARGIN, c - 2.0 * PART_MARGIN)
        return corners_W(Box(inner), Pose(scale(times, pose.position_W), pose.orientation))
    corners = inset_corners(shape, PART_MARGIN / times)
    return [scale(times, add(pose.position_W, rotate(pose.orientation, corner))) for corner in corners]


def _covering_faces(count: int) -> Iterator[Sequence[int]]:
    """Yield faces of four corner numbers, from 1, that cover all corners; the last may overlap the one before."""
    for start in range(0, count, CORNERS_OF_A_FACE):
        begin = 1 + min(start, max(count - CORNERS_OF_A_FACE, 0))
        yield range(begin, min(begin + CORNERS_OF_A_FACE, count + 1))


# Engine bodies of planes, bricks and groups.


# Stands for no friction. PyBullet multiplies the factors of two bodies, so a factor must not be 0 if another
# coefficient depends on it.
FRICTIONLESS = 1e-6
# Collision groups (PyBullet's own for bodies with mass, and two more), and the mask that collides with all.
SHARP, ROUNDED, HALF_SPACES, ALL = 1, 64, 128, -1
# Damping of soft contacts in units of sqrt(stiffness * mass); 2 damps a single contact critically. With 4 a V that
# falls 10 cm stays upright; with 2 it slips at a friction 5 % above the limit.
DAMPING = 4.0
# Edge radius of hulls if the settings have none, as a share of the least thickness. PyBullet's default margin of hulls,
# 0.001 units, would lift small bricks.
HULL_ROUNDING = 0.02


@dataclass
class BodyMaker:
    """Creates bodies in a client. Positions are in engine metres, masses and moments of inertia in scene units."""

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
        """Create a fixed body with a Coulomb coefficient for all bricks, and return its number."""
        body = self._body(0.0, shape, position, orientation)
        self._enter(body, name, friction / self.own_friction())
        return body

    def brick(self, brick: Brick, position: Vec3, orientation: Quaternion, rounded: bool) -> None:
        """Create the body of a brick, with sharp or rounded edges."""
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
            self.set_brick_mass(brick)

    def _shape(self, shape: ConvexShape, radius: float, rounded: bool) -> int:
        """Return the number of a brick's collision shape; only boxes can have sharp edges."""
        if is_straight(shape):
            return self.solids.round_solid(shape, self.bodies.scale)
        if not isinstance(shape, Box):
            return self.solids.rounded_hull(shape, radius, self.bodies.scale)
        half = scale(0.5 * self.bodies.scale, shape.size)
        return self.solids.rounded_box(half, radius) if radius and rounded else self.solids.box(half)

    def group(self, name: BodyId, group: RigidGroup) -> None:
        """Create a body with the shapes of several bricks."""
        times = self.bodies.scale
        # PyBullet cannot remove a shape once it was used, so it stays until the world closes.
        solids = ((group.bricks[brick].shape, place) for brick, place in group.places_G.items())
        shape = self.solids.rounded_solids(solids, times)
        body = self._body(group.mass, shape, scale(times, group.pose.position_W), group.pose.orientation)
        self._enter(body, name, self.own_friction())
        self.bodies.margins[name] = PART_MARGIN
        self._set_inertia(body, group.mass, group.moments)

    def edge_radius(self, brick: Brick) -> float:
        """Return the edge radius of a brick [m]: that of the settings, but hulls always have one."""
        rounding = self.settings.edge_rounding or (0.0 if isinstance(brick.shape, Box) else HULL_ROUNDING)
        return rounding * brick.shape.least_thickness

    def set_brick_mass(self, brick: Brick, times: float = 1.0) -> None:
        """Set mass and moments of inertia of a brick's body, multiplied by a factor."""
        mass = times * brick.mass
        self._set_inertia(self.bodies.numbers[brick.id], mass, brick.shape.moments(mass))

    def set_collision_group(self, bodies: Iterable[int], group: int, mask: int) -> None:
        """Set the collision group of bodies and the mask of the groups that they collide with."""
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
        """Return the default friction factor of a brick: the product of two is the usual coefficient."""
        return max(sqrt(self.law.usual), FRICTIONLESS)

    def _enter(self, body: int, name: BodyId, own_friction: float) -> None:
        parameters = body_parameters(self.settings, own_friction)
        pybullet.changeDynamics(body, -1, **parameters, physicsClientId=self.bodies.client)
        self.bodies.enter(name, body)

    def _round(self, body: int, mass: float, thickness: float) -> None:
        """Set collision group and contact stiffness of a rounded body with a mass [kg] and a smallest side [m]."""
        if self.settings.half_spaces:
            self.set_collision_group([body], ROUNDED, ALL)
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

    def _set_inertia(self, body: int, mass: float, inertia: Vec3) -> None:
        """Set the moments of inertia of a body [kg m2]: PyBullet uses those of a bounding box with margins.

        The call repeats the mass, as a body in maximal coordinates loses it otherwise.
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
# PyBullet gives a box on a half-space one contact point a step, and a box on a large box all four at once, but contacts
# of hulls with a large box are inaccurate. So a plane may be two bodies in different collision groups.


# [m] Half the side of the box that represents a half-space.
HALF_SPACE = 1e5
# [engine m] The same in a world of rounded bricks, centred on the first: contacts with a larger box are inaccurate.
# With a box twenty times as large a V stands with 10 % too little friction.
LEAST_REACH = 500.0
# Least reach of the boxes, as a multiple of the distance of the farthest brick; a new box reaches twice as far.
ROOM = 2.0
# Least cosine between an axis of a brick that lies square and the vertical or the normal of a slope (0.1 deg).
SQUARE = 1.0 - 1.5e-6
UP: Vec3 = (0.0, 0.0, 1.0)


@dataclass
class Planes:
    """Ground and walls as finite bodies, which are replaced by larger ones when bricks approach their ends."""

    maker: BodyMaker
    planes: dict[BodyId, Plane]  # of the world, by name
    _half_spaces: list[int] = field(default_factory=list, init=False)  # bodies that represent planes for hulls
    _reach: float = field(default=HALF_SPACE, init=False)  # half the side of the boxes that represent planes [m]
    _middle_W: Vec3 = field(default=(0.0, 0.0, 0.0), init=False)  # the boxes are centred below or beside it [m]
    _lively: bool = field(default=False, init=False)  # whether a body is fast

    def __post_init__(self) -> None:
        if self.maker.settings.edge_rounding:
            self._reach = LEAST_REACH / self.maker.settings.scale

    def add(self, plane: Plane) -> None:
        """Create the bodies of a plane."""
        if self.maker.settings.half_spaces:
            self._put_up_half_space(plane)
        self._put_up(plane)
        self.choose(self._lively)

    def shape(self) -> Box:
        """Return the shape of the box of each plane."""
        side = 2.0 * self._reach
        return Box((side, side, side))

    def centre_on(self, brick: Brick, position_W: Vec3) -> None:
        """Centre the boxes on the first brick of the world if it is far from their centres."""
        if self._needed(brick, position_W) > self._reach:
            self._middle_W = position_W
            self._renew_boxes()

    def extend_to(self, brick: Brick, position_W: Vec3) -> None:
        """Enlarge the boxes if a brick comes near their ends."""
        needed = self._needed(brick, position_W)
        if needed > self._reach:
            self._reach = 2.0 * needed
            self._renew_boxes()

    def choose(self, lively: bool) -> None:
        """Let rounded bricks collide with half-spaces while all bodies are slow, and with boxes while one is fast.

        A half-space supports a brick that lands on an edge at one end only, and spins it; a box does not.
        """
        self._lively = lively
        if not self._half_spaces:
            return
        boxes = [self.maker.bodies.numbers[plane] for plane in self.planes]
        self.maker.set_collision_group(boxes, SHARP, SHARP | ROUNDED if lively else SHARP)
        self.maker.set_collision_group(self._half_spaces, HALF_SPACES, 0 if lively else ROUNDED)

    def lies_square(self, pose: Pose, shape: ConvexShape) -> bool:
        """Check that a face of a brick is level or parallel to a slope."""
        slopes = (plane.normal_W for plane in self.planes.values() if plane.normal_W[2] > 0.0)
        return lies_square(pose, shape, (UP, *slopes))

    def _needed(self, brick: Brick, position_W: Vec3) -> float:
        """Return the reach of the boxes that a brick needs [m]."""
        return ROOM * (dist(self._middle_W, position_W) + brick.shape.length)

    def _renew_boxes(self) -> None:
        """Replace the boxes: PyBullet cannot resize them."""
        for plane in self.planes.values():
            self.maker.bodies.remove(plane.id)
            self._put_up(plane)
        self.choose(self._lively)

    def _put_up(self, plane: Plane) -> None:
        """Create the box that represents a plane."""
        times = self.maker.bodies.scale
        depth = self._reach * times
        above = dot(subtract(self._middle_W, plane.point_W), plane.normal_W)
        nearest = add_scaled(self._middle_W, -above, plane.normal_W)  # of the plane
        centre = add_scaled(scale(times, nearest), -depth, plane.normal_W)
        box = self.maker.solids.box((depth, depth, depth))
        self.maker.plane(plane.id, box, plane.friction, centre, _turning_z_to(plane.normal_W))

    def _put_up_half_space(self, plane: Plane) -> None:
        """Create the half-space of a plane for bricks with rounded edges; neighbour queries use the box."""
        position, turn = scale(self.maker.bodies.scale, plane.point_W), _turning_z_to(plane.normal_W)
        body = self.maker.plane(plane.id, self.maker.solids.half_space(), plane.friction, position, turn)
        self._half_spaces.append(body)
        self.maker.bodies.unseen.add(body)  # its bounding box overlaps everything


def _turning_z_to(normal_W: Vec3) -> Quaternion:
    """Return the shortest rotation of the z axis to a unit vector."""
    nx, ny, nz = normal_W
    if nz <= -1.0 + 1e-12:
        return (1.0, 0.0, 0.0, 0.0)
    half = sqrt(2.0 * (1.0 + nz))
    return (-ny / half, nx / half, 0.0, half / 2.0)


def lies_square(pose: Pose, shape: ConvexShape, ups_W: Iterable[Vec3] = (UP,)) -> bool:
    """Check that a face of a brick is level or parallel to a slope, so that the brick does not lean."""
    normals_W: Iterable[Vec3] = body_axes(pose.orientation)  # of a box
    if not isinstance(shape, Box):
        faces = shape.flat_faces if isinstance(shape, RoundSolid) else shape.faces
        normals_W = [rotate(pose.orientation, face.normal) for face in faces]
    return any(abs(dot(normal_W, up_W)) > SQUARE for normal_W in normals_W for up_W in ups_W)


@dataclass
class BrickBodies:
    """Bricks with a body each: added, removed, frozen, woken, and given sharp or rounded edges."""

    own: OwnBodies
    bodies: ClientBodies
    maker: BodyMaker
    planes: Planes
    stepper: Stepper
    anchors: Anchors = field(init=False)
    rounded: set[BodyId] = field(default_factory=set, init=False)  # bricks with rounded edges
    displaced: bool = field(default=True, init=False)  # whether a brick was moved since the last check of the edges
    let_go: dict[BodyId, None] = field(default_factory=dict, init=False)  # released since the last check of contacts

    def __post_init__(self) -> None:
        self.anchors = Anchors(self.bodies, self.maker.settings.friction_anchor)

    def add(self, brick: Brick, pose: Pose, velocity_W: Vec3) -> None:
        """Add a brick, at rest or with a velocity of its centre [m/s]."""
        if not self.own.bricks:
            self.planes.centre_on(brick, pose.position_W)
        self.planes.extend_to(brick, pose.position_W)
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
        self.on_woken(brick.id)

    def remove(self, brick: BodyId) -> None:
        """Remove a brick and free its name."""
        self.bodies.remove(brick)
        self.own.remove_brick(brick)
        self.on_stopped(brick)
        self.anchors.remove(brick)
        self.rounded.discard(brick)

    def states(self, names: Iterable[BodyId]) -> dict[BodyId, BodyState]:
        """Return poses and motions by name."""
        return self.stepper.fall.corrected(self.bodies.states(names))

    def freeze(self, brick: BodyId) -> None:
        """Freeze a brick in its pose."""
        self.bodies.hold(brick)
        self.on_stopped(brick)

    def holds(self, brick: BodyId) -> bool:
        """Check that a brick is frozen."""
        return self.bodies.mass(brick) == 0.0

    def wake(self, brick: BodyId) -> None:
        """Wake a frozen brick."""
        self.bodies.let_go(brick, self.own.bricks[brick].mass)
        self.on_woken(brick)
        if self.maker.settings.edge_rounding:
            self.maker.set_brick_mass(self.own.bricks[brick])

    def scale_mass(self, brick: BodyId, times: float) -> None:
        """Multiply the mass of a brick that is not frozen by a factor."""
        self.maker.set_brick_mass(self.own.bricks[brick], times)

    def apply_forces(self, brick: BodyId, forces: Sequence[AppliedForce]) -> None:
        """Replace the applied forces on a brick that is not frozen."""
        self.stepper.presses.apply_forces(self.own.bricks[brick], self.states([brick])[brick], forces)

    def put_at(self, brick: BodyId, pose: Pose) -> None:
        """Move a brick to a pose."""
        self.bodies.put(brick, pose)
        self.displaced = True

    def set_state(self, brick: BodyId, state: BodyState) -> None:
        """Set the pose and the velocities of a brick that is not frozen."""
        self.put_at(brick, state.pose)
        self.on_stopped(brick)  # no free-fall correction: the velocity is that of this moment
        self.bodies.set_motion(brick, state.velocity_W, state.angular_velocity_W)

    def collide_alone(self, brick: BodyId, body: int) -> None:
        """Restore the collisions of a brick's own body, which had none in a group."""
        round_group = self.maker.settings.half_spaces and brick in self.rounded
        self.bodies.numbers[brick] = body
        self.maker.set_collision_group([body], ROUNDED if round_group else SHARP, ALL)

    def swap(self, brick: BodyId) -> None:
        """Exchange sharp and rounded edges of a brick: its new body has the same pose, motion, mass and name."""
        self.rounded ^= {brick}
        self.renew(brick)

    def renew(self, brick: BodyId) -> None:
        """Give a brick a new body, without contacts, of the same pose, motion, mass and name."""
        number, client = self.bodies.numbers[brick], self.bodies.client
        position, orientation = pybullet.getBasePositionAndOrientation(number, client)
        velocity, angular_velocity = self.bodies.raw_motion(brick)
        self.bodies.remove(brick)
        self.maker.brick(self.own.bricks[brick], position, orientation, rounded=brick in self.rounded)
        self.bodies.set_raw_motion(brick, velocity, angular_velocity)
        self.anchors.renew(brick)

    def on_woken(self, body: BodyId) -> None:
        """Record that a body is awake."""
        self.stepper.on_awake_changed()
        self.stepper.fall.begin(body)
        self.let_go[body] = None

    def on_stopped(self, body: BodyId) -> None:
        """Record that a body is no longer awake."""
        self.stepper.on_awake_changed()
        self.stepper.fall.end(body)
        self.stepper.presses.leave(body)
