"""World that scales all lengths by a factor before they reach its engine, at constant shape and density.

Model: lengths and speeds are `factor` times as large in the engine, times are equal. So masses are factor^3, forces and
impulses factor^4 times as large, and the engine's gravity is `factor` times that of the scene.
"""

from collections.abc import Collection, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace

from stability.dynamics.rigid_body import AppliedForce
from stability.engines.protocol import (
    NOTHING_PRESCRIBED,
    EngineSettings,
    PrescribedMotion,
    World,
    WrongFriction,
)
from stability.geometry.placed_shape import scaled
from stability.geometry.vectors import scale
from stability.model import AT_REST, BodyId, BodyState, Brick, ContactPoint, HalfSpace, Plane, Pose, Shape, Vec3


@dataclass
class ResizedWorld(World):
    """Adapter that converts lengths, masses and forces between the caller and an engine's world."""

    engine: World
    factor: float  # engine length per caller length
    _bricks: dict[BodyId, Brick] = field(default_factory=dict, init=False)
    _masses: Mapping[BodyId, float] = field(default_factory=dict, init=False)

    @property
    def settings(self) -> EngineSettings:
        return self.engine.settings

    # --- time ---------------------------------------------------------------------------------------------------------

    def time(self) -> float:
        return self.engine.time()

    def step(self, prescribed: PrescribedMotion = NOTHING_PRESCRIBED) -> None:
        guided = {
            name: replace(motion, velocity_W=scale(self.factor, motion.velocity_W))
            for name, motion in prescribed.guided.items()
        }
        self.engine.step(PrescribedMotion(scale(self.factor, prescribed.acceleration_W), guided))

    def set_max_speed(self, fastest: float) -> None:
        self.engine.set_max_speed(self.factor * fastest)

    def substep_next_contact(self) -> None:
        self.engine.substep_next_contact()

    def skip(self, duration: float) -> None:
        self.engine.skip(duration)

    # --- queries ------------------------------------------------------------------------------------------------------

    def masses(self) -> Mapping[BodyId, float]:
        return self._masses

    def fixed(self) -> Set[BodyId]:
        return self.engine.fixed()

    def shape(self, body: BodyId) -> Shape:
        if body in self._bricks:
            return self._bricks[body].shape
        shape = self.engine.shape(body)
        return shape if shape is None or isinstance(shape, HalfSpace) else scaled(shape, 1.0 / self.factor)

    def neighbours(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        return self.engine.neighbours(brick, self.factor * within)

    def states(self, bodies: Collection[BodyId]) -> Mapping[BodyId, BodyState]:
        return {name: _moved(state, 1.0 / self.factor) for name, state in self.engine.states(bodies).items()}

    def contacts(self, brick: BodyId) -> Sequence[ContactPoint]:
        force_factor = self.factor**-4
        return [
            replace(
                point,
                position_W=scale(1.0 / self.factor, point.position_W),
                gap=1.0 / self.factor * point.gap,
                normal_force=force_factor * point.normal_force,
                friction_W=scale(force_factor, point.friction_W),
                rounded=(point.rounded[0] / self.factor, point.rounded[1] / self.factor),
            )
            for point in self.engine.contacts(brick)
        ]

    # --- changes ------------------------------------------------------------------------------------------------------

    def add_plane(self, plane: Plane) -> None:
        self.engine.add_plane(replace(plane, point_W=scale(self.factor, plane.point_W)))

    def add_brick(self, brick: Brick, pose: Pose, velocity_W: Vec3 = AT_REST) -> None:
        resized = replace(brick, shape=scaled(brick.shape, self.factor), mass=self.factor**3 * brick.mass)
        self.engine.add_brick(resized, _put(pose, self.factor), scale(self.factor, velocity_W))
        self._bricks[brick.id] = brick
        self._weigh()

    def remove_brick(self, brick: BodyId) -> None:
        self.engine.remove_brick(brick)
        del self._bricks[brick]
        self._weigh()

    def _weigh(self) -> None:
        self._masses = {name: brick.mass for name, brick in self._bricks.items()}

    def freeze(self, brick: BodyId) -> None:
        self.engine.freeze(brick)

    def holds(self, brick: BodyId) -> bool:
        return self.engine.holds(brick)

    def wake(self, brick: BodyId) -> None:
        self.engine.wake(brick)

    def put_at(self, brick: BodyId, pose: Pose) -> None:
        self.engine.put_at(brick, _put(pose, self.factor))

    def set_state(self, brick: BodyId, state: BodyState) -> None:
        self.engine.set_state(brick, _moved(state, self.factor))

    def push(self, brick: BodyId, impulse_W: Vec3, at_W: Vec3) -> None:
        self.engine.push(brick, scale(self.factor**4, impulse_W), scale(self.factor, at_W))

    def apply_forces(self, brick: BodyId, forces: Sequence[AppliedForce]) -> None:
        self.engine.apply_forces(
            brick,
            [
                replace(force, force_W=scale(self.factor**4, force.force_W), at_W=scale(self.factor, force.at_W))
                for force in forces
            ],
        )

    def weld(self, bricks: Collection[BodyId]) -> None:
        self.engine.weld(bricks)

    def unweld(self, brick: BodyId) -> tuple[BodyId, ...]:
        return self.engine.unweld(brick)

    def wrong_friction(self) -> WrongFriction | None:
        return self.engine.wrong_friction()

    def close(self) -> None:
        self.engine.close()


def _put(pose: Pose, factor: float) -> Pose:
    return replace(pose, position_W=scale(factor, pose.position_W))


def _moved(state: BodyState, factor: float) -> BodyState:
    """Scale pose and velocity; angular velocities do not depend on lengths."""
    return replace(state, pose=_put(state.pose, factor), velocity_W=scale(factor, state.velocity_W))
