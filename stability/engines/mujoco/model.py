"""Builds MuJoCo models from bodies and planes: shapes, masses, friction by pair."""

from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from stability.contact_law import GivenFriction, as_friction
from stability.dynamics.rigid_group import grouped
from stability.engines.mujoco.binding import mujoco
from stability.engines.mujoco.pair_frictions import Rubbing, pair_frictions
from stability.engines.mujoco.settings import MuJoCoSettings
from stability.engines.pressing import Presses, shortest_turn
from stability.engines.protocol import FIRM, Guided
from stability.geometry.bounding_boxes import BoundingBoxes
from stability.geometry.box import Box, box_of
from stability.geometry.placed_shape import middle_pose
from stability.geometry.vectors import add, add_scaled, inverse, rotate, scale, subtract
from stability.model import BodyId, BodyState, Brick, ContactPoint, ConvexShape, Plane, Pose, Quaternion, Vec3

# The shapes of bricks in a model of MuJoCo: boxes, and hulls of whatever else is convex.


def add_hulls(spec: mujoco.MjSpec, shapes: Iterable[ConvexShape]) -> dict[ConvexShape, str]:
    """The names of the meshes of all that are no boxes, which are added once each."""
    found: dict[ConvexShape, str] = {}
    for shape in shapes:
        if shape not in found and box_of(shape) is None:
            found[shape] = f"hull {len(found) + 1}"
            spec.add_mesh(name=found[shape], uservert=[part for corner in shape.corners for part in corner])
    return found


def geometry(shape: ConvexShape, place: Pose, hulls: Mapping[ConvexShape, str]) -> Mapping[str, object]:
    """What a shape is in its place in a body."""
    boxed = box_of(shape)
    if boxed is None:
        kind, named = mujoco.mjtGeom.mjGEOM_MESH, {"meshname": hulls[shape]}
        return {"type": kind, **named, "pos": place.position_W, "quat": as_wxyz(place.orientation)}
    box, middle = boxed
    at = middle_pose(middle, place) if any(middle) else place
    return {
        "type": mujoco.mjtGeom.mjGEOM_BOX,
        "size": scale(0.5, box.size),
        "pos": at.position_W,
        "quat": as_wxyz(place.orientation),
    }


def weigh(body: mujoco.MjsBody, bricks: Sequence[tuple[Brick, Pose]], times: float) -> None:
    """Say where the mass of a body is and how it is spread; from shapes, MuJoCo would take it to be filled evenly.

    With so many times the mass of its bricks.
    """
    group = grouped(bricks)
    body.explicitinertial = True
    body.mass = times * group.mass
    body.ipos, body.iquat = group.pose.position_W, as_wxyz(group.pose.orientation)
    body.inertia = scale(times, group.moments)


def as_wxyz(orientation: Quaternion) -> Quaternion:
    """A quaternion in MuJoCo's order."""
    x, y, z, w = orientation
    return (w, x, y, z)


# Bodies and planes as a model of MuJoCo, and what a model that is stepped tells.
#
# A brick that is held is part of the ground as far as MuJoCo knows: it has no joint, so nothing moves it. A model
# cannot be changed, so one is made whenever a body comes, goes, is held or let go.


UP = (0.0, 0.0, 1.0)
SLIDING = 3  # dimensions of a contact force: normal and friction, no resistance to spin or rolling
MIDPOINT, POWER = 0.5, 2.0  # of the curve between the impedances, as MuJoCo has them
ROOM = 2**20  # [bytes] for the contacts of a brick, and for the least world; what is not used is never touched
LEAST_ROOM = 16


@dataclass(frozen=True, slots=True)
class MjBody:
    """One brick, or several that move as one."""

    bricks: tuple[tuple[Brick, Pose], ...]  # each with its place in the body
    state: BodyState
    held: bool = False
    carried: bool = False  # moves as somebody outside says, whatever it meets


@dataclass(frozen=True, slots=True)
class MjScene:
    """All that a model is made of."""

    settings: MuJoCoSettings
    gravity: float  # [m/s2], along -z
    friction: GivenFriction  # of brick on brick
    planes: Collection[Plane]
    bodies: Mapping[BodyId, MjBody]


@dataclass(eq=False)
class Model:
    """A model with its state, ready to be stepped."""

    model: mujoco.MjModel
    data: mujoco.MjData
    free: Mapping[BodyId, int]  # the bodies that move, by their turn in the state
    owners: tuple[BodyId, ...]  # whose shape each is
    _touching: dict[BodyId, list[int]] | None = field(default=None, init=False)
    _bounds: BoundingBoxes | None = field(default=None, init=False)

    def pull(self, gravity: float, acceleration_W: Vec3) -> None:
        """Let bodies feel gravity along -z, and that all without a joint accelerates [m/s2]."""
        self.model.opt.gravity[:] = subtract((0.0, 0.0, -gravity), acceleration_W)

    def step(self, duration: float, parts: int, presses: Presses, guided: Mapping[BodyId, Guided]) -> None:
        """Let time pass [s], in so many steps, with these bodies guided."""
        self.model.opt.timestep = duration / parts
        for _ in range(parts):
            self.data.xfrc_applied[:] = 0.0
            for acting in presses.acting(self, duration / parts):
                body = self.model.jnt_bodyid[self.free[acting.brick.id]]
                self.data.xfrc_applied[body] = np.concatenate(acting.wrench(duration / parts))
            self._make_firm(guided)
            for name, each in guided.items():
                state = self.state(name)
                _set_state(self.data, self.free[name], BodyState(state.pose, *each.motion(state)))
            mujoco.mj_step(self.model, self.data)
        self._touching = self._bounds = None
        if self.data.warning.number.any():
            raise RuntimeError(f"MuJoCo failed: {_warnings(self.data)}")

    def _make_firm(self, guided: Mapping[BodyId, Guided]) -> None:
        """Let what is slid along the ground resist all that meets it, but upwards, by inertia without weight."""
        for name, turn in self.free.items():
            mass = float(self.model.body_mass[self.model.jnt_bodyid[turn]])
            slid = name in guided and guided[name].free_W == UP
            self.model.dof_M0[6 * turn : 6 * turn + 2] = FIRM * mass if slid else mass

    def state(self, name: BodyId) -> BodyState:
        """Pose and motion of a body that moves."""
        turn = self.free[name]
        x, y, z, qw, qx, qy, qz = self.data.qpos[7 * turn : 7 * turn + 7].tolist()
        vx, vy, vz, a, b, c = self.data.qvel[6 * turn : 6 * turn + 6].tolist()
        orientation = (qx, qy, qz, qw)
        # MuJoCo has the velocity of a free body in W, and its turning in body axes.
        return BodyState(Pose((x, y, z), orientation), (vx, vy, vz), rotate(orientation, (a, b, c)))

    def states(self, names: Collection[BodyId]) -> dict[BodyId, BodyState]:
        """Poses and motions of bodies that move."""
        return {name: self.state(name) for name in names}

    def contacts(self, brick: BodyId) -> list[ContactPoint]:
        """The contact points of a brick in the last step."""
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
        # The normal goes from the first to the second, and the force is the one on the second.
        normal, way, other_way = _vector(frame[:3]), _vector(frame[3:6]), _vector(frame[6:])
        friction_W = add(scale(along, way), scale(across, other_way))
        on_first = add_scaled(_vector(contact.pos.tolist()), -0.5 * contact.dist, normal)  # `pos` is half-way between
        return ContactPoint(second, first, on_first, normal, float(contact.dist), pressing, friction_W)

    def bounds(self, planes: int) -> BoundingBoxes:
        """The boxes around all bricks as they are now; the shapes of planes come first."""
        if self._bounds is None:
            mujoco.mj_kinematics(self.model, self.data)  # a step leaves shapes where they were before it
            count = self.model.ngeom - planes
            axes_W = self.data.geom_xmat[planes:].reshape(count, 3, 3)
            around = self.model.geom_aabb[planes:]  # its middle and half its sides, in axes of the shape
            middles_W = self.data.geom_xpos[planes:] + np.einsum("nij,nj->ni", axes_W, around[:, :3])
            self._bounds = BoundingBoxes.around(self.owners[planes:], middles_W, axes_W, around[:, 3:])
        return self._bounds


def made(scene: MjScene) -> Model:
    """The model of a scene, with every body where it is, and as fast as it is."""
    spec = mujoco.MjSpec()
    _set_options(spec, scene)
    held = {brick.id: body.held for body in scene.bodies.values() for brick, _ in body.bricks}
    frictions = pair_frictions(as_friction(scene.friction), scene.planes, list(held))
    for plane in scene.planes:
        _add_plane(spec.worldbody, plane, scene.settings, frictions.shapes[plane.id])
    hulls = add_hulls(spec, (brick.shape for body in scene.bodies.values() for brick, _ in body.bricks))
    for body in scene.bodies.values():
        _add_body(spec.worldbody, body, scene, hulls, frictions.shapes)
    for one, other, friction in frictions.pairs:
        if not (held.get(one, True) and held.get(other, True)):  # what neither can move never meets
            _add_pair(spec, one, other, scene.settings, friction)
    model = spec.compile()
    data = mujoco.MjData(model)
    free = {name: turn for turn, name in enumerate(n for n, body in scene.bodies.items() if not body.held)}
    for name, turn in free.items():
        _set_state(data, turn, scene.bodies[name].state)
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
    option.disableflags = int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)  # what diverges is to be told, not begun anew
    option.enableflags = 0  # no sleep
    spec.memory = ROOM * (LEAST_ROOM + sum(len(body.bricks) for body in scene.bodies.values()))


def _add_plane(world: mujoco.MjsBody, plane: Plane, settings: MuJoCoSettings, rubbing: Rubbing) -> None:
    world.add_geom(
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=(0.0, 0.0, 1.0),  # without end
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
    rubbing: Mapping[BodyId, Rubbing],
) -> None:
    added = world.add_body(pos=body.state.pose.position_W, quat=as_wxyz(body.state.pose.orientation))
    if not body.held:
        added.add_freejoint()
    firm = 1.0
    if body.carried:
        firm, added.gravcomp = FIRM, 1.0  # the share of gravity that it does not feel
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


def _add_pair(spec: mujoco.MjSpec, one: BodyId, other: BodyId, settings: MuJoCoSettings, friction: float) -> None:
    """Say what friction two shapes have on each other, whatever each has by itself."""
    alike = {**_contact(settings, friction), "friction": (friction, friction, 0.0, 0.0, 0.0)}
    spec.add_pair(geomname1=one, geomname2=other, **alike)


def _contact(settings: MuJoCoSettings, friction: float) -> Mapping[str, object]:
    """How a shape meets others."""
    return {
        "condim": SLIDING,
        "friction": (friction, 0.0, 0.0),
        "solref": (settings.contact_time, 1.0),
        "solimp": (*settings.impedance_range, MIDPOINT, POWER),
    }


def _set_state(data: mujoco.MjData, turn: int, state: BodyState) -> None:
    x, y, z, w = state.pose.orientation
    data.qpos[7 * turn : 7 * turn + 7] = (*state.pose.position_W, w, x, y, z)
    spin = rotate(inverse(state.pose.orientation), state.angular_velocity_W)
    data.qvel[6 * turn : 6 * turn + 6] = (*state.velocity_W, *spin)


def _owners(scene: MjScene) -> Iterator[BodyId]:
    yield from (plane.id for plane in scene.planes)
    yield from (brick.id for body in scene.bodies.values() for brick, _ in body.bricks)


def _vector(parts: Iterable[float]) -> Vec3:
    x, y, z = parts
    return (x, y, z)


def _warnings(data: mujoco.MjData) -> str:
    kinds = mujoco.mjtWarning.__members__.items()
    return ", ".join(name for name, kind in kinds if name != "mjNWARNING" and data.warning[int(kind)].number)
