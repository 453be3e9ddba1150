"""PyBullet world with explicit settings, in which bricks can be welded.

The world owns its parts and delegates all work to them.
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field
from math import log10
from typing import Self, TypeAlias

from stability.contact_law import GivenFriction
from stability.dynamics.rigid_body import AppliedForce, pushed
from stability.engines.bodies import EngineWorld, OwnBodies
from stability.engines.protocol import NOTHING_PRESCRIBED, FrictionRecord, PrescribedMotion, WrongFriction
from stability.engines.pybullet.binding import pybullet
from stability.engines.pybullet.bodies import BodyMaker, BrickBodies, Planes
from stability.engines.pybullet.client import ClientBodies
from stability.engines.pybullet.contacts import ContactRefresher, EdgeMonitor, EdgeReshaper, Reshaper
from stability.engines.pybullet.friction import FrictionCones, PairFriction
from stability.engines.pybullet.groups import GuidedBricks, WeldedGroups
from stability.engines.pybullet.settings import PyBulletSettings
from stability.engines.pybullet.stepping import FreeFall, Stepper, engine_parameters
from stability.model import AT_REST, BodyId, BodyState, Brick, ContactPoint, Plane, Pose, Shape, Vec3

# [engine kg] Mass of the heaviest brick: far above the solver's thresholds, and the load of ten thousand bricks is
# far below its cap on impulses of 1e10.
HEAVIEST = 1e4

MakesReshaper: TypeAlias = Callable[[BrickBodies, WeldedGroups], Reshaper]


@dataclass
class PyBulletWorld(EngineWorld):
    """PyBullet world of bricks and planes; create it by `opened`, and close it after use."""

    settings: PyBulletSettings
    bricks: BrickBodies
    groups: WeldedGroups
    edges: EdgeMonitor
    cones: FrictionCones
    frictions: FrictionRecord = field(default_factory=FrictionRecord, init=False)
    guided: GuidedBricks = field(init=False)
    own: OwnBodies = field(init=False)
    bodies: ClientBodies = field(init=False)
    planes: Planes = field(init=False)
    stepper: Stepper = field(init=False)

    def __post_init__(self) -> None:
        self.own, self.bodies = self.bricks.own, self.bricks.bodies
        self.planes = self.bricks.planes
        self.clock = self.stepper = self.bricks.stepper
        self.guided = GuidedBricks(self.bricks)
        self.stepper.fall.before = self.guided.exert

    @classmethod
    def opened(
        cls,
        settings: PyBulletSettings,
        gravity: float,
        friction: GivenFriction,
        heaviest: float | None = None,
        reshaper: MakesReshaper = EdgeReshaper,
    ) -> Self:
        """Open an empty world with gravity [m/s2] along -z.

        Only the solver's absolute thresholds and its cap on impulses depend on the unit of mass, so with scaled
        settings `heaviest`, the largest mass of a brick [kg], sets it. `reshaper` selects sharp or rounded edges.
        """
        bodies = ClientBodies(_client(settings, gravity), {}, settings.scale, _mass_unit(settings, heaviest))
        own, maker = OwnBodies(), BodyMaker(bodies, settings, gravity, friction)
        stepper = Stepper(bodies.client, settings, FreeFall(bodies, gravity, settings.exact_fall))
        bricks = BrickBodies(own, bodies, maker, Planes(maker, own.planes), stepper)
        groups = WeldedGroups(bricks)
        edges = EdgeMonitor(bricks, reshaper(bricks, groups), ContactRefresher(bricks, groups))
        return cls(settings, bricks, groups, edges, FrictionCones(bricks, PairFriction(bricks, groups)))

    def wrong_friction(self) -> WrongFriction | None:
        return self.frictions.worst

    def close(self) -> None:
        pybullet.disconnect(self.bodies.client)

    def step(self, prescribed: PrescribedMotion = NOTHING_PRESCRIBED) -> None:
        self.stepper.fall.acceleration_W = prescribed.acceleration_W
        self.edges.look()
        self.guided.follow(prescribed.guided)
        if self.stepper.update(self.groups.mass_ratio):
            self.bricks.anchors.choose(self.stepper.lively)
            self.planes.choose(self.stepper.lively)
        self.cones.pairs.update(self.frictions)
        self.stepper.step()
        self.cones.look()

    def substep_next_contact(self) -> None:
        self.stepper.substep_next_contact()

    # --- queries ------------------------------------------------------------------------------------------------------

    def shape(self, body: BodyId) -> Shape:
        return self.own.shape(body) if body in self.own.bricks else self.planes.shape()

    def neighbours(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        return self.groups.neighbours(brick, within)

    def states(self, bodies: Collection[BodyId]) -> dict[BodyId, BodyState]:
        return self.groups.states(bodies)

    def contacts(self, brick: BodyId) -> Sequence[ContactPoint]:
        return self.groups.contacts(brick, self.time())

    # --- changes ------------------------------------------------------------------------------------------------------

    def add_plane(self, plane: Plane) -> None:
        self.own.add_plane(plane)
        self.planes.add(plane)

    def add_brick(self, brick: Brick, pose: Pose, velocity_W: Vec3 = AT_REST) -> None:
        self.bricks.add(brick, pose, velocity_W)

    def remove_brick(self, brick: BodyId) -> None:
        self.groups.part_from_others(brick)
        self.bricks.remove(brick)
        self.groups.forget_contacts()

    def freeze(self, brick: BodyId) -> None:
        self.groups.freeze(brick)

    def holds(self, brick: BodyId) -> bool:
        return self.groups.holds(brick)

    def wake(self, brick: BodyId) -> None:
        self.bricks.wake(brick)

    def put_at(self, brick: BodyId, pose: Pose) -> None:
        self.bricks.put_at(brick, pose)

    def set_state(self, brick: BodyId, state: BodyState) -> None:
        self.groups.part_from_others(brick)
        self.bricks.set_state(brick, state)

    def push(self, brick: BodyId, impulse_W: Vec3, at_W: Vec3) -> None:
        after = pushed(self.states([brick])[brick], self.own.bricks[brick], impulse_W, at_W)
        self.bodies.set_motion(brick, after.velocity_W, after.angular_velocity_W)
        if brick in self.stepper.fall.flying:
            self.bricks.on_woken(brick)

    def apply_forces(self, brick: BodyId, forces: Sequence[AppliedForce]) -> None:
        self.bricks.apply_forces(brick, forces)

    def weld(self, bricks: Collection[BodyId]) -> None:
        self.groups.weld(bricks)

    def unweld(self, brick: BodyId) -> tuple[BodyId, ...]:
        return self.groups.unweld(brick)


def _client(settings: PyBulletSettings, gravity: float) -> int:
    """Connect a client and set its parameters."""
    client = int(pybullet.connect(pybullet.DIRECT))
    if client < 0:
        raise RuntimeError("PyBullet accepts no more clients in this process")
    pybullet.setGravity(0.0, 0.0, -gravity, client)
    pybullet.setPhysicsEngineParameter(**engine_parameters(settings), physicsClientId=client)
    return client


def _mass_unit(settings: PyBulletSettings, heaviest: float | None) -> float:
    """Return the engine kilograms per scene kilogram."""
    if heaviest is None or settings.scale == 1.0:
        return 1.0
    return float(10.0 ** round(log10(HEAVIEST / heaviest)))
