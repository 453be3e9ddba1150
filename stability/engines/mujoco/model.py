"""MuJoCo models of bodies and planes: shapes, masses, friction by pair."""

from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from stability.contact_law import GivenFriction, as_friction
from stability.dynamics.rigid_group import grouped
from stability.engines.mujoco.binding import mujoco
from stability.engines.mujoco.pair_frictions import GeomFriction, pair_frictions
from stability.engines.mujoco.settings import MuJoCoSettings
from stability.engines.pressing import AppliedLoads, shortest_turn
from stability.engines.protocol import FIRM, Guided
from stability.geometry.bounding_boxes import BoundingBoxes
from stability.geometry.box import Box, box_of
from stability.geometry.placed_shape import middle_pose
from stability.geometry.round_solid import RoundSolid, is_straight
from stability.geometry.vectors import add, add_scaled, inverse, rotate, scale, subtract
from stability.model import BodyId, BodyState, Brick, ContactPoint, ConvexShape, Plane, Pose, Quaternion, Vec3

# The shapes of bricks in a model: boxes, and meshes of other convex shapes.


def add_hulls(spec: mujoco.MjSpec, shapes: Iterable[ConvexShape]) -> dict[ConvexShape, str]:
    """Add a mesh for each distinct shape that is no primitive of MuJoCo, and return the names of the meshes."""
    meshes: dict[ConvexShape, str] = {}
    for shape in shapes:
        if shape not in meshes and not is_straight(shape) and box_of(shape) is None:
            meshes[shape] = f"hull {len(meshes) + 1}"
            spec.add_mesh(name=meshes[shape], uservert=[part for corner in shape.corners for part in corner])
    return meshes


def geometry(shape: ConvexShape, place: Pose, hulls: Mapping[ConvexShape, str]) -> Mapping[str, object]:
    """Return the geom attributes of a shape with a pose in a body."""
    if is_straight(shape):
        return _round_geometry(shape, place)
    boxed = box_of(shape)
    if boxed is None:
        kind, mesh = mujoco.mjtGeom.mjGEOM_MESH, {"meshname": hulls[shape]}
        return {"type": kind, **mesh, "pos": place.position_W, "quat": as_wxyz(place.orientation)}
    box, middle = boxed
    pose = middle_pose(middle, place) if any(middle) else place
    return {
        "type": mujoco.mjtGeom.mjGEOM_BOX,
        "size": scale(0.5, box.size),
        "pos": pose.position_W,
        "quat": as_wxyz(place.orientation),
    }


def _round_geometry(shape: RoundSolid, place: Pose) -> Mapping[str, object]:
    """Return the geom attributes of a cylinder, sphere or capsule; a bore has no effect on contacts."""
    kind = mujoco.mjtGeom.mjGEOM_CAPSULE if shape.rounding else mujoco.mjtGeom.mjGEOM_CYLINDER
    return {
        "type": kind if shape.height else mujoco.mjtGeom.mjGEOM_SPHERE,
        "size": (shape.widest, 0.5 * shape.height, 0.0),
        "pos": middle_pose(scale(-1.0, shape.centre_of_mass), place).position_W,
        "quat": as_wxyz(place.orientation),
    }


def weigh(body: mujoco.MjsBody, bricks: Sequence[tuple[Brick, Pose]], times: float) -> None:
    """Set mass, centre of mass and inertia of a body, with the mass of its bricks multiplied by a factor.

    MuJoCo would derive them from the shapes with uniform density.
    """
    group = grouped(bricks)
    body.explicitinertial = True
    body.mass = times * group.mass
    body.ipos, body.iquat = group.pose.position_W, as_wxyz(group.pose.orientation)
    body.inertia = scale(times, group.moments)


def as_wxyz(orientation: Quaternion) -> Quaternion:
    """Convert a quaternion to MuJoCo's order."""
    x, y, z, w = orientation
    return (w, x, y, z)


# Models of bodies and planes.
#
# A frozen brick has no joint, so that MuJoCo treats it as part of the ground. A model cannot be changed, so adding,
# removing, freezing or waking a body makes a new model.


UP = (0.0, 0.0, 1.0)
SLIDING = 3  # dimensions of a contact force: normal and friction, without spinning or rolling friction
MIDPOINT, POWER = 0.5, 2.0  # of the impedance curve, MuJoCo's defaults
ROOM = 2**20  # [bytes] of memory per brick for its contacts; unused memory is never touched
LEAST_ROOM = 16


@dataclass(frozen=True, slots=True)
class MjBody:
    """Brick or welded group."""

    bricks: tuple[tuple[Brick, Pose], ...]  # with their poses in the body
    state: BodyState
    held: bool = False
    carried: bool = False  # has prescribed motion, independent of its contacts


@dataclass(frozen=True, slots=True)
class MjScene:
    """Input of a model."""

    settings: MuJoCoSettings
    gravity: float  # [m/s2], along -z
    friction: GivenFriction  # of brick on brick
    planes: Collection[Plane]
    bodies: Mapping[BodyId, MjBody]


@dataclass(eq=False)
class Model:
    """Model with its state."""

    model: mujoco.MjModel
    data: mujoco.MjData
    free: Mapping[BodyId, int]  # index of each moving body in the state
    owners: tuple[BodyId, ...]  # plane or brick of each geom
    _touching: dict[BodyId, list[int]] | None = field(default=None, init=False)
    _bounds: BoundingBoxes | None = field(default=None, init=False)

    def pull(self, gravity: float, acceleration_W: Vec3) -> None:
        """Set gravity along -z and the inertial acceleration from the motion of the fixed bodies [m/s2]."""
        self.model.opt.gravity[:] = subtract((0.0, 0.0, -gravity), acceleration_W)

    def step(self, duration: float, parts: int, presses: AppliedLoads, guided: Mapping[BodyId, Guided]) -> None:
        """Advance by a duration [s] in a number of sub-steps, with prescribed motions by body."""
        self.model.opt.timestep = duration / parts
        for _ in range(parts):
            self.data.xfrc_applied[:] = 0.0
            for acting in presses.acting(self, duration / parts):
                body = self.model.jnt_bodyid[self.free[acting.brick.id]]
                self.data.xfrc_applied[body] = np.concatenate(acting.wrench(duration / parts))
            self._make_firm(guided)
            for name, motion in guided.items():
                state = self.state(name)
                _set_state(self.data, self.free[name], BodyState(state.pose, *motion.motion(state)))
            mujoco.mj_step(self.model, self.data)
        self._touching = self._bounds = None
        if self.data.warning.number.any():
            raise RuntimeError(f"MuJoCo failed: {_warnings(self.data)}")

    def _make_firm(self, guided: Mapping[BodyId, Guided]) -> None:
        """Increase the horizontal inertia of slid bodies without their weight, so that contacts do not deflect them."""
        for name, index in self.free.items():
            mass = float(self.model.body_mass[self.model.jnt_bodyid[index]])
            slid = name in guided and guided[name].free_W == UP
            self.model.dof_M0[6 * index : 6 * index + 2] = FIRM * mass if slid else mass

    def state(self, name: BodyId) -> BodyState:
        """Return pose and motion of a moving body."""
        index = self.free[name]
        x, y, z, qw, qx, qy, qz = self.data.qpos[7 * index : 7 * index + 7].tolist()
        vx, vy, vz, a, b, c = self.data.qvel[6 * index : 6 * index + 6].tolist()
        orientation = (qx, qy, qz, qw)
        # MuJoCo stores the velocity of a free body in W, and its angular velocity in body axes.
        return BodyState(Pose((x, y, z), orientation), (vx, vy, vz), rotate(orientation, (a, b, c)))

    def states(self, names: Collection[BodyId]) -> dict[BodyId, BodyState]:
        """Return poses and motions of moving bodies."""
        return {name: self.state(name) for name in names}

    def contacts(self, brick: BodyId) -> list[ContactPoint]:
        """Return the contact points of a brick in the last step."""
        if self._touching is None:
            self._touching = defaultdict(list)
            for index, pair in enumerate(self.data.contact.geom.tolist()):
                for shape in pair:
                    self._touching[self.owners[shape]].append(index)
        return [self._contact_point(index) for index in self._touching.get(brick, ())]

    def _contact_point(self, index: int) -> ContactPoint:
        contact = self.data.contact[index]
        first, second = (self.owners[shape] for shape in contact.geom.tolist())
        force = np.zeros(6)
        mujoco.mj_contactForce(self.model, self.data, index, force)
        pressing, along, across, *_ = force.tolist()
        frame = contact.frame.tolist()
        # The normal points from the first to the second, and the force acts on the second.
        normal, direction, cross_direction = _vector(frame[:3]), _vector(frame[3:6]), _vector(frame[6:])
        friction_W = add(scale(along, direction), scale(across, cross_direction))
        on_first = add_scaled(_vector(contact.pos.tolist()), -0.5 * contact.dist, normal)  # `pos` is the midpoint
        return ContactPoint(second, first, on_first, normal, float(contact.dist), pressing, friction_W)

    def bounds(self, planes: int) -> BoundingBoxes:
        """Return the current bounding boxes of all bricks; `planes` is the number of planes, whose geoms come first."""
        if self._bounds is None:
            mujoco.mj_kinematics(self.model, self.data)  # `mj_step` leaves geoms at their poses before the step
            count = self.model.ngeom - planes
            axes_W = self.data.geom_xmat[planes:].reshape(count, 3, 3)
            around = self.model.geom_aabb[planes:]  # centre and half sizes, in axes of the shape
            middles_W = self.data.geom_xpos[planes:] + np.einsum("nij,nj->ni", axes_W, around[:, :3])
            self._bounds = BoundingBoxes.around(self.owners[planes:], middles_W, axes_W, around[:, 3:])
        return self._bounds


def build_model(scene: MjScene) -> Model:
    """Build the model of a scene, with the poses and velocities of its bodies."""
    spec = mujoco.MjSpec()
    _set_options(spec, scene)
    held = {brick.id: body.held for body in scene.bodies.values() for brick, _ in body.bricks}
    frictions = pair_frictions(as_friction(scene.friction), scene.planes, list(held))
    for plane in scene.planes:
        _add_plane(spec.worldbody, plane, scene.settings, frictions.shapes[plane.id])
    hulls = add_hulls(spec, (brick.shape for body in scene.bodies.values() for brick, _ in body.bricks))
    for body in scene.bodies.values():
        _add_body(spec.worldbody, body, scene, hulls, frictions.shapes)
    for first, second, friction in frictions.pairs:
        if not (held.get(first, True) and held.get(second, True)):  # two immobile bodies never collide
            _add_pair(spec, first, second, scene.settings, friction)
    model = spec.compile()
    data = mujoco.MjData(model)
    free = {name: index for index, name in enumerate(n for n, body in scene.bodies.items() if not body.held)}
    for name, index in free.items():
        _set_state(data, index, scene.bodies[name].state)
    return Model(model, data, free, tuple(_owners(scene)))


def _set_options(spec: mujoco.MjSpec, scene: MjScene) -> None:
    option, settings = spec.option, scene.settings
    option.timestep = settings.time_step
    option.gravity = (0.0, 0.0, -scene.gravity)
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    option.impratio = settings.friction_impedance
    option.iterations = settings.iterations
    option.tolerance = settings.tolerance
    option.disableflags = int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)  # report divergence instead of restarting
    option.enableflags = 0  # no sleep
    spec.memory = ROOM * (LEAST_ROOM + sum(len(body.bricks) for body in scene.bodies.values()))


def _add_plane(world: mujoco.MjsBody, plane: Plane, settings: MuJoCoSettings, rubbing: GeomFriction) -> None:
    world.add_geom(
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=(0.0, 0.0, 1.0),  # infinite
        pos=plane.point_W,
        quat=as_wxyz(shortest_turn(UP, plane.normal_W)),
        name=plane.id,
        priority=rubbing.priority,
        **_contact(settings, rubbing.friction),
    )


def _add_body(
    world: mujoco.MjsBody,
    body: MjBody,
    scene: MjScene,
    hulls: Mapping[ConvexShape, str],
    rubbing: Mapping[BodyId, GeomFriction],
) -> None:
    added = world.add_body(pos=body.state.pose.position_W, quat=as_wxyz(body.state.pose.orientation))
    if not body.held:
        added.add_freejoint()
    firm = 1.0
    if body.carried:
        firm, added.gravcomp = FIRM, 1.0  # compensates gravity
    if not all(isinstance(brick.shape, Box) for brick, _ in body.bricks):
        weigh(added, body.bricks, firm)
    for brick, place in body.bricks:
        added.add_geom(
            **geometry(brick.shape, place, hulls),
            mass=firm * brick.mass,
            name=brick.id,
            priority=rubbing[brick.id].priority,
            **_contact(scene.settings, rubbing[brick.id].friction),
        )


def _add_pair(spec: mujoco.MjSpec, first: BodyId, second: BodyId, settings: MuJoCoSettings, friction: float) -> None:
    """Set the friction of two geoms on each other, in place of their own."""
    attributes = {**_contact(settings, friction), "friction": (friction, friction, 0.0, 0.0, 0.0)}
    spec.add_pair(geomname1=first, geomname2=second, **attributes)


def _contact(settings: MuJoCoSettings, friction: float) -> Mapping[str, object]:
    """Return the contact attributes of a geom."""
    return {
        "condim": SLIDING,
        "friction": (friction, 0.0, 0.0),
        "solref": (settings.contact_time, 1.0),
        "solimp": (*settings.impedance_range, MIDPOINT, POWER),
    }


def _set_state(data: mujoco.MjData, index: int, state: BodyState) -> None:
    x, y, z, w = state.pose.orientation
    data.qpos[7 * index : 7 * index + 7] = (*state.pose.position_W, w, x, y, z)
    spin = rotate(inverse(state.pose.orientation), state.angular_velocity_W)
    data.qvel[6 * index : 6 * index + 6] = (*state.velocity_W, *spin)


def _owners(scene: MjScene) -> Iterator[BodyId]:
    yield from (plane.id for plane in scene.planes)
    yield from (brick.id for body in scene.bodies.values() for brick, _ in body.bricks)


def _vector(parts: Iterable[float]) -> Vec3:
    x, y, z = parts
    return (x, y, z)


def _warnings(data: mujoco.MjData) -> str:
    kinds = mujoco.mjtWarning.__members__.items()
    return ", ".join(name for name, kind in kinds if name != "mjNWARNING" and data.warning[int(kind)].number)
