"""A SAPIEN world; every brick moves by itself."""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Self, TypeAlias

import numpy as np

from stability.contact_law import Friction, GivenFriction, Surface, as_friction
from stability.dynamics.rigid_body import pushed
from stability.engines.bodies import EngineWorld, OwnBodies
from stability.engines.pressing import shortest_turn
from stability.engines.protocol import NOTHING_PRESCRIBED, Guided, PrescribedMotion, StepClock
from stability.geometry.bounding_boxes import BoundingBoxes
from stability.geometry.box import MIDDLE, box_of
from stability.geometry.convex_solid import half_lengths
from stability.geometry.vectors import add_scaled, body_axes, dot, scale
from stability.model import (
    AT_REST,
    BodyId,
    BodyState,
    Brick,
    ContactPoint,
    ConvexShape,
    Plane,
    Pose,
    Quaternion,
    Vec3,
)
from stackdsl_sapien import SapienSettings
from stackdsl_sapien.binding import sapien

# Friction that differs between pairs of bodies, in an engine that takes the mean of two coefficients.
#
# A body has one shape for each surface that it may touch. Two such shapes touch only each other, and both have the
# coefficient of the pair. Collision groups define which shapes touch: one bit for each pair of surfaces.


Groups: TypeAlias = list[int]  # own groups of a shape, and the groups that it touches
Shapes: TypeAlias = list[tuple[float, Groups]]  # of one body, each with its coefficient

BITS = 32


@dataclass
class PairShapes:
    """Shapes of bodies that give each pair its friction."""

    law: Friction
    _planes: dict[BodyId, Plane] = field(default_factory=dict, init=False)
    _known: dict[Surface, BodyId] = field(default_factory=dict, init=False)  # by surface, one brick with it
    _bits: dict[frozenset[Surface | BodyId], int] = field(default_factory=dict, init=False)

    def of_plane(self, plane: Plane) -> Shapes:
        """Return the shapes of a new plane; later bricks with new surfaces add others."""
        self._planes[plane.id] = plane
        return [(self.law.on(brick, plane), self._meets(plane.id, surface)) for surface, brick in self._known.items()]

    def of_brick(self, brick: BodyId) -> Shapes:
        """Return the shapes of a new brick."""
        own = self.law.surface_of(brick)
        self._known.setdefault(own, brick)
        on_bricks = [(self.law.of(brick, other), self._meets(own, each)) for each, other in self._known.items()]
        return on_bricks + [(self.law.on(brick, p), self._meets(own, p.id)) for p in self._planes.values()]

    def is_known(self, brick: BodyId) -> bool:
        """Return whether a body with the surface of this brick has been present."""
        return self.law.surface_of(brick) in self._known

    def for_new(self, brick: BodyId, others: Iterator[BodyId]) -> Iterator[tuple[BodyId, float, Groups]]:
        """Yield the shapes that present bodies need in addition for a brick with a new surface."""
        own = self.law.surface_of(brick)
        yield from ((p.id, self.law.on(brick, p), self._meets(own, p.id)) for p in self._planes.values())
        for other in others:
            yield other, self.law.of(brick, other), self._meets(own, self.law.surface_of(other))

    def _meets(self, one: Surface | BodyId, other: Surface | BodyId) -> Groups:
        number = self._bits.setdefault(frozenset((one, other)), len(self._bits))
        if number >= BITS:
            raise ValueError(f"SAPIEN supports at most {BITS} different pairs of surfaces, and this scene has more")
        return [1 << number, 1 << number, 0, 0]


# The bodies of a SAPIEN scene by name. PhysX computes in single precision.
#
# Friction of a pair is the mean of both coefficients, and SAPIEN offers no other rule. To have its own friction on
# bricks and none of its own on planes, a brick has two shapes: one touches only bricks, the other, without friction,
# only planes, which have twice their friction. For more complex laws `PairShapes` provides the shapes.
#
# SAPIEN reports the normal forces of contacts, but not those of friction.


Rigid: TypeAlias = sapien.physx.PhysxRigidBaseComponent
ACROSS = (1.0, 0.0, 0.0)  # the normal of PhysX's planes, in their own axes
# Collision groups: the own groups of a shape, and the groups that it touches.
WITH_BRICKS, WITH_PLANES, PLANES = [1, 1, 0, 0], [2, 0, 0, 0], [0, 2, 0, 0]
TOP_SPEED = 1e4  # [m/s] and [rad/s]; by default PhysX clamps the angular speed at 100


@dataclass
class SceneBodies:
    """Bricks and planes in a scene of their own."""

    settings: SapienSettings
    friction: GivenFriction  # between bricks
    system: Any
    scene: Any
    _bodies: dict[BodyId, Any] = field(default_factory=dict, init=False)
    _names: dict[Any, BodyId] = field(default_factory=dict, init=False)  # by entity
    _guided: dict[BodyId, Guided] = field(default_factory=dict, init=False)
    _pairs: PairShapes = field(init=False)
    _shapes: dict[BodyId, ConvexShape] = field(default_factory=dict, init=False)  # of bricks

    def __post_init__(self) -> None:
        self._pairs = PairShapes(as_friction(self.friction))

    @classmethod
    def opened(cls, settings: SapienSettings, gravity: float, friction: GivenFriction) -> Self:
        """Return the bodies of a new, empty scene with gravity [m/s2] along -z."""
        # The configuration belongs to the process, and later systems use it.
        sapien.physx.set_scene_config(
            gravity=np.array((0.0, 0.0, -gravity)),
            bounce_threshold=2.0,
            enable_pcm=True,
            enable_tgs=True,
            enable_ccd=False,
            enable_enhanced_determinism=True,
            enable_friction_every_iteration=True,
        )
        system = sapien.physx.PhysxCpuSystem()
        system.timestep = settings.time_step
        return cls(settings, friction, system, sapien.Scene([system]))

    def close(self) -> None:
        """Remove all bodies."""
        for body in self._bodies.values():
            self.scene.remove_entity(body.entity)
        self._bodies.clear()
        self._names.clear()

    def step(self, parts: int, prescribed: PrescribedMotion) -> None:
        """Advance by one time step of the settings, in `parts` engine steps."""
        self.system.timestep = self.settings.time_step / parts
        self._guide(prescribed.guided)
        for _ in range(parts):
            self._pull(prescribed.acceleration_W)
            for brick, each in self._guided.items():
                self._lead(brick, each)
            self.system.step()

    def _guide(self, guided: Mapping[BodyId, Guided]) -> None:
        """Set the guided bricks; all others are released."""
        before, self._guided = self._guided, dict(guided)
        for brick, was in before.items():
            if brick not in guided and was.carried:
                self.wake(brick)
                self._bodies[brick].linear_velocity = np.array(was.velocity_W)
        for brick, each in guided.items():
            self._bodies[brick].kinematic = each.carried

    def _lead(self, brick: BodyId, each: Guided) -> None:
        """Set the motion of a guided brick in the next engine step."""
        state, body = self.state(brick), self._bodies[brick]
        velocity_W, angular_velocity_W = each.motion(state)
        if each.carried:
            there_W = add_scaled(state.pose.position_W, self.system.timestep, velocity_W)
            body.set_kinematic_target(_to_sapien(replace(state.pose, position_W=there_W)))
        else:
            body.linear_velocity, body.angular_velocity = np.array(velocity_W), np.array(angular_velocity_W)

    def _pull(self, acceleration_W: Vec3) -> None:
        """Apply the acceleration of the planes to the bricks.

        Gravity belongs to the whole process, so a force on each brick does it; forces last for one step.
        """
        if acceleration_W == AT_REST:
            return
        for body in self._bodies.values():
            if isinstance(body, sapien.physx.PhysxRigidDynamicComponent) and not body.kinematic:
                body.add_force_torque(np.array(scale(-body.mass, acceleration_W)), np.zeros(3))

    def add_plane(self, plane: Plane) -> None:
        """Add a plane."""
        body = sapien.physx.PhysxRigidStaticComponent()
        usual = [(2.0 * plane.friction, PLANES)]
        for friction, meets in self._pairs.of_plane(plane) if self._pairs.law.differs else usual:
            self._attach(body, sapien.physx.PhysxCollisionShapePlane(_material(friction)), meets)
        self._enter(plane.id, body, Pose(plane.point_W, shortest_turn(ACROSS, plane.normal_W)))

    def add_brick(self, brick: Brick, pose: Pose, velocity_W: Vec3) -> None:
        """Add a brick."""
        body = self._brick_body(brick)
        self._enter(brick.id, body, pose)
        body.linear_velocity = np.array(velocity_W)

    def _brick_body(self, brick: Brick) -> Rigid:
        body = sapien.physx.PhysxRigidDynamicComponent()
        for friction, meets in self._shapes_of(brick):
            self._attach(body, _collision_shape(brick.shape, _material(friction)), meets)
        body.mass = brick.mass
        body.inertia = np.array(brick.shape.moments(brick.mass))
        body.cmass_local_pose = _to_sapien(Pose(AT_REST, brick.shape.principal_axes))
        body.linear_damping = body.angular_damping = 0.0
        body.max_linear_velocity = body.max_angular_velocity = TOP_SPEED
        body.solver_position_iterations = self.settings.iterations
        body.solver_velocity_iterations = self.settings.velocity_iterations
        body.sleep_threshold = 0.0
        return body

    def _shapes_of(self, brick: Brick) -> Sequence[tuple[float, list[int]]]:
        """Return the friction and the collision groups of each shape of a new brick."""
        if not self._pairs.law.differs:
            return ((self._pairs.law.usual, WITH_BRICKS), (0.0, WITH_PLANES))
        if not self._pairs.is_known(brick.id):
            for other, friction, meets in self._pairs.for_new(brick.id, iter(self._shapes)):
                material = _material(friction)
                known = self._shapes.get(other)
                shape = _collision_shape(known, material) if known else sapien.physx.PhysxCollisionShapePlane(material)
                self._attach(self._bodies[other], shape, meets)
        self._shapes[brick.id] = brick.shape
        return self._pairs.of_brick(brick.id)

    def _attach(self, body: Rigid, shape: sapien.physx.PhysxCollisionShape, meets: Sequence[int]) -> None:
        shape.rest_offset = 0.0
        shape.contact_offset = self.settings.contact_offset
        shape.set_collision_groups(list(meets))
        body.attach(shape)

    def _enter(self, name: BodyId, body: Rigid, pose: Pose) -> None:
        entity = sapien.Entity()
        entity.add_component(body)
        entity.pose = _to_sapien(pose)
        self.scene.add_entity(entity)
        self._bodies[name] = body
        self._names[entity] = name

    def remove(self, brick: BodyId) -> None:
        """Remove a brick."""
        self._guided.pop(brick, None)
        self._shapes.pop(brick, None)
        entity = self._bodies.pop(brick).entity
        del self._names[entity]
        self.scene.remove_entity(entity)

    def set_state(self, brick: BodyId, state: BodyState) -> None:
        """Set pose and motion of a brick that is not frozen."""
        body = self._bodies[brick]
        if self._guided.pop(brick, None) is not None:
            body.kinematic = False  # a guided brick becomes dynamic immediately, not only at the next step
        body.entity_pose = _to_sapien(state.pose)
        body.linear_velocity = np.array(state.velocity_W)
        body.angular_velocity = np.array(state.angular_velocity_W)

    def state(self, name: BodyId) -> BodyState:
        """Return pose and motion of a brick."""
        body = self._bodies[name]
        pose = _from_sapien(body.entity_pose)
        return BodyState(pose, _vector(body.linear_velocity), _vector(body.angular_velocity))

    def contacts(self, brick: BodyId) -> list[ContactPoint]:
        """Return the contact points of a brick after the last step."""
        return [point for pair in self.system.get_contacts() for point in self._points(pair, brick)]

    def _points(self, pair: sapien.physx.PhysxContact, brick: BodyId) -> Iterator[ContactPoint]:
        a, b = (self._names.get(body.entity, "") for body in pair.bodies)
        if brick not in (a, b) or not (a and b):
            return
        for point in pair.points:
            normal = _vector(point.normal)  # from the second body towards the first
            force = dot(_vector(point.impulse), normal) / self.system.timestep
            yield ContactPoint(a, b, _vector(point.position), normal, float(point.separation), force)

    def boxes(self, bricks: Collection[Brick]) -> BoundingBoxes:
        """Return the current bounding boxes of bricks."""
        poses = [self.state(brick.id).pose for brick in bricks]
        return BoundingBoxes.around(
            [brick.id for brick in bricks],
            np.array([pose.position_W for pose in poses]),
            np.array([body_axes(pose.orientation) for pose in poses]).transpose(0, 2, 1),
            np.array([half_lengths(brick.shape) for brick in bricks]),
        )

    def freeze(self, brick: BodyId) -> None:
        """Freeze a brick at its pose."""
        self._guided.pop(brick, None)
        body = self._bodies[brick]
        body.linear_velocity = body.angular_velocity = np.zeros(3)
        body.kinematic = True

    def holds(self, brick: BodyId) -> bool:
        """Return whether a brick is frozen."""
        return bool(self._bodies[brick].kinematic) and brick not in self._guided

    def wake(self, brick: BodyId) -> None:
        """Wake a frozen brick, at rest."""
        body = self._bodies[brick]
        body.kinematic = False
        body.linear_velocity = body.angular_velocity = np.zeros(3)

    def put_at(self, brick: BodyId, pose: Pose) -> None:
        """Move a brick to another pose."""
        self._bodies[brick].entity_pose = _to_sapien(pose)


def _collision_shape(shape: ConvexShape, material: sapien.physx.PhysxMaterial) -> sapien.physx.PhysxCollisionShape:
    """Return a box as a box shape, and any other solid as a hull."""
    boxed = box_of(shape)
    if boxed is None:
        vertices = np.array(shape.corners, dtype=np.float32)
        return sapien.physx.PhysxCollisionShapeConvexMesh(vertices, np.ones(3, dtype=np.float32), material)
    box, middle = boxed
    made = sapien.physx.PhysxCollisionShapeBox(np.array(scale(0.5, box.size)), material)
    if middle is not MIDDLE:
        made.local_pose = sapien.Pose(np.array(middle))
    return made


def _material(friction: float) -> sapien.physx.PhysxMaterial:
    return sapien.physx.PhysxMaterial(friction, friction, 0.0)


def _to_sapien(pose: Pose) -> sapien.Pose:
    x, y, z, w = pose.orientation
    return sapien.Pose(np.array(pose.position_W), np.array((w, x, y, z)))


def _from_sapien(pose: sapien.Pose) -> Pose:
    w, x, y, z = (float(part) for part in pose.q)
    orientation: Quaternion = (x, y, z, w)
    return Pose(_vector(pose.p), orientation)


def _vector(parts: Iterable[float]) -> Vec3:
    x, y, z = (float(part) for part in parts)
    return (x, y, z)


# A SAPIEN world; every brick moves by itself.


@dataclass
class SapienWorld(EngineWorld):
    """World with its own bricks and planes; `opened` creates it."""

    settings: SapienSettings
    own: OwnBodies
    bodies: SceneBodies
    clock: StepClock

    @classmethod
    def opened(
        cls, settings: SapienSettings, gravity: float, friction: GivenFriction, heaviest: float | None = None
    ) -> Self:
        """Return a new, empty world with gravity [m/s2] along -z; masses are in kilograms regardless of their size."""
        return cls(settings, OwnBodies(), SceneBodies.opened(settings, gravity, friction), StepClock(settings))

    def close(self) -> None:
        self.bodies.close()

    def step(self, prescribed: PrescribedMotion = NOTHING_PRESCRIBED) -> None:
        self.bodies.step(self.clock.pass_step(), prescribed)

    def states(self, bodies: Collection[BodyId]) -> dict[BodyId, BodyState]:
        planes = self.own.planes
        return {b: BodyState(Pose(planes[b].point_W)) if b in planes else self.bodies.state(b) for b in bodies}

    def contacts(self, brick: BodyId) -> Sequence[ContactPoint]:
        return self.bodies.contacts(brick)

    def neighbours(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        return self.own.neighbours(brick, self.bodies.boxes(self.own.bricks.values()), within)

    def add_plane(self, plane: Plane) -> None:
        self.own.add_plane(plane)
        self.bodies.add_plane(plane)

    def add_brick(self, brick: Brick, pose: Pose, velocity_W: Vec3 = AT_REST) -> None:
        self.own.add_brick(brick)
        self.bodies.add_brick(brick, pose, velocity_W)

    def remove_brick(self, brick: BodyId) -> None:
        self.own.remove_brick(brick)
        self.bodies.remove(brick)

    def push(self, brick: BodyId, impulse_W: Vec3, at_W: Vec3) -> None:
        self.set_state(brick, pushed(self.bodies.state(brick), self.own.bricks[brick], impulse_W, at_W))

    def set_state(self, brick: BodyId, state: BodyState) -> None:
        self.bodies.set_state(brick, state)

    def freeze(self, brick: BodyId) -> None:
        self.bodies.freeze(brick)

    def holds(self, brick: BodyId) -> bool:
        return self.bodies.holds(brick)

    def wake(self, brick: BodyId) -> None:
        self.bodies.wake(brick)

    def put_at(self, brick: BodyId, pose: Pose) -> None:
        self.bodies.put_at(brick, pose)
